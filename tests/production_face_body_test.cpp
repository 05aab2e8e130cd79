// Bodies of tetrahedra: the lattice fills its box, shapes and fibres are those of the mesh.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>

#include "common/production_face/faults.h"
#include "common/production_face/make.h"

namespace lockstep::production_face {
namespace {

using Vector = Vector3<double>;

double volume_of(const Mesh& mesh, const std::array<std::int32_t, 4>& t) {
  const Vector a = mesh.nodes[t[0]];
  return dot(mesh.nodes[t[1]] - a, cross(mesh.nodes[t[2]] - a, mesh.nodes[t[3]] - a)) / 6;
}

// --- The lattice

// Nodes are rounded by at most n u spacing, u = 2^-53, n the most cells a side. Edges are no longer than the spacing,
// so that a volume, a sixth of a product of three of them, is off by 3/6 times 2 sqrt(3) n u spacing^3, which is 21 n u
// of it; five operations of the volume's round, too.
TEST(ProductionFaceLattice, TetrahedraAreAlikeAndFillTheBox) {
  for (const std::array<int, 3>& cells : {std::array{1, 1, 1}, std::array{2, 3, 5}, std::array{4, 1, 2}}) {
    const double spacing = .0028;
    const Mesh mesh = make_lattice(cells, spacing);
    const int in_box = cells[0] * cells[1] * cells[2];
    EXPECT_EQ(mesh.tetrahedra.size(), 12u * in_box);
    EXPECT_EQ(mesh.nodes.size(), std::size_t(in_box + (cells[0] + 1) * (cells[1] + 1) * (cells[2] + 1)));
    EXPECT_EQ(fault_of(mesh), "");
    const double each = spacing * spacing * spacing / 12, error = 2 * 21 * 5 * 0x1p-53;
    double sum = 0;
    for (const auto& t : mesh.tetrahedra) {
      EXPECT_NEAR(volume_of(mesh, t), each, error * each);
      sum += volume_of(mesh, t);
    }
    EXPECT_NEAR(sum, in_box * spacing * spacing * spacing, (error + 12 * in_box * 0x1p-53) * sum);
  }
}

// A face belongs to two tetrahedra that lie on its two sides, or to one and lies on a side of the box. With the
// volumes, they fill the box without a gap and without an overlap.
TEST(ProductionFaceLattice, FacesAreSharedOrOnTheBox) {
  const std::array<int, 3> cells = {3, 2, 4};
  const Mesh mesh = make_lattice(cells, 1);
  std::map<std::array<std::int32_t, 3>, std::array<int, 2>> faces;  // how often each is met, by orientation
  for (const auto& t : mesh.tetrahedra)
    for (const std::array<std::int32_t, 3>& face :
         {std::array{t[1], t[2], t[3]}, {t[0], t[3], t[2]}, {t[0], t[1], t[3]}, {t[0], t[2], t[1]}}) {
      std::array<std::int32_t, 3> sorted = face;
      std::ranges::sort(sorted);
      const auto first = std::ranges::find(face, sorted[0]) - face.begin();
      ++faces[sorted][face[(first + 1) % 3] == sorted[1]];
    }
  int on_box = 0;
  for (const auto& entry : faces) {
    const auto& face = entry.first;
    const auto& met = entry.second;
    if (met[0] == 1 && met[1] == 1) continue;
    EXPECT_EQ(met[0] + met[1], 1);
    ++on_box;
    const auto all_at = [&](auto component, double place) {
      return std::ranges::all_of(face, [&](std::int32_t n) { return component(mesh.nodes[n]) == place; });
    };
    const auto x = [](const Vector& p) { return p.x; };
    const auto y = [](const Vector& p) { return p.y; };
    const auto z = [](const Vector& p) { return p.z; };
    EXPECT_TRUE(all_at(x, 0) || all_at(x, cells[0]) || all_at(y, 0) || all_at(y, cells[1]) || all_at(z, 0) ||
                all_at(z, cells[2]));
  }
  EXPECT_EQ(on_box, 2 * 2 * (3 * 2 + 2 * 4 + 4 * 3));
}

// --- Bodies

// With a spacing that is a power of two, nothing rounds but the volume, a twelfth.
TEST(ProductionFaceBody, ShapesOfTheLatticeAreExact) {
  const Body<float> body = make_body(make_lattice({2, 3, 2}, .25), {}, 0);
  const Vector3<float> slope = {3, -2, 5};
  ASSERT_EQ(body.tetrahedra, 144);
  ASSERT_EQ(body.padded_tetrahedra(), 144);
  for (int t = 0; t < body.tetrahedra; ++t) {
    EXPECT_EQ(body.volume.at(t, 0), static_cast<float>(.25 * .25 * .25 / 12));
    const auto at = [&](int a) { return dot(slope, load(body.rest, body.corner.at(t, a))) + 7; };
    for (int k = 0; k < 3; ++k) {
      float sum = 0;
      for (int a = 0; a < 3; ++a) sum += (at(a + 1) - at(0)) * body.gradient.at(t, 3 * a + k);
      EXPECT_EQ(sum, k == 0 ? slope.x : k == 1 ? slope.y : slope.z);
    }
  }
}

// Tetrahedra of any shape, each with its own nodes.
Mesh scattered(int count) {
  std::mt19937 generator(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  Mesh mesh;
  while (int(mesh.tetrahedra.size()) < count) {
    for (int a = 0; a < 4; ++a) mesh.nodes.push_back({uniform(generator), uniform(generator), uniform(generator)});
    const auto n = static_cast<std::int32_t>(mesh.nodes.size());
    std::array<std::int32_t, 4> t = {n - 4, n - 3, n - 2, n - 1};
    if (volume_of(mesh, t) < 0) std::swap(t[0], t[1]);
    mesh.tetrahedra.push_back(t);
    if (volume_of(mesh, t) < .01) mesh.tetrahedra.pop_back(), mesh.nodes.resize(n - 4);
  }
  return mesh;
}

// The sum over corners of edge times gradient is the identity. A gradient's components round once to float, by
// u = 2^-24, and in double by about 1e-14, as volumes are above .01 and edges below 4.
TEST(ProductionFaceBody, GradientsAreExactForLinearFunctions) {
  const Body<float> body = make_body(scattered(200), {}, 0);
  const Body<double> exact = in_double(body);
  for (int t = 0; t < body.tetrahedra; ++t)
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 3; ++column) {
        double sum = 0, in_truth = 0, size = 0;
        for (int a = 0; a < 3; ++a) {
          const Vector d = load(exact.rest, body.corner.at(t, a + 1)) - load(exact.rest, body.corner.at(t, 0));
          const double edge = row == 0 ? d.x : row == 1 ? d.y : d.z;
          sum += edge * body.gradient.at(t, 3 * a + column);
          in_truth += edge * exact.gradient.at(t, 3 * a + column);
          size += std::abs(edge * exact.gradient.at(t, 3 * a + column));
        }
        EXPECT_NEAR(sum, row == column, 0x1.001p-24 * size);
        EXPECT_NEAR(in_truth, row == column, 1e-12 * size);
      }
}

TEST(ProductionFaceBody, TheLastBlockIsFilledUpWithoutVolume) {
  const Body<float> body = make_body(make_lattice({2, 1, 1}, 1), {}, 0);
  ASSERT_EQ(body.tetrahedra, 24);
  ASSERT_EQ(body.padded_tetrahedra(), 32);
  for (int t = 24; t < 32; ++t) {
    EXPECT_EQ(body.volume.at(t, 0), 0);
    for (int a = 0; a < 4; ++a) EXPECT_EQ(body.corner.at(t, a), body.corner.at(23, a));
    for (int k = 0; k < 9; ++k) EXPECT_EQ(body.gradient.at(t, k), body.gradient.at(23, k));
  }
}

TEST(ProductionFaceBody, CornersAtNodesAreCompleteAndAscend) {
  const Body<float> body = make_body(make_lattice({3, 2, 2}, 1), {}, 0);
  ASSERT_EQ(int(body.first_corner.size()), body.nodes + 1);
  EXPECT_EQ(body.first_corner[0], 0);
  EXPECT_EQ(body.first_corner[body.nodes], 4 * body.tetrahedra);
  std::vector<bool> met(4 * body.tetrahedra, false);
  for (int n = 0; n < body.nodes; ++n)
    for (int i = body.first_corner[n]; i < body.first_corner[n + 1]; ++i) {
      const int corner = body.corner_at_node[i];
      EXPECT_EQ(body.corner.at(corner / 4, corner % 4), n);
      if (i > body.first_corner[n]) {
        EXPECT_LT(body.corner_at_node[i - 1], corner);
      }
      EXPECT_FALSE(met[corner]);
      met[corner] = true;
    }
}

TEST(ProductionFaceBody, FibresStandInSlots) {
  const Vector x = {1, 0, 0}, y = {0, 1, 0}, z = {0, 0, 1};
  const Body<float> body =
      make_body(make_lattice({3, 1, 1}, 1), {{0, 1, x, 1}, {0, 0, y, .5}, {3, 1, z, 1}, {35, 0, y, .25}}, 2);
  EXPECT_EQ(body.muscles, 2);
  ASSERT_EQ(body.blocks(), 3);
  EXPECT_EQ(body.first_fibre, (Array<std::int32_t>{0, 2, 2, 3}));
  ASSERT_EQ(body.muscle.blocks(), 3);
  const std::map<int, std::array<float, 5>> expected = {// by place: muscle, direction, share
                                                        {0, {1, 1, 0, 0, 1}},
                                                        {3, {1, 0, 0, 1, 1}},
                                                        {16, {0, 0, 1, 0, .5f}},
                                                        {2 * 16 + 3, {0, 0, 1, 0, .25f}}};
  for (int place = 0; place < 3 * lanes; ++place) {
    const auto fibre = expected.contains(place) ? expected.at(place) : std::array<float, 5>{-1, 0, 0, 0, 0};
    EXPECT_EQ(body.muscle.at(place, 0), fibre[0]) << place;
    for (int k = 0; k < 4; ++k) EXPECT_EQ(body.fibre.at(place, k), fibre[k + 1]) << place;
  }
  const Strained<float> strained = make_strained(body);
  EXPECT_EQ(strained.pull.blocks(), 3);
  EXPECT_EQ(strained.derivative.blocks(), 3);
}

TEST(ProductionFaceBody, WithoutFibresThereAreNoSlots) {
  const Body<float> body = make_body(make_lattice({1, 1, 1}, 1), {}, 0);
  EXPECT_EQ(body.first_fibre, (Array<std::int32_t>{0, 0}));
  EXPECT_EQ(body.muscle.value.size() + body.fibre.value.size(), 0u);
  EXPECT_EQ(make_strained(body).pull.value.size(), 0u);
}

TEST(ProductionFaceBody, InDoubleIsTheSameBody) {
  const Body<float> body = make_body(make_lattice({3, 2, 1}, .0028), {{5, 0, {.6, .8, 0}, .3}}, 1);
  const Body<double> exact = in_double(body);
  EXPECT_EQ(exact.nodes, body.nodes);
  EXPECT_EQ(exact.tetrahedra, body.tetrahedra);
  EXPECT_EQ(exact.muscles, body.muscles);
  EXPECT_EQ(exact.blocks(), body.blocks());
  EXPECT_EQ(exact.corner.value, body.corner.value);
  EXPECT_EQ(exact.muscle.value, body.muscle.value);
  EXPECT_EQ(exact.first_fibre, body.first_fibre);
  EXPECT_EQ(exact.first_corner, body.first_corner);
  EXPECT_EQ(exact.corner_at_node, body.corner_at_node);
  for (int n = 0; n < body.nodes; ++n) {
    EXPECT_EQ(load(exact.rest, n).x, load(body.rest, n).x);
    EXPECT_EQ(load(exact.rest, n).z, load(body.rest, n).z);
  }
  for (std::size_t i = 0; i < body.fibre.value.size(); ++i) EXPECT_EQ(exact.fibre.value[i], body.fibre.value[i]);
  // Both are computed in double, and those of float are rounded to it.
  for (std::size_t i = 0; i < body.gradient.value.size(); ++i)
    EXPECT_EQ(static_cast<float>(exact.gradient.value[i]), body.gradient.value[i]);
  for (int t = 0; t < body.padded_tetrahedra(); ++t)
    EXPECT_EQ(static_cast<float>(exact.volume.at(t, 0)), body.volume.at(t, 0));
}

// --- Faults

// One of its nodes at a height above the middle of the side of the others, an edge of which is 1.
Mesh flat(double height) {
  Mesh mesh = {{{0, 0, 0}, {1, 0, 0}, {.5, .75, 0}, {.5, .25, height}}, {{0, 1, 2, 3}}};
  return mesh;
}

// Volumes are height / 8.
TEST(ProductionFaceMesh, SliversAreFaults) {
  EXPECT_EQ(fault_of(flat(8.01 * least_share)), "");
  EXPECT_EQ(fault_of(flat(7.99 * least_share)),
            "tetrahedron 0 is a sliver: its volume is less than 1e-4 of its longest edge cubed");
  EXPECT_EQ(fault_of(flat(0)), "tetrahedron 0 has no positive volume");
}

// The bound that least_share stands for: with displacements that are as long as an edge, strains of the least share are
// off by no more than 5e-4 of it.
TEST(ProductionFaceMesh, StrainsOfTheFlattestAreOffByWhatIsSaid) {
  const Body<float> body = make_body(flat(8.01 * least_share), {}, 0);
  double most = 0;
  for (int a = 0; a < 3; ++a) {
    const double x = body.gradient.at(0, 3 * a), y = body.gradient.at(0, 3 * a + 1), z = body.gradient.at(0, 3 * a + 2);
    most += 2 * 0x1p-24 * std::sqrt(x * x + y * y + z * z);
  }
  EXPECT_LE(most, .87 * 0x1p-24 * 1.001 / least_share);
  EXPECT_LE(most, 5.3e-4);
}

TEST(ProductionFaceMesh, DoubledNodesAreCounted) {
  Mesh mesh = make_lattice({2, 1, 1}, 1);
  EXPECT_EQ(count_doubled(mesh), 0);
  mesh.nodes.push_back(mesh.nodes[3]), mesh.nodes.push_back(mesh.nodes[3]), mesh.nodes.push_back(mesh.nodes[0]);
  EXPECT_EQ(count_doubled(mesh), 3);
}

TEST(ProductionFaceMesh, FaultsAreNamed) {
  const Mesh good = make_lattice({1, 1, 1}, 1);
  const auto fault = [&](auto change) {
    Mesh mesh = good;
    change(mesh);
    return fault_of(mesh);
  };
  EXPECT_EQ(fault([](Mesh& m) { m.tetrahedra.clear(); }), "no tetrahedra");
  EXPECT_EQ(fault([](Mesh& m) { m.tetrahedra[3][2] = 9; }), "tetrahedron 3 has a corner that is no node: 9");
  EXPECT_EQ(fault([](Mesh& m) { m.tetrahedra[3][1] = -1; }), "tetrahedron 3 has a corner that is no node: -1");
  EXPECT_EQ(fault([](Mesh& m) { m.tetrahedra[2] = {8, 1, 3, 1}; }), "tetrahedron 2 has node 1 twice");
  EXPECT_EQ(fault([](Mesh& m) { std::swap(m.tetrahedra[7][0], m.tetrahedra[7][1]); }),
            "tetrahedron 7 has no positive volume");
  EXPECT_EQ(fault([](Mesh& m) { m.tetrahedra[0] = {0, 1, 2, 3}; }), "tetrahedron 0 has no positive volume");
  EXPECT_EQ(fault([](Mesh& m) { m.nodes.push_back({0, 0, 0}); }), "node 9 is in no tetrahedron");
  EXPECT_EQ(fault([](Mesh& m) {
              const auto& t = m.tetrahedra[4];
              m.tetrahedra.push_back({t[1], t[2], t[0], t[3]});  // turned about a corner, so with the same volume
            }),
            "tetrahedron 12 has the nodes of tetrahedron 4");
  EXPECT_EQ(fault([](Mesh& m) {
              for (Vector3<double>& x : m.nodes) x = 7e-7 * x;  // edges of up to sqrt(2) times that
            }),
            "tetrahedron 0 has no edge of 1e-6 m or longer");
  for (const double bad : {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()})
    for (int k = 0; k < 3; ++k)
      EXPECT_EQ(fault([&](Mesh& m) {
                  (k == 0 ? m.nodes[4].x : k == 1 ? m.nodes[4].y : m.nodes[4].z) = bad;
                }),
                "node 4 has a position that is not finite");
}

}  // namespace
}  // namespace lockstep::production_face
