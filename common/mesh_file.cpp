#include "common/mesh_file.h"

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "common/input_error.h"

namespace lockstep {

Mesh read_mesh(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::ranges::transform(extension, extension.begin(), [](unsigned char c) { return std::tolower(c); });
  if (extension == ".obj") return read_obj(path);
  if (extension == ".off") return read_off(path);
  if (extension == ".ply") return read_ply(path);
  if (extension == ".stl") return read_stl(path);
  throw InputError(path + ": expected a file .obj, .off, .ply or .stl");
}

}  // namespace lockstep
