// common/vtk.h: the bytes of each kind of file. (tests/frames_test.py reads files by VTK's own readers.) What the
// domains write is tested with their scenes.

#include "common/vtk.h"

#include <gtest/gtest.h>

#include <bit>
#include <limits>
#include <vector>

#include "common/input_error.h"
#include "tests/temporary_folder.h"

namespace lockstep::vtk {
namespace {

using VtkTest = TemporaryFolder;

// Bytes of each number, the most significant first, then the end of a section.
template <class... Numbers>
std::string big_endian(Numbers... numbers) {
  std::string bytes;
  const auto append = [&](auto x) {
    const auto word = std::bit_cast<std::array<char, sizeof x>>(x);
    bytes.append(word.rbegin(), word.rend());
  };
  (append(numbers), ...);
  return bytes + '\n';
}

const std::vector<Vector3<float>> square = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, .5f}};
const std::string square_words =
    "POINTS 4 float\n" + big_endian(0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 1.f, 1.f, 0.f, 0.f, 1.f, .5f);

TEST_F(VtkTest, PolyDataHasAllKindsOfCells) {
  const std::vector<std::int32_t> vertex = {1, 3}, line = {3, 0, 1, 2}, polygons = {3, 0, 1, 2, 3, 0, 2, 3},
                                  body = {7, 8, 9, 10};
  const std::vector<float> speed = {.5f, 1, 2, 3};
  write(path("a.vtk"),
        PolyData{.title = "A test",
                 .points = 4,
                 .positions = each(square),
                 .vertices = {1, 1, each(vertex)},
                 .lines = {1, 3, each(line)},
                 .polygons = {2, 6, each(polygons)},
                 .point_data = {{"velocity", Type::vectors, each(square)}, {"speed", Type::floats, each(speed)}},
                 .cell_data = {{"body", Type::ints, each(body)}}});
  EXPECT_EQ(read_bytes(path("a.vtk")),
            "# vtk DataFile Version 3.0\nA test\nBINARY\nDATASET POLYDATA\n" + square_words + "VERTICES 1 2\n" +
                big_endian(1, 3) + "LINES 1 4\n" + big_endian(3, 0, 1, 2) + "POLYGONS 2 8\n" +
                big_endian(3, 0, 1, 2, 3, 0, 2, 3) + "CELL_DATA 4\nSCALARS body int 1\nLOOKUP_TABLE default\n" +
                big_endian(7, 8, 9, 10) + "POINT_DATA 4\nVECTORS velocity float\n" +
                square_words.substr(square_words.find('\n') + 1) + "SCALARS speed float 1\nLOOKUP_TABLE default\n" +
                big_endian(.5f, 1.f, 2.f, 3.f));
}

TEST_F(VtkTest, UnstructuredGridHasCellsOfOneType) {
  const std::vector<std::int32_t> tetrahedron = {4, 0, 1, 2, 3};
  const std::vector<float> pressure = {-1};
  UnstructuredGrid grid;
  grid.title = "A test";
  grid.points = 4;
  grid.positions = each(square);
  grid.type = CellType::tetrahedron;
  grid.cells = {1, 4, each(tetrahedron)};
  grid.cell_data.push_back({"pressure", Type::floats, each(pressure)});
  write(path("a.vtk"), grid);
  EXPECT_EQ(read_bytes(path("a.vtk")),
            "# vtk DataFile Version 3.0\nA test\nBINARY\nDATASET UNSTRUCTURED_GRID\n" + square_words + "CELLS 1 5\n" +
                big_endian(4, 0, 1, 2, 3) + "CELL_TYPES 1\n" + big_endian(10) +
                "CELL_DATA 1\nSCALARS pressure float 1\nLOOKUP_TABLE default\n" + big_endian(-1.f));
}

TEST_F(VtkTest, ImagesHaveTheirPlaceInBothFormats) {
  const std::vector<float> numbers = {1, 2, 3, 4, 5, 6, 7, 8};
  const Image image{.title = "A test",
                    .name = "phi",
                    .points = {2, 2, 2},
                    .origin = {0, 1, 2},
                    .spacing = .5,
                    .line = [&](int y, int z) { return std::span(numbers).subspan(4 * z + 2 * y, 2); }};
  write(path("a.vtk"), image);
  EXPECT_EQ(read_bytes(path("a.vtk")),
            "# vtk DataFile Version 3.0\nA test\nBINARY\nDATASET STRUCTURED_POINTS\n"
            "DIMENSIONS 2 2 2\nORIGIN 0 1 2\nSPACING 0.5 0.5 0.5\nPOINT_DATA 8\nSCALARS phi float 1\n"
            "LOOKUP_TABLE default\n" +
                big_endian(1.f, 2.f, 3.f, 4.f, 5.f, 6.f, 7.f, 8.f));
  write(path("a.vti"), image);
  EXPECT_NE(read_bytes(path("a.vti")).find("Origin=\"0 1 2\" Spacing=\"0.5 0.5 0.5\">\n<Piece"), std::string::npos);
}

TEST_F(VtkTest, QuaternionsAreFourNumbersAPoint) {
  const std::vector<float> numbers = {1, 0, 0, 0, .5f, .5f, .5f, -.5f};
  write(path("a.vtk"),
        PolyData{.title = "A test",
                 .points = 2,
                 .positions = [](Words& words) { words.add(Vector3<float>{}), words.add(Vector3<float>{}); },
                 .point_data = {{"turn", Type::quaternions, each(numbers)}}});
  EXPECT_TRUE(read_bytes(path("a.vtk"))
                  .ends_with("POINT_DATA 2\nSCALARS turn float 4\nLOOKUP_TABLE default\n" +
                             big_endian(1.f, 0.f, 0.f, 0.f, .5f, .5f, .5f, -.5f)));
}

TEST_F(VtkTest, SeriesHaveNamesAndTimes) {
  write_series(path("a.vtk.series"), {{"a_0.vtk", 0}, {"a_1.vtk", .1}});
  EXPECT_EQ(read_bytes(path("a.vtk.series")),
            "{\"file-series-version\":\"1.0\",\"files\":[{\"name\":\"a_0.vtk\",\"time\":0.0},"
            "{\"name\":\"a_1.vtk\",\"time\":0.1}]}\n");
}

TEST_F(VtkTest, WritesTheWholeFileOrNothing) {
  const auto none = [](int, int) { return std::span<const float>(); };
  EXPECT_EQ(error_of([&] { write(path("none/a.vtk"), PolyData{.title = "", .positions = each(square)}); }),
            path("none/a.vtk") + ": cannot be written: No such file or directory");
  EXPECT_EQ(error_of([&] {
              write(
                  path("a.raw"),
                  Image{.title = "", .name = "", .points = {0, 0, 0}, .origin = {0, 0, 0}, .spacing = 1, .line = none});
            }),
            path("a.raw") + ": expected a name that ends in .vti or .vtk");
  EXPECT_EQ(files(), 0);
}

}  // namespace
}  // namespace lockstep::vtk
