// Images of the level set: the bytes of both formats.
#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <limits>

#include "common/levelset/vti.h"
#include "tests/levelset_fields.h"
#include "tests/temporary_folder.h"

namespace lockstep::levelset {
namespace {

struct LevelsetImageTest : TemporaryFolder {
  const Grid grid{.nx = 3, .ny = 2, .nz = 2, .spacing = .25, .origin = {1, 2, 3}};
  const Field<float> field =
      field_of<float>(3, 2, 2, .25f, [](int x, int y, int z) { return (x - 1) * 1.5 + 10 * y - 100 * z; });
  const std::vector<float> clamped{-1.5, 0, 1.5, 2, 2, 2, -2, -2, -2, -2, -2, -2};
};

TEST_F(LevelsetImageTest, WritesXml) {
  write_image(path("a.vti"), field, grid, 2);
  const std::string bytes = read_bytes(path("a.vti")), begin = "<AppendedData encoding=\"raw\">\n_",
                    end = "\n</AppendedData>\n</VTKFile>\n";
  const std::size_t data = bytes.find(begin) + begin.size();
  EXPECT_EQ(bytes.substr(0, data),
            "<?xml version=\"1.0\"?>\n"
            "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
            "<ImageData WholeExtent=\"0 2 0 1 0 1\" Origin=\"1.125 2.125 3.125\" Spacing=\"0.25 0.25 0.25\">\n"
            "<Piece Extent=\"0 2 0 1 0 1\">\n<PointData Scalars=\"phi\">\n"
            "<DataArray type=\"Float32\" Name=\"phi\" format=\"appended\" offset=\"0\"/>\n"
            "</PointData>\n</Piece>\n</ImageData>\n" +
                begin);
  std::uint64_t size;
  std::vector<float> values(12);
  ASSERT_EQ(bytes.size(), data + sizeof size + 48 + end.size());
  std::memcpy(&size, &bytes[data], sizeof size);
  EXPECT_EQ(size, 48u);
  std::memcpy(values.data(), &bytes[data + sizeof size], 48);
  EXPECT_EQ(values, clamped);
  EXPECT_EQ(bytes.substr(data + sizeof size + 48), end);
}

TEST_F(LevelsetImageTest, WritesLegacy) {
  write_image(path("a.vtk"), field, grid, 2);
  const std::string bytes = read_bytes(path("a.vtk")), begin = "LOOKUP_TABLE default\n";
  const std::size_t data = bytes.find(begin) + begin.size();
  EXPECT_EQ(bytes.substr(0, data),
            "# vtk DataFile Version 3.0\nLockstep level set\nBINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS 3 2 2\n"
            "ORIGIN 1.125 2.125 3.125\nSPACING 0.25 0.25 0.25\nPOINT_DATA 12\nSCALARS phi float 1\n" +
                begin);
  ASSERT_EQ(bytes.size(), data + 48 + 1);
  std::vector<float> values;
  for (std::size_t i = data; i < data + 48; i += 4) {
    std::uint32_t word = 0;
    for (int k = 0; k < 4; ++k) word = word << 8 | static_cast<unsigned char>(bytes[i + k]);
    values.push_back(std::bit_cast<float>(word));
  }
  EXPECT_EQ(values, clamped);
  EXPECT_EQ(bytes.back(), '\n');
}

TEST_F(LevelsetImageTest, ClampsNothingWithoutABand) {
  write_image(path("a.vti"), field, grid, std::numeric_limits<float>::infinity());
  const std::string bytes = read_bytes(path("a.vti"));
  float last;
  std::memcpy(&last, &bytes[bytes.find("\n</AppendedData>") - sizeof last], sizeof last);
  EXPECT_EQ(last, 1.5f + 10 - 100);
}

TEST_F(LevelsetImageTest, WritesTheWholeFileOrNothing) {
  for (const std::string name : {"a.raw", "a", "a.vti.gz"})
    EXPECT_EQ(error_of([&] { write_image(path(name), field, grid, 2); }),
              path(name) + ": expected a name that ends in .vti or .vtk");
  EXPECT_EQ(error_of([&] { write_image(path("none/a.vti"), field, grid, 2); }),
            path("none/a.vti") + ": cannot be written: No such file or directory");
  EXPECT_EQ(files(), 0);
}

}  // namespace
}  // namespace lockstep::levelset
