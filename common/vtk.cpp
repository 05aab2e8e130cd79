#include "common/vtk.h"

#include <bit>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <ostream>
#include <string_view>

#include "common/atomic_file.h"
#include "common/digits.h"
#include "common/input_error.h"

namespace lockstep::vtk {
namespace {

void add_word(std::string& bytes, std::uint32_t word) {
  for (const int shift : {24, 16, 8, 0}) bytes += static_cast<char>(word >> shift);
}

void write_head(std::ostream& out, const std::string& title, std::string_view dataset) {
  out << "# vtk DataFile Version 3.0\n" << title << "\nBINARY\nDATASET " << dataset << '\n';
}

void write_section(std::ostream& out, const Fill& fill) {
  Words words;
  fill(words);
  out << words.bytes << '\n';
}

void write_points(std::ostream& out, std::int64_t points, const Fill& positions) {
  out << "POINTS " << points << " float\n";
  write_section(out, positions);
}

void write_cells(std::ostream& out, std::string_view kind, const Cells& cells) {
  if (cells.count == 0) return;
  out << kind << ' ' << cells.count << ' ' << cells.count + cells.corners << '\n';
  write_section(out, cells.fill);
}

void write_values(std::ostream& out, std::string_view of, std::int64_t count, const std::vector<Values>& data) {
  if (data.empty()) return;
  out << of << ' ' << count << '\n';
  for (const auto& [name, type, fill] : data) {
    if (type == Type::vectors)
      out << "VECTORS " << name << " float\n";
    else
      out << "SCALARS " << name << (type == Type::ints ? " int " : " float ") << (type == Type::quaternions ? 4 : 1)
          << "\nLOOKUP_TABLE default\n";
    write_section(out, fill);
  }
}

std::int64_t count_points(const Image& image) {
  const auto [nx, ny, nz] = image.points;
  return std::int64_t{nx} * ny * nz;
}

template <class Write>
void for_each_line(const Image& image, Write write) {
  for (int z = 0; z < image.points[2]; ++z)
    for (int y = 0; y < image.points[1]; ++y) write(image.line(y, z));
}

std::string three(double x, double y, double z) {
  return digits_of(x, 9) + ' ' + digits_of(y, 9) + ' ' + digits_of(z, 9);
}
std::string origin_of(const Image& image) { return three(image.origin.x, image.origin.y, image.origin.z); }
std::string spacing_of(const Image& image) { return three(image.spacing, image.spacing, image.spacing); }

void write_xml(std::ostream& out, const Image& image) {
  static_assert(std::endian::native == std::endian::little, "numbers are written as they stand in memory");
  const auto last = [&](int axis) { return "0 " + std::to_string(image.points[axis] - 1); };
  const std::string extent = last(0) + ' ' + last(1) + ' ' + last(2);
  const std::uint64_t bytes = sizeof(float) * count_points(image);
  out << "<?xml version=\"1.0\"?>\n"
      << "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
      << "<ImageData WholeExtent=\"" << extent << "\" Origin=\"" << origin_of(image) << "\" Spacing=\""
      << spacing_of(image) << "\">\n"
      << "<Piece Extent=\"" << extent << "\">\n<PointData Scalars=\"" << image.name << "\">\n"
      << "<DataArray type=\"Float32\" Name=\"" << image.name << "\" format=\"appended\" offset=\"0\"/>\n"
      << "</PointData>\n</Piece>\n</ImageData>\n<AppendedData encoding=\"raw\">\n_";
  out.write(reinterpret_cast<const char*>(&bytes), sizeof bytes);
  for_each_line(image, [&](std::span<const float> line) {
    out.write(reinterpret_cast<const char*>(line.data()), static_cast<std::streamsize>(line.size_bytes()));
  });
  out << "\n</AppendedData>\n</VTKFile>\n";
}

void write_legacy(std::ostream& out, const Image& image) {
  write_head(out, image.title, "STRUCTURED_POINTS");
  out << "DIMENSIONS " << image.points[0] << ' ' << image.points[1] << ' ' << image.points[2] << '\n'
      << "ORIGIN " << origin_of(image) << '\n'
      << "SPACING " << spacing_of(image) << '\n'
      << "POINT_DATA " << count_points(image) << "\nSCALARS " << image.name << " float 1\nLOOKUP_TABLE default\n";
  for_each_line(image, [&](std::span<const float> line) {
    Words words;
    for (const float x : line) words.add(x);
    out << words.bytes;
  });
  out << '\n';
}

}  // namespace

void Words::add(std::int32_t x) { add_word(bytes, std::bit_cast<std::uint32_t>(x)); }
void Words::add(float x) { add_word(bytes, std::bit_cast<std::uint32_t>(x)); }

void write(const std::string& path, const PolyData& data) {
  write_file(path, [&](std::ostream& out) {
    write_head(out, data.title, "POLYDATA");
    write_points(out, data.points, data.positions);
    write_cells(out, "VERTICES", data.vertices);
    write_cells(out, "LINES", data.lines);
    write_cells(out, "POLYGONS", data.polygons);
    const std::int64_t cells = data.vertices.count + data.lines.count + data.polygons.count;
    write_values(out, "CELL_DATA", cells, data.cell_data);
    write_values(out, "POINT_DATA", data.points, data.point_data);
  });
}

void write(const std::string& path, const UnstructuredGrid& data) {
  write_file(path, [&](std::ostream& out) {
    write_head(out, data.title, "UNSTRUCTURED_GRID");
    write_points(out, data.points, data.positions);
    write_cells(out, "CELLS", data.cells);
    const auto add_types = [&](Words& words) {
      for (std::int64_t c = 0; c < data.cells.count; ++c) words.add(static_cast<std::int32_t>(data.type));
    };
    out << "CELL_TYPES " << data.cells.count << '\n';
    write_section(out, add_types);
    write_values(out, "CELL_DATA", data.cells.count, data.cell_data);
    write_values(out, "POINT_DATA", data.points, data.point_data);
  });
}

void write(const std::string& path, const Image& image) {
  const std::string extension = std::filesystem::path(path).extension().string();
  if (extension != ".vti" && extension != ".vtk")
    throw InputError(path + ": expected a name that ends in .vti or .vtk");
  write_file(path, [&](std::ostream& out) { (extension == ".vti" ? write_xml : write_legacy)(out, image); });
}

void write_series(const std::string& path, const std::vector<Moment>& moments) {
  nlohmann::ordered_json files = nlohmann::ordered_json::array();
  for (const auto& [name, time] : moments) files.push_back({{"name", name}, {"time", time}});
  const nlohmann::ordered_json series = {{"file-series-version", "1.0"}, {"files", files}};
  write_file(path, [&](std::ostream& out) { out << series.dump() << '\n'; });
}

}  // namespace lockstep::vtk
