#include "common/linear/matrix_market.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string_view>
#include <tuple>
#include <vector>

#include "common/input_error.h"
#include "common/input_file.h"
#include "common/memory.h"
#include "common/words.h"

namespace lockstep::linear {
namespace {

// An entry takes six bytes of the file at the least, and twice 24 in memory where it is mirrored, more as lists grow.
constexpr double bytes_per_byte = 16;
constexpr std::int64_t most_rows = std::numeric_limits<std::int32_t>::max() - 64;

// The lines of a file that are neither blank nor comments, with their numbers.
class Lines {
 public:
  explicit Lines(const std::string& path) : path_(path), in_(open_input(path)) {
    require_memory(bytes_per_byte * static_cast<double>(std::filesystem::file_size(path)), path + ": reading it");
  }

  // The words of the next line that is neither blank nor a comment; false after the last.
  bool next(std::vector<std::string_view>& words) {
    words.clear();
    while (words.empty() && std::getline(in_, line_)) {
      ++number_;
      if (number_ > 1 && line_.starts_with('%')) continue;
      constexpr std::string_view blanks = " \t\r";
      for (std::size_t at = 0; (at = line_.find_first_not_of(blanks, at)) != line_.npos;) {
        const std::size_t end = std::min(line_.find_first_of(blanks, at), line_.size());
        words.push_back(std::string_view(line_).substr(at, end - at));
        at = end;
      }
    }
    return !words.empty();
  }

  std::int32_t number() const { return number_; }  // of the line read last, from 1

  // Throws InputError: the line read last, or the end of the file, is not what was expected.
  [[noreturn]] void refuse(const std::string& expected) const {
    throw InputError(path_ + ":" + std::to_string(number_) + ": expected " + expected + ", not \"" + legible(line_) +
                     "\"");
  }
  [[noreturn]] void refuse_end(const std::string& expected) const {
    throw InputError(path_ + ":" + std::to_string(number_ + 1) + ": expected " + expected +
                     ", not the end of the file");
  }

 private:
  std::string path_;
  std::ifstream in_;
  std::string line_;
  std::int32_t number_ = 0;
};

std::optional<std::int32_t> index_up_to(std::string_view word, std::int64_t most) {
  const std::optional<std::int64_t> i = as<std::int64_t>(word);
  return i && *i >= 1 && *i <= most ? std::optional(static_cast<std::int32_t>(*i)) : std::nullopt;
}

struct Entry {
  std::int32_t row, column;
  float value;
  std::int32_t line;
};

// Entries are sorted by row, then by column; of an entry that is there twice, the earlier line comes first.
std::tuple<std::int32_t, std::int32_t, std::int32_t> key(const Entry& e) { return {e.row, e.column, e.line}; }

bool read_header(Lines& lines) {
  constexpr const char* expected = "%%MatrixMarket matrix coordinate, then real or integer, then general or symmetric";
  std::vector<std::string_view> words;
  if (!lines.next(words)) lines.refuse_end(expected);
  std::vector<std::string> lower(words.begin(), words.end());
  for (std::string& word : lower)
    std::transform(word.begin(), word.end(), word.begin(), [](char c) { return c >= 'A' && c <= 'Z' ? c + 32 : c; });
  if (lower.size() != 5 || lower[0] != "%%matrixmarket" || lower[1] != "matrix" || lower[2] != "coordinate" ||
      (lower[3] != "real" && lower[3] != "integer") || (lower[4] != "general" && lower[4] != "symmetric"))
    lines.refuse(expected);
  return lower[4] == "symmetric";
}

Rows<float> rows_of(std::vector<Entry>& entries, int rows, int columns, const std::string& path) {
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return key(a) < key(b); });
  Rows<float> a;
  a.rows = rows, a.columns = columns;
  a.begin.reserve(static_cast<std::size_t>(rows) + 1);
  a.column.reserve(entries.size()), a.value.reserve(entries.size());
  std::size_t at = 0;
  for (int i = 0; i < rows; ++i) {
    for (; at < entries.size() && entries[at].row == i; ++at) {
      if (at > 0 && entries[at - 1].row == i && entries[at - 1].column == entries[at].column)
        throw InputError(path + ":" + std::to_string(entries[at].line) + ": expected each entry once, not row " +
                         std::to_string(i + 1) + ", column " + std::to_string(entries[at].column + 1) + " twice");
      a.column.push_back(entries[at].column), a.value.push_back(entries[at].value);
    }
    a.begin.push_back(static_cast<std::int32_t>(a.column.size()));
  }
  return a;
}

}  // namespace

MarketMatrix read_matrix_market(const std::string& path) {
  Lines lines(path);
  const bool symmetric = read_header(lines);
  std::vector<std::string_view> words;
  const std::string sizes = "the numbers of rows, of columns and of entries";
  if (!lines.next(words)) lines.refuse_end(sizes);
  const std::optional<std::int32_t> rows = index_up_to(words[0], most_rows);
  const std::optional<std::int32_t> columns = words.size() == 3 ? index_up_to(words[1], most_rows) : std::nullopt;
  const std::optional<std::int64_t> count = words.size() == 3 ? as<std::int64_t>(words[2]) : std::nullopt;
  if (!rows || !columns || !count || *count < 0) lines.refuse(sizes);
  if (symmetric && *rows != *columns) lines.refuse("as many rows as columns of a symmetric matrix");
  if (*count > most_rows / 2) lines.refuse("at most " + std::to_string(most_rows / 2) + " entries");
  require_memory(8. * *rows, path + ": " + std::to_string(*rows) + " rows");

  std::vector<Entry> entries;
  for (std::int64_t k = 0; k < *count; ++k) {
    const std::string expected =
        "row (1 .. " + std::to_string(*rows) + "), column (1 .. " + std::to_string(*columns) + ") and value";
    if (!lines.next(words)) lines.refuse_end(expected + " of entry " + std::to_string(k + 1));
    const std::optional<std::int32_t> row = index_up_to(words[0], *rows);
    const std::optional<std::int32_t> column = words.size() == 3 ? index_up_to(words[1], *columns) : std::nullopt;
    const std::optional<double> value = words.size() == 3 ? as<double>(words[2]) : std::nullopt;
    if (!row || !column || !value) lines.refuse(expected);
    if (!(std::abs(*value) <= std::numeric_limits<float>::max())) lines.refuse("a value that a float can hold");
    if (symmetric && *column > *row) lines.refuse("entries on or below the diagonal of a symmetric matrix");
    const float rounded = static_cast<float>(*value);
    entries.push_back({*row - 1, *column - 1, rounded, lines.number()});
    if (symmetric && *column < *row) entries.push_back({*column - 1, *row - 1, rounded, lines.number()});
  }
  if (lines.next(words)) lines.refuse("no more than " + std::to_string(*count) + " entries");
  return {rows_of(entries, *rows, *columns, path), symmetric};
}

}  // namespace lockstep::linear
