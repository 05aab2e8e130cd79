#include "common/atomic_file.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "common/input_error.h"

namespace lockstep {

void write_file(const std::string& path, const std::function<void(std::ostream& out)>& write) {
  const auto refuse = [&](const std::string& why) { throw InputError(path + ": cannot be written: " + why); };

  // A rename would happily replace /dev/null.
  std::error_code no_error;
  const std::filesystem::file_status status = std::filesystem::status(path, no_error);
  if (exists(status) && !is_regular_file(status)) refuse("not a regular file");

  const std::string temporary = path + ".tmp~";
  std::ofstream out(temporary, std::ios::binary);
  if (!out) refuse(std::strerror(errno));
  try {
    write(out);
    out.close();
    if (!out || std::rename(temporary.c_str(), path.c_str()) != 0) refuse(std::strerror(errno));
  } catch (...) {
    std::remove(temporary.c_str());
    throw;
  }
}

}  // namespace lockstep
