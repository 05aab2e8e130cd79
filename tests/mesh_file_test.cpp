// common/mesh_file.h: the same mesh in every format, and files that are refused, in one line that says where.
#include "common/mesh_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>
#include <sstream>

#include "common/levelset/scene.h"
#include "tests/temporary_folder.h"

namespace lockstep {
namespace {

// A pyramid on a square, whose coordinates float holds exactly. Corners count from 0.
const std::vector<std::vector<double>> points = {
    {.25, .25, .25}, {.75, .25, .25}, {.75, .75, .25}, {.25, .75, .25}, {.5, .5, .8125}};
const std::vector<std::vector<int>> faces = {{3, 2, 1, 0}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
const std::vector<std::vector<int>> triangles = {{3, 2, 1}, {3, 1, 0}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};

std::string words_of(const auto& values, int more = 0) {
  std::ostringstream out;
  for (const auto x : values) out << x + more << ' ';
  return out.str();
}

template <class Number>
std::string bytes_of(Number x, bool big_endian = false) {
  auto bytes = std::bit_cast<std::array<char, sizeof x>>(x);
  if (big_endian) std::ranges::reverse(bytes);
  return {bytes.begin(), bytes.end()};
}

std::string obj() {
  std::string text;
  for (const auto& p : points) text += "v " + words_of(p) + '\n';
  for (const auto& face : faces) text += "f " + words_of(face, 1) + '\n';
  return text;
}

std::string off() {
  std::string text = "OFF  # a pyramid\n\n5 5 8\n";
  for (const auto& p : points) text += words_of(p) + '\n';
  for (const auto& face : faces) text += std::to_string(face.size()) + ' ' + words_of(face) + "255 0 0\n";
  return text;
}

std::string ply_header(const std::string& format, const std::string& real) {
  return "ply\nformat " + format + " 1.0\ncomment a pyramid\nelement vertex 5\nproperty " + real + " x\nproperty " +
         real + " y\nproperty " + real +
         " z\nproperty uchar red\nelement face 5\nproperty list uchar uint vertex_indices\n"
         "end_header\n";
}

std::string ply_text() {
  std::string text = ply_header("ascii", "double");
  for (const auto& p : points) text += words_of(p) + "255\n";
  for (const auto& face : faces) text += std::to_string(face.size()) + ' ' + words_of(face) + '\n';
  return text;
}

template <class Real>
std::string ply_binary(bool big_endian) {
  std::string bytes =
      ply_header(big_endian ? "binary_big_endian" : "binary_little_endian", sizeof(Real) == 4 ? "float" : "float64");
  for (const auto& p : points) {
    for (const double x : p) bytes += bytes_of(static_cast<Real>(x), big_endian);
    bytes += '\xff';
  }
  for (const auto& face : faces) {
    bytes += static_cast<char>(face.size());
    for (const int i : face) bytes += bytes_of(static_cast<std::uint32_t>(i), big_endian);
  }
  return bytes;
}

std::string stl_text() {
  std::string text = "solid a pyramid\n";
  for (const auto& t : triangles) {
    text += " facet normal 0 0 0\n  outer loop\n";
    for (const int i : t) text += "   vertex " + words_of(points[i]) + "\n";
    text += "  endloop\n endfacet\n";
  }
  return text + "endsolid a pyramid\n";
}

// As some programs write it, the header of a binary file begins like text.
std::string stl_binary() {
  std::string bytes = "solid a pyramid";
  bytes.resize(80);
  bytes += bytes_of(static_cast<std::uint32_t>(triangles.size()));
  for (const auto& t : triangles) {
    bytes.append(12, '\0');
    for (const int i : t)
      for (const double x : points[i]) bytes += bytes_of(static_cast<float>(x));
    bytes.append(2, '\0');
  }
  return bytes;
}

struct MeshFileTest : TemporaryFolder {
  levelset::Scene load(const std::string& name, const std::string& bytes) const {
    write_bytes(path(name), bytes);
    write_bytes(path("a.toml"), "kind = \"levelset\"\npoints = [20, 21, 22]\n[mesh]\nfile = \"" + name + "\"\n");
    return levelset::load_scene(path("a.toml"));
  }
  std::string error(const std::string& name, const std::string& bytes) const {
    write_bytes(path(name), bytes);
    const std::string message = error_of([&] { read_mesh(path(name)); });
    return message.substr(std::min(message.size(), folder.size() + 1));
  }
};

TEST_F(MeshFileTest, AllFormatsMakeTheSameLevelSet) {
  const levelset::Scene expected = load("a.obj", obj());
  const std::pair<std::string, std::string> files[] = {{"a.off", off()},
                                                       {"A.OFF", off()},
                                                       {"text.ply", ply_text()},
                                                       {"little.ply", ply_binary<float>(false)},
                                                       {"big.ply", ply_binary<double>(true)},
                                                       {"text.stl", stl_text()},
                                                       {"binary.stl", stl_binary()}};
  for (const auto& [name, bytes] : files) {
    const levelset::Scene scene = load(name, bytes);
    EXPECT_EQ(scene.grid.spacing, expected.grid.spacing) << name;
    EXPECT_TRUE(scene.phi.value == expected.phi.value) << name;
    const Mesh mesh = read_mesh(path(name));
    EXPECT_EQ(mesh.points.size(), 5u) << name;  // those of STL are welded
    EXPECT_EQ(mesh.triangles.size(), 6u) << name;
  }
}

TEST_F(MeshFileTest, ZeroesOfBothSignsAreOnePoint) {
  const auto facet = [](const std::string& a, const std::string& b, const std::string& c) {
    return "facet normal 0 0 0\nouter loop\nvertex " + a + "\nvertex " + b + "\nvertex " + c + "\nendloop\nendfacet\n";
  };
  write_bytes(path("a.stl"),
              "solid\n" + facet("0 0 0", "1 0 0", "0 1 0") + facet("-0 0 0", "0 1 0", "-1 -0 0") + "endsolid\n");
  EXPECT_EQ(read_mesh(path("a.stl")).points.size(), 4u);
}

// Every file that is cut short is refused, or says all that matters before the cut.
TEST_F(MeshFileTest, RefusesFilesCutShort) {
  const std::pair<std::string, std::string> files[] = {{"a.off", off()},
                                                       {"text.ply", ply_text()},
                                                       {"binary.ply", ply_binary<float>(false)},
                                                       {"text.stl", stl_text()},
                                                       {"binary.stl", stl_binary()}};
  for (const auto& [name, bytes] : files)
    for (std::size_t size = 0; size + 20 < bytes.size(); ++size) {
      const std::string message = error(name, bytes.substr(0, size));
      EXPECT_TRUE(message.starts_with(name + ':')) << size << ' ' << message;
    }
}

TEST_F(MeshFileTest, SaysWhatIsWrong) {
  const auto replaced = [](std::string text, const std::string& from, const std::string& to) {
    return text.replace(text.find(from), from.size(), to);
  };
  EXPECT_EQ(error("a.3ds", obj()), "a.3ds: expected a file .obj, .off, .ply or .stl");
  EXPECT_EQ(error("a.off", obj()), "a.off:1: expected OFF, COFF, NOFF or CNOFF");
  EXPECT_EQ(error("a.off", "OFF\n5 x 0\n"), "a.off:2: expected the numbers of points and faces");
  EXPECT_EQ(error("a.off", "OFF 3 1 0\n0 0 0\n1 0 nan\n"),
            "a.off:3: point: expected three numbers from -1e9 to 1e9, in m");
  EXPECT_EQ(error("a.off", "OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"),
            "a.off:5: face: 3 is no point, expected a number from 0 to 2");
  EXPECT_EQ(error("a.off", "OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 1\n"), "a.off:5: face: point 2 comes twice");
  EXPECT_EQ(error("a.off", "OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1\n"),
            "a.off:5: face: expected the number of its points, and the points");
  EXPECT_EQ(error("a.off", "OFF 3 9000000000000000000 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"),
            "a.off: ends before face 2 of 9000000000000000000");
  EXPECT_EQ(error("a.ply", off()), "a.ply:1: expected ply");
  EXPECT_EQ(error("a.ply", replaced(ply_text(), "ascii", "utf8")),
            "a.ply:2: expected the format ascii, binary_little_endian or binary_big_endian");
  EXPECT_EQ(error("a.ply", replaced(ply_text(), "uchar red", "colour red")),
            "a.ply:8: expected the property of an element: a type, or list and two types, and a name");
  EXPECT_EQ(error("a.ply", replaced(ply_text(), "face 5\nproperty list uchar uint vertex_indices", "face 5")),
            "a.ply:10: expected a property of each element");
  EXPECT_EQ(error("a.ply", replaced(ply_text(), "3 0 1 4", "3 0 1 7")), "a.ply: face 2: point 8 of 5");
  EXPECT_EQ(error("a.ply", replaced(ply_text(), "3 0 1 4", "3 0 1 -4")),
            "a.ply: face 2: expected the numbers of its points, from 0");
  EXPECT_EQ(error("a.ply", replaced(ply_text(), "vertex 5", "vertex 6")),
            "a.ply: face 1: expected at least three points");
  EXPECT_EQ(error("a.ply", replaced(ply_text(), "double y", "double w")),
            "a.ply: vertex 1: expected three numbers from -1e9 to 1e9, in m");
  EXPECT_EQ(error("a.stl", replaced(stl_text(), "outer", "inner")),
            "a.stl:3: expected solid, facet, outer, vertex, endloop, endfacet or endsolid, not inner");
  EXPECT_EQ(error("a.stl", stl_binary() + "x"),
            "a.stl: 385 bytes, expected 384 bytes for the 6 triangles that its header announces, or text that begins "
            "with solid");
  EXPECT_EQ(error("a.stl", replaced(stl_text(), "vertex 0.75", "vertex x")),
            "a.stl:5: vertex: expected three numbers from -1e9 to 1e9, in m");
  EXPECT_EQ(error("a.stl", replaced(stl_text(), "vertex 0.75 0.75 0.25", "vertex 0.25 0.75 0.25")),
            "a.stl:7: loop: point 1 comes twice");
}

}  // namespace
}  // namespace lockstep
