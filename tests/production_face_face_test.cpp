// The face: tetrahedra of bounded angles that fit together, mirrored to the bit, held by skull and jaw, with muscles.
#include "common/production_face/face.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <set>

#include "common/production_face/faults.h"
#include "common/production_face/head.h"
#include "common/production_face/stuffing.h"

namespace lockstep::production_face {
namespace {

using Vector = Vector3<double>;
using Corners = std::array<std::int32_t, 4>;

double length(const Vector& a) { return std::sqrt(dot(a, a)); }

double volume_of(const Mesh& mesh, const Corners& t) {
  const Vector a = mesh.nodes[t[0]];
  return dot(mesh.nodes[t[1]] - a, cross(mesh.nodes[t[2]] - a, mesh.nodes[t[3]] - a)) / 6;
}

// The least and the greatest dihedral angle of a tetrahedron, in degrees.
std::array<double, 2> angles_of(const Mesh& mesh, const Corners& t) {
  std::array<double, 2> angles = {180, 0};
  for (int a = 0; a < 4; ++a)
    for (int b = a + 1; b < 4; ++b) {
      const int c = a != 0 ? 0 : b != 1 ? 1 : 2, d = 6 - a - b - c;
      const Vector edge = mesh.nodes[t[b]] - mesh.nodes[t[a]];
      const Vector p = cross(edge, mesh.nodes[t[c]] - mesh.nodes[t[a]]),
                   q = cross(edge, mesh.nodes[t[d]] - mesh.nodes[t[a]]);
      const double angle = std::atan2(length(cross(p, q)), dot(p, q)) * 180 / std::numbers::pi;
      angles = {std::min(angles[0], angle), std::max(angles[1], angle)};
    }
  return angles;
}

// That of all tetrahedra, or of those without a node in the middle.
std::array<double, 2> angles_of(const Mesh& mesh, bool middle) {
  std::array<double, 2> angles = {180, 0};
  for (const Corners& t : mesh.tetrahedra) {
    if (!middle && std::ranges::any_of(t, [&](std::int32_t n) { return mesh.nodes[n].x == 0; })) continue;
    const auto of_one = angles_of(mesh, t);
    angles = {std::min(angles[0], of_one[0]), std::max(angles[1], of_one[1])};
  }
  return angles;
}

// How many tetrahedra meet at each face.
std::map<std::array<std::int32_t, 3>, int> faces_of(const Mesh& mesh) {
  std::map<std::array<std::int32_t, 3>, int> faces;
  for (Corners t : mesh.tetrahedra) {
    std::ranges::sort(t);
    for (int out = 0; out < 4; ++out) ++faces[{t[out < 1 ? 1 : 0], t[out < 2 ? 2 : 1], t[out < 3 ? 3 : 2]}];
  }
  return faces;
}

// Of each node the number of its mirror image; -1 without one.
std::vector<std::int32_t> mirror_images(const Mesh& mesh) {
  std::map<std::array<double, 3>, std::int32_t> places;
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    const Vector& x = mesh.nodes[n];
    EXPECT_TRUE(places.emplace(std::array{x.x, x.y, x.z}, n).second) << "two nodes at one place";
  }
  std::vector<std::int32_t> image;
  for (const Vector& x : mesh.nodes) {
    const auto found = places.find({-x.x, x.y, x.z});
    image.push_back(found == places.end() ? -1 : found->second);
  }
  return image;
}

// How many tetrahedra have no mirror image.
int unmirrored(const Mesh& mesh) {
  const std::vector<std::int32_t> image = mirror_images(mesh);
  EXPECT_EQ(std::ranges::count(image, -1), 0);
  const auto sorted = [](Corners t) {
    std::ranges::sort(t);
    return t;
  };
  std::set<Corners> tetrahedra;
  for (const Corners& t : mesh.tetrahedra) EXPECT_TRUE(tetrahedra.insert(sorted(t)).second) << "a tetrahedron twice";
  return static_cast<int>(std::ranges::count_if(mesh.tetrahedra, [&](const Corners& t) {
    return !tetrahedra.contains(sorted({image[t[0]], image[t[1]], image[t[2]], image[t[3]]}));
  }));
}

// --- Stuffing

// The published bounds are proven for the lattice's own tetrahedra; a rough shape comes near them.
constexpr double least_angle = 10.7, greatest_angle = 164.8;

TEST(ProductionFaceStuffing, AnglesAreThosePublishedOfRoughShapes) {
  double least = 180, greatest = 0;
  for (int seed = 0; seed < 4; ++seed) {
    const auto rough = [&](const Vector& p) {
      const double x = std::abs(p.x), box = std::max({x, std::abs(p.y), std::abs(p.z)}) - 1;
      const double waves = std::sin(93 * p.x * p.x + seed) + std::cos((23 + seed) * p.y + 2 * x) +
                           std::sin((29 - seed) * p.z + p.y * 7) + .7 * std::sin((45 + seed) * x) + .2;
      return std::max(box, waves);
    };
    const Mesh mesh = stuff(rough, {1.2, -1.5, 1.5, -1.5, 1.5, .09});
    EXPECT_EQ(fault_of(mesh), "");
    EXPECT_EQ(unmirrored(mesh), 0);
    for (const auto& face : faces_of(mesh)) EXPECT_LE(face.second, 2);
    const auto angles = angles_of(mesh, false);
    least = std::min(least, angles[0]), greatest = std::max(greatest, angles[1]);
  }
  std::printf("rough shapes: %.1f to %.1f degrees beside the middle\n", least, greatest);
  EXPECT_GE(least, least_angle);
  EXPECT_LE(greatest, greatest_angle);
  EXPECT_LT(least, 16) << "the shapes are not rough";
}

// Nodes of the surface are on the sphere, except those in the middle of faces, and the volume is that of a polyhedron
// in the sphere: triangles with sides below 1.5 spacings are within (1.5 h)^2 / 6 of it (their circumscribed circles
// have radii below 1.5 h / sqrt 3 for angles that are not obtuse; half as much again is allowed).
TEST(ProductionFaceStuffing, FillsASphere) {
  const double radius = .8, spacing = .1;
  const Mesh mesh = stuff([&](const Vector& p) { return length(p) - radius; }, {1, -1.05, 1.05, -1.05, 1.05, spacing});
  EXPECT_EQ(fault_of(mesh), "");
  EXPECT_EQ(unmirrored(mesh), 0);
  double volume = 0;
  for (const Corners& t : mesh.tetrahedra) volume += volume_of(mesh, t);
  const double exact = 4 * std::numbers::pi / 3 * radius * radius * radius;
  const double area = 4 * std::numbers::pi * radius * radius, gap = 1.5 * 2.25 * spacing * spacing / 6 / radius;
  EXPECT_LT(volume, exact);
  EXPECT_GT(volume, exact - area * gap);
  // Forty halvings find where an edge, no longer than the spacing, leaves the sphere; distances and places round.
  const double error = 0x1p-41 * spacing + 8 * 0x1p-53 * radius;
  std::map<std::array<std::int32_t, 2>, int> edges;  // of the surface
  for (const auto& entry : faces_of(mesh)) {
    const auto& face = entry.first;
    if (entry.second != 1) continue;
    for (const std::int32_t n : face) {
      EXPECT_LE(length(mesh.nodes[n]), radius + error);
      EXPECT_GE(length(mesh.nodes[n]), radius - (mesh.nodes[n].x == 0 ? gap : error));
    }
    ++edges[{face[0], face[1]}], ++edges[{face[1], face[2]}], ++edges[{face[0], face[2]}];
  }
  for (const auto& edge : edges) EXPECT_EQ(edge.second, 2);
}

// --- The face

class ProductionFaceFace : public testing::TestWithParam<double> {
 protected:
  static const FaceMesh& face() {
    static std::map<double, FaceMesh> faces;
    const auto [entry, is_new] = faces.try_emplace(GetParam());
    if (is_new) entry->second = make_face_mesh(GetParam());
    return entry->second;
  }
};

INSTANTIATE_TEST_SUITE_P(Spacings, ProductionFaceFace, testing::Values(.0115, .0058, .00281));

TEST_P(ProductionFaceFace, TetrahedraAreAsClaimed) {
  const Mesh& mesh = face().mesh;
  EXPECT_EQ(fault_of(mesh), "");
  EXPECT_LT(mesh.tetrahedra.size(), face_tetrahedra(GetParam()));
  EXPECT_GT(mesh.tetrahedra.size(), .85 * face_tetrahedra(GetParam()));
  double sum = 0, least = 1;
  for (const Corners& t : mesh.tetrahedra) {
    sum += volume_of(mesh, t);
    least = std::min(least, volume_of(mesh, t));
  }
  EXPECT_GE(least, 1e-3 * sum / mesh.tetrahedra.size());
  const auto angles = angles_of(mesh, true), beside = angles_of(mesh, false);
  std::printf("%zu tetrahedra: %.1f to %.1f degrees, beside the middle %.1f to %.1f; least volume %.3f of the mean\n",
              mesh.tetrahedra.size(), angles[0], angles[1], beside[0], beside[1], least / sum * mesh.tetrahedra.size());
  EXPECT_GE(angles[0], least_angle);
  EXPECT_LE(angles[1], greatest_angle);
}

TEST_P(ProductionFaceFace, IsItsOwnMirrorImage) {
  EXPECT_EQ(unmirrored(face().mesh), 0);
  const std::vector<std::int32_t> image = mirror_images(face().mesh);
  for (const std::vector<std::int32_t>* held : {&face().skull, &face().jaw}) {
    const std::set<std::int32_t> nodes(held->begin(), held->end());
    for (const std::int32_t n : nodes) EXPECT_TRUE(nodes.contains(image[n]));
  }
}

TEST_P(ProductionFaceFace, IsOnePieceWithAMouth) {
  const Mesh& mesh = face().mesh;
  std::vector<std::int32_t> next(mesh.tetrahedra.size());
  std::iota(next.begin(), next.end(), 0);
  const auto piece_of = [&](std::int32_t t) {
    while (next[t] != t) t = next[t] = next[next[t]];
    return t;
  };
  std::map<std::array<std::int32_t, 3>, std::int32_t> faces;
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    Corners c = mesh.tetrahedra[t];
    std::ranges::sort(c);
    for (int out = 0; out < 4; ++out) {
      const auto [entry, is_new] = faces.try_emplace({c[out < 1 ? 1 : 0], c[out < 2 ? 2 : 1], c[out < 3 ? 3 : 2]}, t);
      if (!is_new) next[piece_of(static_cast<std::int32_t>(t))] = piece_of(entry->second);
    }
    const auto is_at_lips = [&](std::int32_t n) { return std::abs(mesh.nodes[n].x) < .0225 && mesh.nodes[n].z > .065; };
    const auto is_above = [&](std::int32_t n) { return mesh.nodes[n].y > mouth_height; };
    if (!std::ranges::all_of(c, is_at_lips)) continue;
    EXPECT_EQ(is_above(c[0]), std::ranges::all_of(c, is_above)) << t;
  }
  for (std::size_t t = 0; t < next.size(); ++t) EXPECT_EQ(piece_of(static_cast<std::int32_t>(t)), piece_of(0));
}

