// Inelastic zones of a cloth: momenta, the nearest velocities without an approach, sliding, held vertices, bits.
#include "common/production_cloth/inelastic_zones.h"

#include "common/production_cloth/cloth.h"
#include "tests/production_cloth_contacts.h"

namespace lockstep::production_cloth {
namespace {

constexpr double u = 0x1p-53;

struct InelasticCloth {
  ContactCloth<double> c;
  Vectors<double> end;
  InelasticZones<double> zones;
  double time_step = 1 / 64.;

  explicit InelasticCloth(const ContactCloth<double>& cloth) : c(cloth), end(c.position) {
    clear(static_cast<int>(c.inverse_mass.size()), zones);
  }
  void move() {
    serial::move_zones_inelastic(c.contacts, c.inverse_mass, time_step, c.position, zones, end, c.velocity);
  }
  double speed(std::size_t k) const {  // at which a contact parts
    double sum = 0;
    for (int i = 0; i < 4; ++i)
      sum += c.contacts.weight[4 * k + i] *
             dot(Vector3<double>{c.contacts.normal[4 * k], c.contacts.normal[4 * k + 1], c.contacts.normal[4 * k + 2]},
                 load(c.velocity, c.contacts.corner[4 * k + i]));
    return sum;
  }
  double energy() const {
    double sum = 0;
    for (int v = 0; v < c.vertices; ++v) sum += .5 * dot(load(c.velocity, v), load(c.velocity, v));
    return sum;
  }
};

// Every change of an impulse is rounded as a single impulse is: a new velocity once, and its change six times. A sweep
// changes a velocity by less than 8 m/s, and there are at most most_inelastic_sweeps of them.
TEST(ProductionClothInelasticZones, KeepMomenta) {
  for (const int count : {1, 4, 20}) {
    InelasticCloth z(ContactCloth<double>(60, count, 0, 3));
    const Vector3<double> linear = z.c.momentum(), angular = z.c.angular_momentum();
    z.move();
    const double bound = u * 4 * count * most_inelastic_sweeps * (8 + 6 * 8) + 60 * 2 * 60 * u * 8;
    EXPECT_LE(length(z.c.momentum() - linear), bound);
    EXPECT_LE(length(z.c.angular_momentum() - angular), 2 * std::sqrt(3) * bound);
  }
}

// The conditions of the least: impacts part or rest, impulses push, and push only where an impact rests; the change of
// each velocity is what impulses make of it. What is left of a speed is at most a few times the last change of a sweep:
// contraction here is far below .9, so that the changes that are left sum to ten times the last.
TEST(ProductionClothInelasticZones, FindTheNearestVelocitiesWithoutAnApproach) {
  InelasticCloth z(ContactCloth<double>(60, 20, 0, 5));
  double most = 0;
  for (std::size_t k = 0; k < z.c.contacts.count; ++k) most = std::max(most, -z.speed(k));
  const double before = z.energy();
  const Vectors<double> from = z.c.velocity;
  z.move();
  const double left = 10 * tolerance_of_inelastic * most;
  Vectors<double> expected = from;
  for (std::size_t k = 0; k < z.c.contacts.count; ++k) {
    EXPECT_GE(z.speed(k), -left) << k;
    EXPECT_GE(z.zones.impulse[k], 0);
    if (z.zones.impulse[k] > 0) {
      EXPECT_LE(z.speed(k), left) << k;
    }
    const double* const n = &z.c.contacts.normal[4 * k];
    for (int i = 0; i < 4; ++i) {
      const int v = z.c.contacts.corner[4 * k + i];
      store(expected, v,
            load(expected, v) +
                (z.zones.impulse[k] * z.c.contacts.weight[4 * k + i]) * Vector3<double>{n[0], n[1], n[2]});
    }
  }
  // A velocity and its change are rounded as above, by each sweep.
  for (int v = 0; v < 60; ++v)
    EXPECT_LE(length(load(z.c.velocity, v) - load(expected, v)), 4 * 20 * most_inelastic_sweeps * 56 * u);
  for (const std::int32_t v : z.zones.zones.vertex)
    EXPECT_LE(length(load(z.end, v) - (load(z.c.position, v) + z.time_step * load(z.c.velocity, v))), 4 * u);
  EXPECT_LT(z.energy(), before);
}

// Beads on a line, each two vertices, whose velocities must not fall from left to right. The nearest such velocities
// are the isotonic regression, which pooling of neighbours that violate the order finds.
TEST(ProductionClothInelasticZones, AreTheIsotonicRegressionOnALine) {
  constexpr int beads = 6;
  const double speeds[beads] = {.5, 2, -1, 0, 3, -2};
  ContactCloth<double> c(2 * beads, 0, 0, 1);
  for (int v = 0; v < 2 * beads; ++v)
    store(c.position, v, {double(v / 2), 0, v % 2 ? .5 : -.5}), store(c.velocity, v, {speeds[v / 2], 1. * v, 0});
  for (int b = 0; b + 1 < beads; ++b) c.add({2 * b + 2, 2 * b + 3, 2 * b, 2 * b + 1}, {.5, .5, -.5, -.5});
  InelasticCloth z(c);
  z.move();
  struct Pool {
    double sum;
    int count;
  };
  std::vector<Pool> pools;
  for (const double speed : speeds) {
    pools.push_back({speed, 1});
    while (pools.size() > 1) {
      const Pool last = pools.back(), other = pools[pools.size() - 2];
      if (other.sum / other.count <= last.sum / last.count) break;
      pools.pop_back(), pools.back() = {other.sum + last.sum, other.count + last.count};
    }
  }
  std::vector<double> expected;
  for (const Pool& pool : pools) expected.insert(expected.end(), pool.count, pool.sum / pool.count);
  // Sweeps over five impacts in a row contract by cos^2(pi / 6) = 3/4: what is left is three times the last change, of
  // at most a ten-thousandth of 5 m/s, for each of two impacts of a bead.
  for (int v = 0; v < 2 * beads; ++v) {
    EXPECT_NEAR(load(z.c.velocity, v).x, expected[v / 2], 2 * 3 * tolerance_of_inelastic * 5);
    EXPECT_EQ(load(z.c.velocity, v).y, v);  // along the contacts everything slides on
  }
}

// Impacts of an earlier call are not forgotten: stopping the second does not bring back the first.
TEST(ProductionClothInelasticZones, KeepImpactsOfEarlierCalls) {
  ContactCloth<double> c(6, 0, 0, 1);
  for (int v = 0; v < 6; ++v)
    store(c.position, v, {double(v / 2), 0, v % 2 ? .5 : -.5}), store(c.velocity, v, {v / 2 == 0 ? 3. : 0., 0, 0});
  c.add({2, 3, 0, 1}, {.5, .5, -.5, -.5}), c.add({4, 5, 2, 3}, {.5, .5, -.5, -.5});
  InelasticCloth z(c);
  for (const std::size_t k : {0, 1}) {
    const Contacts<double> one = c.only(k);
    serial::move_zones_inelastic(one, z.c.inverse_mass, z.time_step, z.c.position, z.zones, z.end, z.c.velocity);
  }
  for (int v = 0; v < 6; ++v) EXPECT_NEAR(load(z.c.velocity, v).x, 1, 2 * 3 * tolerance_of_inelastic * 3);
  EXPECT_EQ(z.zones.impacts.count, 2u);
}

// A point that falls on a held triangle stops along the normal, and keeps what it slides; held vertices are left alone.
TEST(ProductionClothInelasticZones, StopAtHeldVerticesAndSlide) {
  ContactCloth<double> c = point_over_triangle({.75, -2, .5});
  for (const int v : {1, 2, 3}) c.inverse_mass[v] = 0;
  InelasticCloth z(c);
  z.move();
  EXPECT_EQ(load(z.c.velocity, 0).x, .75);
  EXPECT_NEAR(load(z.c.velocity, 0).y, 0, 8 * u);
  EXPECT_EQ(load(z.c.velocity, 0).z, .5);
  for (const int v : {1, 2, 3}) EXPECT_EQ(load(z.end, v).y, 0);
  c.inverse_mass[0] = 0;
  InelasticCloth held(c);
  held.move();
  EXPECT_EQ(load(held.c.velocity, 0).y, -2);
}

TEST(ProductionClothInelasticZones, HaveTheSerialBits) {
  for (const int count : {0, 1, 15, 16, 17, 60, 1000}) {
    ContactCloth<float> c(900, count, 0, 9);
    for (int v = 0; v < 900; v += 50) c.inverse_mass[v] = 0;
    const auto moved = [&](MoveInelasticZones<float>* move_zones) {
      InelasticZones<float> zones;
      clear(static_cast<int>(c.inverse_mass.size()), zones);
      Motion<float> motion = {c.position, c.velocity};
      for (int round = 0; round < 2; ++round)
        move_zones(c.contacts, c.inverse_mass, .01f, c.position, zones, motion.position, motion.velocity);
      return std::pair{motion, zones.impulse};
    };
    MoveInelasticZones<float>* const in_serial = serial::move_zones_inelastic;
    const auto expected = moved(in_serial);
    at_each_team([&] {
      const auto found = moved(openmp::move_zones_inelastic);
      EXPECT_TRUE(same_vectors(expected.first.position, found.first.position, 900));
      EXPECT_TRUE(same_vectors(expected.first.velocity, found.first.velocity, 900));
      EXPECT_TRUE(expected.second == found.second);
    });
  }
}

}  // namespace
}  // namespace lockstep::production_cloth
