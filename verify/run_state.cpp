// Format: three lines (format, run, frame); each array as its length in bytes and its bytes; last a hash of everything
// before.
#include "verify/run_state.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string_view>

#include "common/atomic_file.h"
#include "common/input_error.h"
#include "common/input_file.h"
#include "verify/compare.h"

namespace lockstep::verify {
namespace {

const std::string format = "lockstep state 1";

template <class T>
T take(std::string_view& text) {
  T value;
  std::memcpy(&value, text.data(), sizeof value);
  text.remove_prefix(sizeof value);
  return value;
}

std::string take_line(std::string_view& text) {
  const std::string line(text.substr(0, text.find('\n')));
  text.remove_prefix(line.size() + 1);
  return line;
}

// The number of arrays that `text` holds.
std::size_t arrays_in(std::string_view text) {
  std::size_t count = 0;
  for (; !text.empty(); ++count) text.remove_prefix(take<std::uint64_t>(text));
  return count;
}

}  // namespace

void write_state(const std::string& path, const std::string& run, int frame, const std::vector<Kept>& state) {
  write_file(path, [&](std::ostream& out) {
    std::uint64_t hash = hash_bytes(std::span<const char>());
    const auto write = [&](std::span<const std::byte> bytes) {
      out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
      hash = hash_bytes(bytes, hash);
    };
    const std::string head = format + '\n' + run + '\n' + std::to_string(frame) + '\n';
    write(std::as_bytes(std::span(head)));
    for (const Kept& array : state) {
      const std::span<const std::byte> bytes = array.bytes();
      const std::uint64_t size[] = {bytes.size()};
      write(std::as_bytes(std::span(size)));
      write(bytes);
    }
    const std::uint64_t all[] = {hash};
    write(std::as_bytes(std::span(all)));
  });
}

int read_state(const std::string& path, const std::string& run, const std::vector<Kept>& state) {
  std::ifstream in = open_input(path);
  const std::string text{std::istreambuf_iterator<char>(in), {}};

  // A correct hash means that the rest of the file is as it was written.
  std::string_view rest(text);
  if (!rest.starts_with(format + '\n'))
    throw InputError(path + ": not the state of a run that this version of lockstep reads");
  std::string_view hash = rest.substr(rest.size() - std::min(rest.size(), sizeof(std::uint64_t)));
  rest.remove_suffix(hash.size());
  if (hash.size() < sizeof(std::uint64_t) || take<std::uint64_t>(hash) != hash_bytes(std::span<const char>(rest)))
    throw InputError(path + ": damaged: not what was written");

  take_line(rest);
  if (const std::string other = take_line(rest); other != run)
    throw InputError(path + ": of another run, " + other + "; expected " + run);
  const int frame = std::stoi(take_line(rest));
  if (arrays_in(rest) != state.size())
    throw InputError(path + ": of a version of lockstep that kept other arrays; a run begins anew without --resume");
  for (const Kept& array : state) {
    const std::span<std::byte> room = array.room(take<std::uint64_t>(rest));
    std::ranges::copy(std::as_bytes(std::span(rest).first(room.size())), room.begin());
    rest.remove_prefix(room.size());
  }
  return frame;
}

std::string run_of_state(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::string line;
  return std::getline(in, line) && line == format && std::getline(in, line) ? line : "";
}

}  // namespace lockstep::verify
