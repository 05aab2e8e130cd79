// Impulses against impacts of a cloth: momenta, what they stop and what they leave, friction, orders, the serial bits.
#include "common/production_cloth/impulses.h"

#include "tests/production_cloth_contacts.h"

namespace lockstep::production_cloth {
namespace {

Impulses<double>* const impulse_orders[] = {serial::impulses_original, serial::impulses_batches,
                                            serial::impulses_jacobi};

TEST(ProductionClothImpulses, KeepMomenta) {
  const ContactCloth<double> c(12, 400, 0, 5);
  for (Impulses<double>* const impulses : impulse_orders)
    for (const double friction : {0., .4})
      keeps_momenta(c, friction > 0, [&](const Contacts<double>& impacts, Vectors<double>& velocity) {
        impulses(impacts, friction, c.inverse_mass, velocity);
      });
}

// Impulses at once sum up to 0, too. A vertex rounds each of its sums, of which none is more than all that it adds; a
// contact's impulse is the full one at most.
TEST(ProductionClothImpulses, AtOnceKeepMomentum) {
  constexpr double u = 0x1p-53;
  ContactCloth<double> c(30, 200, 0, 11);
  const Vector3<double> before = c.momentum();
  double bound = 0, pushes = 0;
  for (std::size_t k = 0; k < c.contacts.count; ++k) {
    const Touching<double> t = c.touching(k);
    const double impulse = length(respond(t, StopGain(), .4).impulse);
    for (const double w : t.weight) pushes += std::abs(w) * impulse;
  }
  serial::impulses_jacobi(c.contacts, .4, c.inverse_mass, c.velocity);
  for (int v = 0; v < c.vertices; ++v) bound += 2 * c.vertices * u * length(load(c.velocity, v));
  bound += (c.contacts.count + 4) * u * pushes;
  EXPECT_GT(pushes, 10);
  EXPECT_LE(length(c.momentum() - before), bound);
}

// Two edges that cross in their middles, of 1 kg a vertex, move at each other at 1 m/s each: both stop.
TEST(ProductionClothImpulses, StopEdgesThatCross) {
  ContactCloth<double> c(4, 0, 0, 1);
  store(c.position, 0, {-1, .5, 0}), store(c.position, 1, {1, .5, 0});
  store(c.position, 2, {0, 0, -1}), store(c.position, 3, {0, 0, 1});
  for (int v = 0; v < 4; ++v) store(c.velocity, v, {0, v < 2 ? -1. : 1., 0});
  c.add({0, 1, 2, 3}, {.5, .5, -.5, -.5});
  for (Impulses<double>* const impulses : impulse_orders) {
    Vectors<double> velocity = c.velocity;
    impulses(c.contacts, 0, c.inverse_mass, velocity);
    for (int v = 0; v < 4; ++v) EXPECT_EQ(load(velocity, v).y, 0);
  }
}

TEST(ProductionClothImpulses, LeaveWhatPartsAndWhatIsHeld) {
  ContactCloth<double> c = point_over_triangle({3, 1, 0});
  const Vectors<double> before = c.velocity;
  for (Impulses<double>* const impulses : impulse_orders) impulses(c.contacts, 1, c.inverse_mass, c.velocity);
  EXPECT_TRUE(same_vectors(before, c.velocity, 4));
  c = point_over_triangle({0, -1, 0});
  c.inverse_mass[0] = 0;
  for (Impulses<double>* const impulses : impulse_orders) {
    Vectors<double> velocity = c.velocity;
    impulses(c.contacts, 0, c.inverse_mass, velocity);
    EXPECT_EQ(load(velocity, 0).y, -1);
    for (int v = 1; v < 4; ++v) EXPECT_NEAR(load(velocity, v).y, -1, 8 * 0x1p-53);  // the triangle gives way
  }
}

// What slides within the cone of friction stops.
TEST(ProductionClothImpulses, HaveCoulombsFriction) {
  for (const double slide : {.1, .5, 2.}) {
    ContactCloth<double> c = point_over_triangle({slide, -1, 0});
    serial::impulses_original(c.contacts, .4, c.inverse_mass, c.velocity);
    const Touching<double> t = c.touching(0);
    EXPECT_NEAR(weighted(t.weight, t.velocity).x, std::max(slide - .4, 0.), 32 * 0x1p-53);
    EXPECT_NEAR(c.speed(0), 0, 32 * 0x1p-53);
  }
}

TEST(ProductionClothImpulses, OrdersAgreeOnWhereNothingApproaches) {
  for (Impulses<double>* const impulses : impulse_orders) {
    ContactCloth<double> c(40, 60, 0, 7);
    const double start = c.approach();
    for (int round = 0; round < 400; ++round) impulses(c.contacts, 0, c.inverse_mass, c.velocity);
    EXPECT_LT(c.approach(), 1e-6 * start);
  }
}

TEST(ProductionClothImpulses, HaveTheSerialBits) {
  for (const int count : {0, 1, 15, 16, 17, 2000}) {
    ContactCloth<float> c(50, count, count / 8, 9);
    c.inverse_mass[0] = 0, c.inverse_mass[9] = 3;
    Vectors<float> in_batches = c.velocity, at_once = c.velocity;
    serial::impulses_batches(c.contacts, .4f, c.inverse_mass, in_batches);
    serial::impulses_jacobi(c.contacts, .4f, c.inverse_mass, at_once);
    at_each_team([&] {
      Vectors<float> velocity = c.velocity;
      openmp::impulses_batches(c.contacts, .4f, c.inverse_mass, velocity);
      EXPECT_TRUE(same_vectors(in_batches, velocity, c.vertices)) << count;
      velocity = c.velocity;
      openmp::impulses_jacobi(c.contacts, .4f, c.inverse_mass, velocity);
      EXPECT_TRUE(same_vectors(at_once, velocity, c.vertices)) << count;
    });
  }
}

}  // namespace
}  // namespace lockstep::production_cloth
