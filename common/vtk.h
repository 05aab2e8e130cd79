// Files for ParaView: points with cells between them, meshes of one kind of cell, and images.
//
// A caller describes a file; what it describes is asked for as the file is written, a section at a time. Legacy VTK
// files have version 3.0: lines of text, and after some of them numbers as big-endian words. Each write throws
// InputError where the file cannot be written, and then leaves nothing behind.
//
// Files hold no times, which ParaView does not read from legacy files: a series of files has them.
//
// Source: VTK File Formats, in The VTK User's Guide, Kitware; series: ParaView, "JSON based new meta file format for
// series added".
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "common/vector3.h"

namespace lockstep::vtk {

// The numbers of a section.
struct Words {
  std::string bytes;

  void add(std::int32_t x);
  void add(float x);
  void add(const Vector3<float>& v) { add(v.x), add(v.y), add(v.z); }
};

// Adds all numbers of a section.
using Fill = std::function<void(Words& words)>;

// The elements of an array, which must live until the file is written.
template <class Array>
Fill each(const Array& array) {
  return [&array](Words& words) {
    for (const auto& x : array) words.add(x);
  };
}

enum class Type { ints, floats, vectors, quaternions };

// A number, three or four a point, or a cell. VTK's quaternions begin with w.
struct Values {
  std::string name;
  Type type;
  Fill fill;
};

// Cells are added as the number of their corners, then the corners, points counted from 0.
struct Cells {
  std::int64_t count = 0, corners = 0;  // corners of all cells
  Fill fill;
};

struct PolyData {
  std::string title;
  std::int64_t points = 0;
  Fill positions;  // m, a vector a point
  Cells vertices = {}, lines = {}, polygons = {};
  std::vector<Values> point_data = {}, cell_data = {};
};
void write(const std::string& path, const PolyData& data);

// Numbers as in the format.
enum class CellType : std::int32_t { triangle = 5, tetrahedron = 10, hexahedron = 12 };

struct UnstructuredGrid {
  std::string title;
  std::int64_t points = 0;
  Fill positions;
  CellType type;  // of all cells
  Cells cells;
  std::vector<Values> point_data = {}, cell_data = {};
};
void write(const std::string& path, const UnstructuredGrid& data);

// One number a point of a grid.
struct Image {
  std::string title, name;                                   // of the file, of the numbers
  std::array<int, 3> points;                                 // along x, y, z
  Vector3<double> origin;                                    // m, of point (0, 0, 0)
  double spacing;                                            // m
  std::function<std::span<const float>(int y, int z)> line;  // the numbers along x, good until the next call
};

// By the end of the path: `.vti` is VTK's XML with the numbers in binary, `.vtk` a legacy file. Throws InputError where
// the path ends otherwise.
void write(const std::string& path, const Image& image);

// A file of a series, beside the series' own file, and its time.
struct Moment {
  std::string name;
  double time;  // s
};
// ParaView opens a `.vtk.series` as one set of data that changes with time.
void write_series(const std::string& path, const std::vector<Moment>& moments);

}  // namespace lockstep::vtk
