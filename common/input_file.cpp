#include "common/input_file.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "common/input_error.h"

namespace lockstep {

std::ifstream open_input(const std::string& path) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (error) throw InputError(path + ": cannot be read: " + error.message());
  if (is_directory(status)) throw InputError(path + ": is a directory, expected a file");
  if (!is_regular_file(status)) throw InputError(path + ": is not a regular file");
  std::ifstream in(path, std::ios::binary);
  if (!in) throw InputError(path + ": cannot be read: " + std::strerror(errno));
  return in;
}

std::string legible(std::string_view text) {
  constexpr std::size_t most = 160;
  std::string line(text.substr(0, most));
  for (char& c : line)
    if (c < ' ' || c > '~') c = '?';
  return text.size() > most ? line + "..." : line;
}

}  // namespace lockstep
