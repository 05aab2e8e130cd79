// Files that are written whole or not at all.
#pragma once

#include <functional>
#include <ostream>
#include <string>

namespace lockstep {

// Calls write(out) on a temporary file beside `path` (path + ".tmp~"), then renames it to `path`, so that nobody ever
// sees half a file. Throws InputError with the system's reason where that cannot be done: `path` is then as it was, and
// the temporary gone. What stands at `path` is replaced if it is a regular file; a directory or a device is refused.
void write_file(const std::string& path, const std::function<void(std::ostream& out)>& write);

}  // namespace lockstep
