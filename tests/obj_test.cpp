// common/obj.h: what files say, which are refused, in one line that says where, and how polygons are cut into
// triangles.

#include "common/mesh_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/temporary_folder.h"

namespace lockstep {
namespace {

using Vector = Vector3<double>;

struct ObjTest : TemporaryFolder {
  Mesh read(const std::string& obj) const {
    write_bytes(path("a.obj"), obj);
    return read_obj(path("a.obj"));
  }
  std::string error(const std::string& obj) const {
    return without_folder(error_of([&] { read(obj); }));
  }
  std::string without_folder(const std::string& message) const {
    EXPECT_EQ(message.rfind(folder, 0), 0u) << message;
    return message.substr(std::min(message.size(), folder.size() + 1));
  }

  // A face of all these points.
  Mesh read_polygon(const std::vector<Vector>& points) const {
    std::ostringstream obj;
    obj.precision(17);
    for (const Vector& p : points) obj << "v " << p.x << ' ' << p.y << ' ' << p.z << '\n';
    obj << 'f';
    for (std::size_t i = 1; i <= points.size(); ++i) obj << ' ' << i;
    return read(obj.str() + '\n');
  }
};

// Points 1 2 3 4 of a unit square, around it.
const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

// --- Files

TEST_F(ObjTest, ReadsTriangles) {
  const Mesh mesh = read("# a comment\nmtllib none.mtl\no cloth\ng front\n" + square +
                         "vt 0 0\nvn 0 0 1\nusemtl none\ns 1\nf 1/1/1 2/1/1 3//1\n\n  f -4 -2 -1 \r\n");
  ASSERT_EQ(mesh.points.size(), 4u);
  EXPECT_EQ(mesh.points[2].y, 1);
  ASSERT_EQ(mesh.triangles.size(), 2u);
  EXPECT_EQ(mesh.triangles[0].c, 2);
  EXPECT_EQ(mesh.triangles[1].a, 0);
  EXPECT_EQ(mesh.triangles[1].c, 3);
}

TEST_F(ObjTest, ReadsNumbersAsTheyAreWritten) {
  const Mesh mesh = read("v 1.5 -2.5e-3 +.25\r\nv 1 0 0 1\nv\t0 1. 0 0.5 0.5 0.5\nf 1 2 3");
  EXPECT_DOUBLE_EQ(mesh.points[0].x, 1.5);
  EXPECT_DOUBLE_EQ(mesh.points[0].y, -.0025);
  EXPECT_DOUBLE_EQ(mesh.points[0].z, .25);
}

TEST_F(ObjTest, CutsPolygonsIntoTriangles) {
  EXPECT_EQ(read(square + "f 1 2 3 4\n").triangles.size(), 2u);
  EXPECT_EQ(read(square + "v 0.5 2 0\nf 1 2 3 5 4\n").triangles.size(), 3u);
}

TEST_F(ObjTest, TakesFacesBeforeTheirPoints) {
  EXPECT_EQ(read("f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n").triangles.size(), 1u);
}

TEST_F(ObjTest, RefusesWhatIsNoMesh) {
  EXPECT_EQ(error_of([] { read_obj("/dev/null"); }), "/dev/null: is not a regular file");

  for (const char* nothing : {"", "\n", "hello\n", "v 0 0 0\n", "\xff\xfe\x00\x01", "l 1 2\n"})
    EXPECT_EQ(error(nothing), "a.obj: no triangle in it");
  EXPECT_EQ(error(square), "a.obj: no triangle in it");

  write_bytes(path("b.obj"), square + "f 1 2 3 4\n");
  std::filesystem::permissions(path("b.obj"), std::filesystem::perms::none);
  const AsNobody nobody;
  if (!nobody.bound) GTEST_SKIP() << "permissions do not bind root";
  EXPECT_EQ(error_of([&] { read_obj(path("b.obj")); }), path("b.obj") + ": cannot be read: Permission denied");
}

TEST_F(ObjTest, RefusesWrongPoints) {
  for (const char* point :
       {"nan 0 0", "0 inf 0", "0 0 -inf", "0 0", "", "a b c", "0 0 0x1", "0 0 1e400", "0 0 1e10", "0 0 --1", "1,5 0 0"})
    EXPECT_EQ(error(square + "v " + point + "\nf 1 2 3\n"), "a.obj:5: v: expected three numbers from -1e9 to 1e9, in m")
        << point;
}

TEST_F(ObjTest, RefusesWrongFaces) {
  for (const char* index : {"0", "-5", "a", "1.5", "2x", "/2", "nan", "99999999999999999999", "-9223372036854775808"})
    EXPECT_EQ(error(square + "f 1 2 " + index + '\n'),
              "a.obj:5: f: " + std::string(index) +
                  " is no point, expected a number from 1, or from -1 downwards, back from the last");
  EXPECT_EQ(error(square + "f 1 2 3\nf 1 3 5\n"), "a.obj:6: f: point 5 of 4");
  EXPECT_EQ(error(square + "f 1 2 9223372036854775807\n"), "a.obj:5: f: point 9223372036854775807 of 4");
  EXPECT_EQ(error(square + "f 1 2 1\n"), "a.obj:5: f: point 1 comes twice");
  EXPECT_EQ(error(square + "f 1 2 3 -2\n"), "a.obj:5: f: point 3 comes twice");
  for (const char* corners : {"f", "f 1", "f 1 2"})
    EXPECT_EQ(error(square + corners), "a.obj:5: f: expected at least three points");
  EXPECT_EQ(error(square + "f 1 2 3\nf 1 3 4\nf 3 1 2\n"), "a.obj: triangle 3 is triangle 1 again");
  EXPECT_EQ(error(square + "f 1 2 3\nf 1 3 4\nf 4 3 1\n"), "a.obj: triangle 3 is triangle 2 again")
      << "the other way round";
  EXPECT_EQ(error(square + "f 1 2 3\n"), "a.obj: point 4 is in no triangle; is the file whole?");
}

TEST_F(ObjTest, RefusesMeshesThatDoNotFitMemory) {
  const Limit limit(RLIMIT_AS, address_space() + 100'000'000);
  write_bytes(path("a.obj"), square);
  std::filesystem::resize_file(path("a.obj"), 10'000'000);
  const std::string message = without_folder(error_of([&] { read_obj(path("a.obj")); }));
  EXPECT_EQ(message.rfind("a.obj: reading it needs 250 MB of memory, and ", 0), 0u) << message;
}

// A file cut short is read or refused in one line, wherever it is cut; no cut leaves a point that nothing holds.
TEST_F(ObjTest, SurvivesAFileCutShort) {
  const std::string whole = "v 0 0 0\nv 1 0 0\nv 1.25 1 0\nv 0 1 -0.5\nf 1 2 3\nf 1/1 3/2 4/3\n";
  int read_so_far = 0;
  for (std::size_t bytes = 0; bytes <= whole.size(); ++bytes) {
    write_bytes(path("a.obj"), whole.substr(0, bytes));
    if (const std::string error = error_of([&] { read_obj(path("a.obj")); }); error == "no error")
      ++read_so_far;
    else
      EXPECT_EQ(error.rfind(path("a.obj") + ':', 0), 0u) << error;
  }
  EXPECT_EQ(read_so_far, 4) << "the last corner's texture, and the end of the line, are not missed";
}

// --- Polygons

// Twice the area of a triangle, with its direction.
Vector area(const Mesh& mesh, const Triangle& t) {
  return cross(mesh.points[t.b] - mesh.points[t.a], mesh.points[t.c] - mesh.points[t.a]);
}

// All triangles go round as the polygon does, and their areas add up to its own: so none overlaps another, or sticks
// out.
void expect_covers(const Mesh& mesh, const Vector& normal, double twice_area) {
  ASSERT_EQ(mesh.triangles.size(), mesh.points.size() - 2);
  double sum = 0;
  for (const Triangle& t : mesh.triangles) {
    const double along = dot(area(mesh, t), normal);
    EXPECT_GT(along, 0);
    sum += along;
  }
  EXPECT_NEAR(sum, twice_area, 1e-12 * twice_area);
}

TEST_F(ObjTest, CutsConvexPolygonsIntoFans) {
  const Mesh mesh = read_polygon({{0, 0, 0}, {1, 0, 0}, {2, 1, 0}, {1, 2, 0}, {0, 1, 0}});
  ASSERT_EQ(mesh.triangles.size(), 3u);
  for (int k = 0; k < 3; ++k) {
    const auto [a, b, c] = mesh.triangles[k];
    EXPECT_EQ(a, 0);
    EXPECT_EQ(b, k + 1);
    EXPECT_EQ(c, k + 2);
  }
}

TEST_F(ObjTest, CutsConcavePolygonsWhicheverWayTheyFace) {
  // A comb of three teeth; its area is 5 + 3 * 2.
  const std::vector<std::pair<double, double>> comb = {{0, 0}, {5, 0}, {5, 3}, {4, 3}, {4, 1}, {3, 1},
                                                       {3, 3}, {2, 3}, {2, 1}, {1, 1}, {1, 3}, {0, 3}};
  for (std::size_t first = 0; first < comb.size(); ++first)
    for (const bool backwards : {false, true}) {
      std::vector<Vector> in_z, in_x, in_y;
      for (std::size_t k = 0; k < comb.size(); ++k) {
        const auto [x, y] = comb[(first + (backwards ? comb.size() - k : k)) % comb.size()];
        in_z.push_back({x, y, 7}), in_x.push_back({7, x, y}), in_y.push_back({y, 7, x});
      }
      const double sign = backwards ? -1 : 1;
      expect_covers(read_polygon(in_z), {0, 0, sign}, 22);
      expect_covers(read_polygon(in_x), {sign, 0, 0}, 22);
      expect_covers(read_polygon(in_y), {0, sign, 0}, 22);
    }
}

TEST_F(ObjTest, CutsStarShapedPolygons) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> radius(.1, 1);
  for (const int n : {4, 5, 9, 40, 255}) {
    std::vector<Vector> points;
    for (int k = 0; k < n; ++k) {
      const double angle = 2 * M_PI * k / n, r = radius(random);
      const double x = r * std::cos(angle), y = r * std::sin(angle);
      points.push_back({x, y, .5 * x - .25 * y});  // in a plane that is at an angle to the axes
    }
    double twice_area = 0;
    for (int k = 0; k < n; ++k) twice_area += cross(points[k], points[(k + 1) % n]).z;
    expect_covers(read_polygon(points), {0, 0, 1}, twice_area);
  }
}

TEST_F(ObjTest, TakesCornersInTheMiddleOfASide) {
  expect_covers(read_polygon({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 2, 0}, {1, 2, 0}, {0, 2, 0}}), {0, 0, 1}, 8);
  expect_covers(read_polygon({{1, 0, 0}, {2, 0, 0}, {1, 2, 0}, {0, 0, 0}}), {0, 0, 1}, 4);
}

TEST_F(ObjTest, RefusesLoopsAndPolygonsWithoutAnArea) {
  const auto error_of_polygon = [&](const std::vector<Vector>& points) {
    return without_folder(error_of([&] { read_polygon(points); }));
  };
  const std::string expected = ": f: cannot be cut into triangles, expected a flat polygon without loops";
  EXPECT_EQ(error_of_polygon({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}), "a.obj:5" + expected);
  EXPECT_EQ(error_of_polygon({{0, 0, 0}, {2, 0, 0}, {0, 1, 0}, {2, 1, 0}}), "a.obj:5" + expected) << "a bow tie";
  EXPECT_EQ(error_of_polygon({{0, 0, 0}, {3, 0, 0}, {1, 1, 0}, {2, 2, 0}}), "a.obj:5" + expected)
      << "one with unequal halves";
}

}  // namespace
}  // namespace lockstep
