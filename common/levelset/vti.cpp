#include "common/levelset/vti.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <ostream>
#include <vector>

#include "common/atomic_file.h"
#include "common/input_error.h"
#include "common/vtk_words.h"

namespace lockstep::levelset {
namespace {

std::string digits(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", x);
  return text;
}

std::string digits(const Vector3<double>& v) { return digits(v.x) + ' ' + digits(v.y) + ' ' + digits(v.z); }

// The field in the order of the file: line by line along x, without padding.
void for_each_line(const Field<float>& field, float band, const std::function<void(const std::vector<float>& line)>& write) {
  std::vector<float> line(field.nx);
  for (int z = 0; z < field.nz; ++z)
    for (int y = 0; y < field.ny; ++y) {
      std::transform(&field(0, y, z), &field(0, y, z) + field.nx, line.begin(), [&](float phi) { return std::clamp(phi, -band, band); });
      write(line);
    }
}

void write_xml(std::ostream& out, const Field<float>& field, const Grid& grid, float band) {
  static_assert(std::endian::native == std::endian::little, "numbers are written as they stand in memory");
  const auto last = [](int n) { return "0 " + std::to_string(n - 1); };
  const std::string extent = last(field.nx) + ' ' + last(field.ny) + ' ' + last(field.nz);
  const std::uint64_t bytes = sizeof(float) * field.nx * field.ny * field.nz;
  out << "<?xml version=\"1.0\"?>\n"
      << "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
      << "<ImageData WholeExtent=\"" << extent << "\" Origin=\"" << digits(grid.position(0, 0, 0)) << "\" Spacing=\""
      << digits({grid.spacing, grid.spacing, grid.spacing}) << "\">\n"
      << "<Piece Extent=\"" << extent << "\">\n<PointData Scalars=\"phi\">\n"
      << "<DataArray type=\"Float32\" Name=\"phi\" format=\"appended\" offset=\"0\"/>\n"
      << "</PointData>\n</Piece>\n</ImageData>\n<AppendedData encoding=\"raw\">\n_";
  out.write(reinterpret_cast<const char*>(&bytes), sizeof bytes);
  for_each_line(field, band, [&](const std::vector<float>& line) {
    out.write(reinterpret_cast<const char*>(line.data()), static_cast<std::streamsize>(sizeof(float) * line.size()));
  });
  out << "\n</AppendedData>\n</VTKFile>\n";
}

void write_legacy(std::ostream& out, const Field<float>& field, const Grid& grid, float band) {
  out << "# vtk DataFile Version 3.0\nLockstep level set\nBINARY\nDATASET STRUCTURED_POINTS\n"
      << "DIMENSIONS " << field.nx << ' ' << field.ny << ' ' << field.nz << '\n'
      << "ORIGIN " << digits(grid.position(0, 0, 0)) << '\n'
      << "SPACING " << digits({grid.spacing, grid.spacing, grid.spacing}) << '\n'
      << "POINT_DATA " << static_cast<std::int64_t>(field.nx) * field.ny * field.nz << "\nSCALARS phi float 1\nLOOKUP_TABLE default\n";
  for_each_line(field, band, [&](const std::vector<float>& line) {
    std::string words;
    for (const float phi : line) append_word(words, phi);
    out << words;
  });
  out << '\n';
}

}  // namespace

void write_image(const std::string& path, const Field<float>& signed_distance, const Grid& grid, float band) {
  const std::string extension = std::filesystem::path(path).extension().string();
  if (extension != ".vti" && extension != ".vtk") throw InputError(path + ": expected a name that ends in .vti or .vtk");
  write_file(path, [&](std::ostream& out) { (extension == ".vti" ? write_xml : write_legacy)(out, signed_distance, grid, band); });
}

}  // namespace lockstep::levelset