TEST_P(ProductionFaceFace, SkullAndJawHoldItApart) {
  const Mesh& mesh = face().mesh;
  std::vector<char> held(mesh.nodes.size(), '-');
  EXPECT_TRUE(std::ranges::is_sorted(face().skull) && std::ranges::is_sorted(face().jaw));
  for (const std::int32_t n : face().skull) held[n] = 's';
  for (const std::int32_t n : face().jaw) {
    EXPECT_EQ(held[n], '-');
    held[n] = 'j';
    EXPECT_LT(mesh.nodes[n].y, mouth_height);
    EXPECT_GT(mesh.nodes[n].z, .025);
  }
  // On a surface, the chin: its nodes grow with the square of the resolution, all nodes with the cube.
  EXPECT_GT(face().jaw.size(), .25 * std::pow(mesh.nodes.size(), 2. / 3));
  EXPECT_GT(face().skull.size(), mesh.nodes.size() / 10);
  for (const Corners& t : mesh.tetrahedra) {
    const auto count = [&](char c) { return std::ranges::count(t, c, [&](std::int32_t n) { return held[n]; }); };
    EXPECT_TRUE(count('s') == 0 || count('j') == 0);
    EXPECT_GT(count('-'), 0);
  }
  // What is behind the ears is held by the skull.
  int free_behind = 0;
  for (std::size_t n = 0; n < held.size(); ++n) free_behind += mesh.nodes[n].z < 1e-6 && held[n] != 's';
  EXPECT_EQ(free_behind, 0);
}

