// Repulsions of a cloth: closest points, what is near, momenta, springs, friction, and the serial bits.
#include "common/production_cloth/repulsions.h"

#include <set>

#include "common/production_cloth/contact_batches.h"
#include "tests/production_cloth_contacts.h"

namespace lockstep::production_cloth {
namespace {

// --- Closest points

// The difference d of the closest points of two convex sets is that for which no two of their points are nearer along
// d: d . (a - b) >= d . d for all their corners.
template <class ClosestOf>
void are_closest(bool edges, const ClosestOf& closest_of) {
  constexpr double u = 0x1p-53;
  std::mt19937 random(edges ? 3 : 4);
  int inside = 0;
  for (int round = 0; round < 20000; ++round) {
    Vector3<double> x[4];
    for (auto& p : x) {
      const auto number = [&] { return static_cast<int>(random() % 2001) / 1000. - 1; };
      const double a = number(), b = number(), c = number();
      p = {a, b, c};
    }
    const Closest<double> closest = closest_of(x);
    Vector3<double> difference = {0, 0, 0};
    double sum = 0;
    const int first = edges ? 2 : 1;
    for (int i = 0; i < 4; ++i) {
      difference = difference + closest.weight[i] * x[i], sum += closest.weight[i];
      ASSERT_GE(closest.weight[i] * (i < first ? 1 : -1), -2 * u);
    }
    ASSERT_LE(std::abs(sum), 4 * u);
    ASSERT_LE(length(difference - closest.difference), 64 * u);  // sixteen roundings of numbers up to 4
    const Vector3<double> p = edges ? x[1] - x[0] : x[2] - x[1], q = edges ? x[3] - x[2] : x[3] - x[1];
    // Weights are off by the roundings of their numerators, about ten of products up to 12, over the determinant; what
    // they weigh is up to 4 long, as is d.
    const double pq = dot(p, q), determinant = dot(p, p) * dot(q, q) - pq * pq;
    if (determinant < 1e-6 * dot(p, p) * dot(q, q)) continue;
    const double bound = 16 * u * 10 * 12 * 12 / determinant;
    for (int i = 0; i < first; ++i)
      for (int j = first; j < 4; ++j) ASSERT_GE(dot(closest.difference, x[i] - x[j]), closest.square - bound) << round;
    inside += closest.weight[1] != 0 && closest.weight[2] != 0 && closest.weight[3] != 0;
  }
  EXPECT_GT(inside, 1000);
}

TEST(ProductionClothRepulsions, ClosestPointsAreClosest) {
  are_closest(false, closest_of_point_triangle<double>);
  are_closest(true, closest_of_edge_edge<double>);
}

TEST(ProductionClothRepulsions, ParallelEdgesAndDegenerateTrianglesHaveADistance) {
  const auto edges = [](double begin, double end) {
    const Vector3<double> x[4] = {{0, 0, 0}, {1, 0, 0}, {begin, 1, 0}, {end, 1, 0}};
    return closest_of_edge_edge(x).square;
  };
  EXPECT_EQ(edges(.5, 3), 1);
  EXPECT_EQ(edges(3, .5), 1);
  EXPECT_EQ(edges(-3, 3), 1);
  EXPECT_EQ(edges(2, 3), 2);
  EXPECT_EQ(edges(-3, -1), 2);
  const Vector3<double> line[4] = {{.5, 1, 0}, {0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  EXPECT_EQ(closest_of_point_triangle(line).square, 1);
}

// --- What is near

// Sheets of two triangles each, one over the other.
struct StackOfSquares {
  Topology topology;
  Vectors<float> position;
  ElementPairs pairs;

  StackOfSquares(int sheets, float apart) {
    std::vector<Triangle> triangles;
    position.resize(4 * sheets);
    for (int s = 0; s < sheets; ++s) {
      const int v = 4 * s;
      for (int i = 0; i < 4; ++i) store(position, v + i, {float(i % 2) + .1f * s, s * apart, float(i / 2) + .05f * s});
      triangles.push_back({v, v + 1, v + 2}), triangles.push_back({v + 1, v + 3, v + 2});
    }
    topology = make_topology(4 * sheets, triangles, "stack");
    for (int v = 0; v < 4 * sheets; ++v)
      for (int t = 0; t < 2 * sheets; ++t)
        if (v / 4 != t / 2) pairs.point_triangle.push_back({v, t});
    for (int e = 0; e < int(topology.edges.size()); ++e)
      for (int f = e + 1; f < int(topology.edges.size()); ++f)
        if (topology.edges[e][0] / 4 != topology.edges[f][0] / 4) pairs.edge_edge.push_back({e, f});
  }
};

TEST(ProductionClothRepulsions, NearPairsAreThoseNearerThanTheThickness) {
  const StackOfSquares stack(3, .1f);
  Contacts<float> contacts;
  serial::near_contacts(stack.topology, stack.pairs, {}, stack.position, .15f, contacts);
  const ElementPairs near = rest_neighbours(stack.topology, stack.pairs, stack.position, .15f);
  ASSERT_EQ(contacts.count, near.point_triangle.size() + near.edge_edge.size());
  ASSERT_GT(near.point_triangle.size(), 5u);
  ASSERT_LT(contacts.count, stack.pairs.point_triangle.size() + stack.pairs.edge_edge.size());
  for (std::size_t k = 0; k < contacts.count; ++k) {
    const bool edges = k >= near.point_triangle.size();
    const auto corner = edges ? corners_of_edge_edge(stack.topology, near.edge_edge[k - near.point_triangle.size()])
                              : corners_of_point_triangle(stack.topology, near.point_triangle[k]);
    Vector3<float> difference = {0, 0, 0};
    for (int i = 0; i < 4; ++i) {
      ASSERT_EQ(contacts.corner[4 * k + i], corner[i]);
      difference = difference + contacts.weight[4 * k + i] * load(stack.position, corner[i]);
    }
    const Vector3<float> n = {contacts.normal[4 * k], contacts.normal[4 * k + 1], contacts.normal[4 * k + 2]};
    const float distance = contacts.normal[4 * k + 3];
    // Sixteen roundings of numbers up to 2.
    EXPECT_LE(length(convert<double>(difference - distance * n)), 32 * 0x1p-24);
    EXPECT_LT(distance, .15f);
    EXPECT_GE(distance, .0999f);
    EXPECT_NEAR(dot(n, n), 1, 8 * 0x1p-24);
  }
}

TEST(ProductionClothRepulsions, ExcludedPairsAndThoseThatTouchAreLeftOut) {
  const StackOfSquares stack(2, .1f), flat(2, 0);
  Contacts<float> contacts;
  const ElementPairs near = rest_neighbours(stack.topology, stack.pairs, stack.position, .15f);
  ElementPairs odd;
  for (std::size_t k = 1; k < near.point_triangle.size(); k += 2) odd.point_triangle.push_back(near.point_triangle[k]);
  odd.edge_edge = near.edge_edge;
  for (const bool in_lanes : {false, true}) {
    NearContacts<float>* const serial_form = serial::near_contacts;
    NearContacts<float>* const near_contacts = in_lanes ? openmp::near_contacts : serial_form;
    near_contacts(stack.topology, stack.pairs, odd, stack.position, .15f, contacts);
    EXPECT_EQ(contacts.count, (near.point_triangle.size() + 1) / 2);
    near_contacts(flat.topology, flat.pairs, {}, flat.position, .01f, contacts);
    for (std::size_t k = 0; k < contacts.count; ++k) EXPECT_GT(contacts.normal[4 * k + 3], 0);
  }
}

TEST(ProductionClothRepulsions, NearPairsHaveTheSerialBits) {
  const StackOfSquares stack(9, .03f);
  for (const std::size_t count : {0, 1, 15, 16, 17, 33, 500}) {
    ElementPairs pairs, excluded;
    pairs.point_triangle.assign(stack.pairs.point_triangle.begin(), stack.pairs.point_triangle.begin() + count);
    pairs.edge_edge.assign(stack.pairs.edge_edge.begin(), stack.pairs.edge_edge.begin() + count);
    for (std::size_t k = 0; k < count; k += 3) excluded.edge_edge.push_back(pairs.edge_edge[k]);
    Contacts<float> expected, contacts;
    serial::near_contacts(stack.topology, pairs, excluded, stack.position, .1f, expected);
    at_each_team([&] {
      openmp::near_contacts(stack.topology, pairs, excluded, stack.position, .1f, contacts);
      ASSERT_EQ(contacts.count, expected.count);
      const std::size_t bytes = 4 * sizeof(float) * expected.count;
      EXPECT_EQ(std::memcmp(contacts.corner.data(), expected.corner.data(), bytes), 0);
      EXPECT_EQ(std::memcmp(contacts.weight.data(), expected.weight.data(), bytes), 0);
      EXPECT_EQ(std::memcmp(contacts.normal.data(), expected.normal.data(), bytes), 0);
    });
  }
}

// --- Repulsion

constexpr double time_step = 1 / 64.;
Repulse<double>* const orders[] = {serial::repulse_original, serial::repulse_batches, serial::repulse_jacobi};
Contact contact_of(double stiffness, double friction) {
  return {.thickness = 2, .stiffness = stiffness, .friction = friction};
}

TEST(ProductionClothRepulsions, KeepMomenta) {
  const ContactCloth<double> c(12, 400, 0, 5);
  for (Repulse<double>* const repulse : orders)
    for (const double friction : {0., .4})
      keeps_momenta(c, friction > 0, [&](const Contacts<double>& contacts, Vectors<double>& velocity) {
        repulse(contacts, contact_of(30, friction), c.inverse_mass, time_step, velocity);
      });
}

void repulse(ContactCloth<double>& c, const Contact& contact) {
  serial::repulse_original(c.contacts, contact, c.inverse_mass, time_step, c.velocity);
}

// A point of 1 kg against a triangle of three: 1/m = 1 + 1/3. All end at a quarter of its speed.
TEST(ProductionClothRepulsions, StopWhatApproaches) {
  ContactCloth<double> c = point_over_triangle({0, -1, 0});
  repulse(c, contact_of(0, 0));
  for (int v = 0; v < 4; ++v) EXPECT_NEAR(load(c.velocity, v).y, -.25, 8 * 0x1p-53);
}

TEST(ProductionClothRepulsions, SpringsUndoATenthOfTheOverlapAtMost) {
  const double overlap = 2 - .25;
  for (const double stiffness : {1e-3, 1e9}) {
    ContactCloth<double> c = point_over_triangle({0, 0, 0});
    repulse(c, contact_of(stiffness, 0));
    const double expected = std::min(time_step * stiffness * overlap, .1 * overlap / time_step);
    EXPECT_NEAR(c.speed(0), expected, 16 * 0x1p-53 * expected);
  }
}

// What parts faster than a tenth of the overlap a step is left alone; nothing attracts.
TEST(ProductionClothRepulsions, DoNotAttract) {
  ContactCloth<double> c = point_over_triangle({0, .1 * 2 / time_step, 0});
  const Vectors<double> before = c.velocity;
  repulse(c, contact_of(1e9, 1));
  EXPECT_TRUE(same_vectors(before, c.velocity, 4));
  ContactCloth<double> many(12, 400, 0, 6);
  for (std::size_t k = 0; k < many.contacts.count; ++k) {
    const double speed = many.speed(k);
    serial::repulse_original(many.only(k), contact_of(30, .5), many.inverse_mass, time_step, many.velocity);
    EXPECT_GE(many.speed(k), speed - 64 * 0x1p-53);  // velocities up to 4; four products and sums, twice
  }
}

TEST(ProductionClothRepulsions, LeaveHeldVerticesAlone) {
  ContactCloth<double> c = point_over_triangle({0, -1, 0});
  for (const int v : {1, 2, 3}) c.inverse_mass[v] = 0;
  repulse(c, contact_of(0, 0));
  EXPECT_EQ(load(c.velocity, 0).y, 0);
  EXPECT_EQ(load(c.velocity, 1).y, 0);
  c = point_over_triangle({0, -1, 0});
  for (double& m : c.inverse_mass) m = 0;
  repulse(c, contact_of(30, 1));
  EXPECT_EQ(load(c.velocity, 0).y, -1);
}

// Friction takes its coefficient times the gain from the sliding speed, at most all: what slides within the cone of
// friction is stopped.
TEST(ProductionClothRepulsions, HaveCoulombsFriction) {
  for (const double slide : {.1, .5, 2.}) {
    ContactCloth<double> c = point_over_triangle({slide, -1, 0});
    repulse(c, contact_of(0, .4));
    const Touching<double> t = c.touching(0);
    EXPECT_NEAR(weighted(t.weight, t.velocity).x, std::max(slide - .4, 0.), 32 * 0x1p-53);
  }
}

// --- Orders

TEST(ProductionClothRepulsions, JacobiDividesAmongEqualContacts) {
  ContactCloth<double> c = point_over_triangle({0, -1, 0});
  for (int copy = 0; copy < 9; ++copy) c.add({0, 1, 2, 3}, {1, -1 / 3., -1 / 3., -1 / 3.});
  serial::repulse_jacobi(c.contacts, contact_of(0, 0), c.inverse_mass, time_step, c.velocity);
  for (int v = 0; v < 4; ++v) EXPECT_NEAR(load(c.velocity, v).y, -.25, 64 * 0x1p-53);  // sums of ten, twice
}

// Where contacts overlap, both orders come to where none approaches.
TEST(ProductionClothRepulsions, OrdersAgreeOnWhereNothingApproaches) {
  for (Repulse<double>* const f : orders) {
    ContactCloth<double> c(40, 60, 0, 7);
    const double start = c.approach();
    for (int round = 0; round < 400; ++round) f(c.contacts, contact_of(0, 0), c.inverse_mass, time_step, c.velocity);
    EXPECT_LT(c.approach(), 1e-6 * start);
  }
}

TEST(ProductionClothRepulsions, BatchesShareNoVertexThatMoves) {
  ContactCloth<float> c(60, 900, 150, 8);
  c.inverse_mass[5] = 0;
  const Batches batches = make_contact_batches(c.contacts, c.inverse_mass);
  EXPECT_GT(batches.count(), 100);  // beyond the room of a vertex
  std::set<std::int32_t> all(batches.order.begin(), batches.order.end());
  EXPECT_EQ(all.size(), c.contacts.count);
  for (int batch = 0; batch < batches.count(); ++batch) {
    std::set<std::int32_t> touched;
    for (int k = batches.begin[batch]; k < batches.begin[batch + 1]; ++k) {
      EXPECT_TRUE(k == batches.begin[batch] || batches.order[k - 1] < batches.order[k]);
      for (int i = 0; i < 4; ++i) {
        const std::int32_t v = c.contacts.corner[4 * batches.order[k] + i];
        EXPECT_TRUE(v == 5 || touched.insert(v).second);
      }
    }
  }
}

TEST(ProductionClothRepulsions, HaveTheSerialBits) {
  for (const int count : {0, 1, 15, 16, 17, 64, 65, 2000})
    for (const int vertices : {30, 700}) {
      ContactCloth<float> c(vertices, count, count / 8, 9);
      c.inverse_mass[0] = 0, c.inverse_mass[7] = 0, c.inverse_mass[9] = 3;
      Vectors<float> in_batches = c.velocity, at_once = c.velocity;
      const auto step = static_cast<float>(time_step);
      serial::repulse_batches(c.contacts, contact_of(30, .4), c.inverse_mass, step, in_batches);
      serial::repulse_jacobi(c.contacts, contact_of(30, .4), c.inverse_mass, step, at_once);
      at_each_team([&] {
        Vectors<float> velocity = c.velocity;
        openmp::repulse_batches(c.contacts, contact_of(30, .4), c.inverse_mass, step, velocity);
        EXPECT_TRUE(same_vectors(in_batches, velocity, vertices)) << count;
        velocity = c.velocity;
        openmp::repulse_jacobi(c.contacts, contact_of(30, .4), c.inverse_mass, step, velocity);
        EXPECT_TRUE(same_vectors(at_once, velocity, vertices)) << count;
      });
    }
}

}  // namespace
}  // namespace lockstep::production_cloth