TEST_P(ProductionFaceFace, NeighboursAreNearInMemory) {
  const Mesh& mesh = face().mesh;
  std::int32_t before = 0, furthest = 0;
  for (const Corners& t : mesh.tetrahedra) {
    const auto [least, greatest] = std::ranges::minmax(t);
    EXPECT_LE(before, least);
    before = least;
    furthest = std::max(furthest, greatest - least);
  }
  // A layer of one spacing and the next, of .2 m / spacing: each node is within two of the layers.
  EXPECT_LT(furthest, 3 * mesh.nodes.size() * GetParam() / .2);
}

TEST_P(ProductionFaceFace, MusclesAreThereAndMirrored) {
  const FaceMesh& f = face();
  ASSERT_EQ(f.muscles.size(), 32u);
  EXPECT_EQ(std::set<std::string>(f.muscles.begin(), f.muscles.end()).size(), 32u);
  EXPECT_EQ(f.muscles[9], "zygomaticus major left");
  EXPECT_EQ(f.muscles[25], "zygomaticus major right");
  std::vector<int> tetrahedra(32, 0), fibres(f.mesh.tetrahedra.size(), 0);
  std::vector<double> side(32, 0);
  std::int32_t before = 0;
  for (const Fibre& fibre : f.fibres) {
    EXPECT_LE(before, fibre.tetrahedron);
    before = fibre.tetrahedron;
    EXPECT_NEAR(length(fibre.direction), 1, 1e-14);
    EXPECT_GT(fibre.share, 0);
    EXPECT_LE(fibre.share, 1);
    ++tetrahedra[fibre.muscle], ++fibres[fibre.tetrahedron];
    Vector centroid = {0, 0, 0};
    for (const std::int32_t n : f.mesh.tetrahedra[fibre.tetrahedron]) centroid = centroid + .25 * f.mesh.nodes[n];
    side[fibre.muscle] += centroid.x;
    // What is left of the curve's axis is its length times 16 u at most. The axis is nowhere nearer to the normal than
    // by a thousandth, so that the fibre is at least a thousandth of it.
    EXPECT_NEAR(dot(fibre.direction, skull_normal(centroid)), 0, 16 * 0x1p-53 / 1e-3);
  }
  for (int m = 0; m < 16; ++m) {
    EXPECT_GT(tetrahedra[m], 10) << f.muscles[m];
    EXPECT_EQ(tetrahedra[m], tetrahedra[m + 16]) << f.muscles[m];
    EXPECT_GT(side[m], 0);
    EXPECT_LT(side[m + 16], 0);
  }
  const double all = f.mesh.tetrahedra.size(), with = all - std::ranges::count(fibres, 0);
  EXPECT_GT(with / all, .10);
  EXPECT_LT(with / all, .15);
  EXPECT_GT(with - std::ranges::count(fibres, 1), .01 * all);  // with two
}

// From the cheekbone down to the corner of the mouth; from the top of the head forwards and down to the brow; and round
// the mouth, from above it to below it.
TEST_P(ProductionFaceFace, FibresFollowTheirMuscles) {
  const FaceMesh& f = face();
  for (const Fibre& fibre : f.fibres) {
    const std::string& muscle = f.muscles[fibre.muscle];
    const Vector& along = fibre.direction;
    Vector centroid = {0, 0, 0};
    for (const std::int32_t n : f.mesh.tetrahedra[fibre.tetrahedron]) centroid = centroid + .25 * f.mesh.nodes[n];
    const double up = centroid.y - mouth_height;
    if (muscle == "zygomaticus major left") {
      EXPECT_TRUE(along.x < 0 && along.y < 0);
    }
    if (muscle == "frontalis left") {
      EXPECT_GT(along.z - along.y, .5);
    }
    if (muscle == "orbicularis oris left" && centroid.x < .02 && std::abs(up) > .008) {
      EXPECT_GT(along.x * up, 0);
    }
  }
}

TEST(ProductionFaceShapes, DependOnTheDistanceFromTheMiddleAlone) {
  for (const double x : {0., .01, .031, .07})
    for (const double y : {-.09, mouth_height, 0., .026, .1})
      for (const double z : {.01, .06, .09}) {
        EXPECT_EQ(distance_to_flesh({x, y, z}, .002), distance_to_flesh({-x, y, z}, .002));
        EXPECT_GT(distance_to_flesh({x, y, -.001}, .002), 0);
      }
  EXPECT_GT(distance_to_flesh({eye.x, eye.y, eye.z}, .002), 0);
  EXPECT_GT(distance_to_flesh({0, mouth_height, .085}, .002), 0);
  EXPECT_LT(distance_to_flesh({0, mouth_height - .003, .085}, .002), 0);
  EXPECT_LT(distance_to_skull({0, 0, 0}), 0);
}

}  // namespace
}  // namespace lockstep::production_face
