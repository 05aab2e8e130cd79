// Rigid zones of a cloth: unions, momenta, rigid motions, held vertices; and the rounds of collisions.
#include "common/production_cloth/zones.h"

#include "common/production_cloth/collide.h"
#include "common/production_cloth/impulses.h"
#include "tests/production_cloth_contacts.h"

namespace lockstep::production_cloth {
namespace {

constexpr double u = 0x1p-53;

struct ZonesOfCloth {
  ContactCloth<double> c;
  Vectors<double> end;
  Zones zones;
  double time_step = 1 / 64.;

  ZonesOfCloth(int vertices, int count, int seed) : c(vertices, count, 0, seed), end(c.position) {
    for (int v = 0; v < vertices; ++v) store(end, v, load(c.position, v) + time_step * load(c.velocity, v));
    clear(static_cast<int>(c.inverse_mass.size()), zones);
  }
  void move() { serial::move_zones(c.contacts, c.inverse_mass, time_step, c.position, zones, end, c.velocity); }
  double distance(const Vectors<double>& x, int a, int b) const { return length(load(x, a) - load(x, b)); }
};

TEST(ProductionClothZones, UniteWhatImpactsJoin) {
  ContactCloth<float> c(40, 0, 0, 1);
  Zones zones;
  clear(static_cast<int>(c.inverse_mass.size()), zones);
  c.add({30, 9, 12, 20}, {1, -.5, -.25, -.25}), c.add({1, 2, 3, 4}, {1, -.5, -.25, -.25});
  unite(c.contacts, zones);
  EXPECT_EQ(zones.vertex, (Array<std::int32_t>{1, 2, 3, 4, 9, 12, 20, 30}));
  EXPECT_EQ(zones.begin, (Array<std::int32_t>{0, 4, 8}));
  Contacts<float> next = c.only(0);  // of a later round
  next.corner[0] = 4, next.corner[1] = 12, next.corner[2] = 39, next.corner[3] = 0;
  unite(next, zones);
  EXPECT_EQ(zones.vertex, (Array<std::int32_t>{0, 1, 2, 3, 4, 9, 12, 20, 30, 39}));
  EXPECT_EQ(zones.begin, (Array<std::int32_t>{0, 10}));
  for (const std::int32_t v : zones.vertex) EXPECT_EQ(zones.parent[v], 0);
  EXPECT_EQ(zones.parent[5], 5);
}

// A velocity is a difference of positions up to 2, each rounded five times, over the time step.
TEST(ProductionClothZones, KeepMomentumAndDistances) {
  for (const int count : {1, 4, 40}) {
    ZonesOfCloth z(40, count, 3);
    const Vector3<double> before = z.c.momentum();
    z.move();
    EXPECT_LE(length(z.c.momentum() - before), 40 * std::sqrt(3) * 12 * 2 * u / z.time_step);
    for (std::size_t zone = 0; zone + 1 < z.zones.begin.size(); ++zone)
      for (int k = z.zones.begin[zone]; k < z.zones.begin[zone + 1]; ++k) {
        const int a = z.zones.vertex[z.zones.begin[zone]], b = z.zones.vertex[k];
        EXPECT_NEAR(z.distance(z.end, a, b), z.distance(z.c.position, a, b), 64 * u);
      }
    if (count == 40) {
      EXPECT_EQ(z.zones.begin.size(), 2u);  // one zone of all that is touched
    }
  }
}

// I w dt = L dt. A turn by an angle a moves what is at r from the centre by w dt x r, but for a^2 / 2 |r|. Rounding is
// that of velocities, as above.
TEST(ProductionClothZones, KeepAngularMomentumUpToTheChord) {
  ZonesOfCloth z(40, 200, 3);
  z.time_step = 1e-5;
  const Vector3<double> before = z.c.angular_momentum();
  Vector3<double> centre = {0, 0, 0}, mean = {0, 0, 0};
  for (int v = 0; v < 40; ++v) {
    centre = centre + (1 / 40.) * load(z.c.position, v), mean = mean + (1 / 40.) * load(z.c.velocity, v);
  }
  Inertia inertia;
  double squares = 0, arms = 0;
  for (int v = 0; v < 40; ++v) {
    const Vector3<double> r = load(z.c.position, v) - centre;
    inertia.add(1, r, z.time_step * (load(z.c.velocity, v) - mean));
    squares += dot(r, r), arms += length(load(z.c.position, v));
  }
  z.move();
  ASSERT_EQ(z.zones.vertex.size(), 40u);
  const double angle = length(turn_of(inertia));
  EXPECT_GT(angle, 1e-7);
  EXPECT_LE(length(z.c.angular_momentum() - before),
            .5 * angle * angle * squares / z.time_step + arms * std::sqrt(3) * 12 * 2 * u / z.time_step);
}

// Vertices that move as a rigid body keep their motion, whatever it is.
TEST(ProductionClothZones, LeaveRigidMotionsAsTheyAre) {
  ZonesOfCloth z(40, 200, 5);
  const Vector3<double> spin = {.3, -.5, .2};
  for (int v = 0; v < 40; ++v) store(z.c.velocity, v, cross(spin, load(z.c.position, v)) + Vector3<double>{1, 2, 3});
  z.move();
  const Matrix3<double> r = rotation_by(z.time_step * spin);
  Vector3<double> centre = {0, 0, 0};
  for (int v = 0; v < 40; ++v) centre = centre + (1 / 40.) * load(z.c.position, v);
  const Vector3<double> shift = z.time_step * (cross(spin, centre) + Vector3<double>{1, 2, 3});
  for (int v = 0; v < 40; ++v) {
    const Vector3<double> expected = (centre + shift) + r * (load(z.c.position, v) - centre);
    EXPECT_LE(length(load(z.end, v) - expected), 400 * u);  // sums of forty, ten roundings a term
  }
}

// Held vertices go where they are to go; when they move rigidly, the others move with them.
TEST(ProductionClothZones, FollowHeldVertices) {
  for (const int held : {1, 2, 3, 10})
    for (const double angle : {0., .4}) {
      ZonesOfCloth z(40, 200, 6);
      const Matrix3<double> r = rotation_by({0, angle, 0});
      const auto moved = [&](int v) { return r * load(z.c.position, v) + Vector3<double>{.1, .2, .3}; };
      for (int v = 0; v < held; ++v) z.c.inverse_mass[v] = 0, store(z.end, v, moved(v));
      const Vectors<double> before = z.c.velocity;
      z.move();
      for (int v = 0; v < 40; ++v) {
        if (v < held) {
          EXPECT_EQ(load(z.end, v).x, moved(v).x);
          EXPECT_EQ(load(z.c.velocity, v).x, load(before, v).x);
        } else if (held >= 3 || angle == 0) {
          // What is left of an angle a is a^3 / 6 after each step: .4, .011, 2e-7, 2e-21.
          EXPECT_LE(length(load(z.end, v) - moved(v)), 1e-13) << held << ' ' << v;
          const Vector3<double> way = (1 / z.time_step) * (load(z.end, v) - load(z.c.position, v));
          EXPECT_LE(length(load(z.c.velocity, v) - way), 8 * u / z.time_step);
        }
      }
    }
}

TEST(ProductionClothZones, HaveTheSerialBits) {
  for (const int count : {0, 1, 15, 16, 17, 60, 2000}) {
    ContactCloth<float> c(900, count, 0, 9);
    for (int v = 0; v < 900; v += 50) c.inverse_mass[v] = 0;
    Zones zones;
    clear(static_cast<int>(c.inverse_mass.size()), zones);
    const auto step = [&](bool in_lanes, Zones& z, Vectors<float>& end, Vectors<float>& velocity) {
      MoveZones<float>* const serial_form = serial::move_zones;
      MoveZones<float>* const move_zones = in_lanes ? openmp::move_zones : serial_form;
      move_zones(c.contacts, c.inverse_mass, .01f, c.position, z, end, velocity);
    };
    Zones expected = zones;
    Vectors<float> end = c.position, velocity = c.velocity;
    step(false, expected, end, velocity);
    at_each_team([&] {
      Zones z = zones;
      Vectors<float> e = c.position, v = c.velocity;
      step(true, z, e, v);
      EXPECT_TRUE(same_vectors(end, e, 900) && same_vectors(velocity, v, 900));
      EXPECT_TRUE(z.parent == expected.parent && z.vertex == expected.vertex && z.begin == expected.begin);
    });
  }
}

// --- Rounds

// Beads on a line, which meet where they would change places: impacts without a kernel that finds them. Each bead is
// four vertices, so that a contact has two beads' edges.
struct BeadsOnALine {
  ContactCloth<double> c;
  Vectors<double> end;
  int beads;
  double time_step = 1;

  explicit BeadsOnALine(int beads) : c(2 * beads, 0, 0, 1), end(c.position), beads(beads) {
    for (int v = 0; v < 2 * beads; ++v) {
      store(c.position, v, {double(v / 2), 0, v % 2 ? .5 : -.5});
      store(c.velocity, v, {v / 2 < beads / 2 ? 2. : -2., 0, 0});
      store(end, v, load(c.position, v) + load(c.velocity, v));
    }
  }
  void find(Contacts<double>& impacts) const {
    ContactCloth<double> met = c;
    met.contacts.resize(0);
    for (int b = 0; b + 1 < beads; ++b)
      if (load(end, 2 * b).x >= load(end, 2 * b + 2).x)
        met.add({2 * b + 2, 2 * b + 3, 2 * b, 2 * b + 1}, {.5, .5, -.5, -.5});
    impacts = met.contacts;
  }
  Collided collide(bool with_impulses, CollideMemory<double>& memory, ZoneForm form = ZoneForm::rigid) {
    const auto find_impacts = [&](const Vectors<double>&, const Vectors<double>&, Contacts<double>& impacts) {
      find(impacts);
    };
    const auto impulses = [&](const Contacts<double>& impacts, Vectors<double>& velocity) {
      if (with_impulses) serial::impulses_original(impacts, 0, c.inverse_mass, velocity);
    };
    const ZoneKernels<double> zones = {serial::move_zones, serial::move_zones_inelastic, form};
    return production_cloth::collide(find_impacts, impulses, zones, c.inverse_mass, time_step, c.position, end,
                                     c.velocity, memory);
  }
};

TEST(ProductionClothCollide, EndsWithImpulsesWhereTheyDo) {
  BeadsOnALine beads(2);
  CollideMemory<double> memory;
  const Collided collided = beads.collide(true, memory);
  EXPECT_TRUE(collided.free);
  EXPECT_EQ(collided.rounds, 1);
  EXPECT_EQ(collided.impacts, 1);
  EXPECT_EQ(collided.zone_rounds, 0);
  EXPECT_LT(load(beads.end, 0).x, load(beads.end, 2).x);
}

TEST(ProductionClothCollide, EndsWithZonesWhereImpulsesDoNot) {
  for (const bool with_impulses : {false, true}) {
    BeadsOnALine beads(20);
    CollideMemory<double> memory;
    const Vector3<double> before = beads.c.momentum();
    const Collided collided = beads.collide(with_impulses, memory);
    EXPECT_TRUE(collided.free);
    EXPECT_EQ(collided.rounds, most_impulse_rounds);
    EXPECT_GT(collided.zone_rounds, 0);
    EXPECT_GT(collided.zone_vertices, 0);
    for (int b = 0; b + 1 < 20; ++b) EXPECT_LT(load(beads.end, 2 * b).x, load(beads.end, 2 * b + 2).x);
    EXPECT_LE(length(beads.c.momentum() - before), 400 * 40 * u);
  }
}

// Inelastic zones stop the beads, too; then no rigid zone is needed.
TEST(ProductionClothCollide, EndsWithInelasticZones) {
  BeadsOnALine beads(20);
  CollideMemory<double> memory;
  const Vector3<double> before = beads.c.momentum();
  const Collided collided = beads.collide(true, memory, ZoneForm::inelastic);
  EXPECT_TRUE(collided.free);
  EXPECT_EQ(collided.rounds, most_impulse_rounds);
  EXPECT_GT(collided.inelastic_rounds, 0);
  EXPECT_EQ(collided.zone_rounds, 0);
  for (int b = 0; b + 1 < 20; ++b) EXPECT_LT(load(beads.end, 2 * b).x, load(beads.end, 2 * b + 2).x);
  EXPECT_LE(length(beads.c.momentum() - before), 400 * 40 * u);
}

// Held vertices that pass through each other cannot be helped: the answer says so, after a bounded number of rounds.
TEST(ProductionClothCollide, SaysWhereItCannotEnd) {
  BeadsOnALine beads(2);
  for (double& m : beads.c.inverse_mass) m = 0;
  CollideMemory<double> memory;
  const Collided collided = beads.collide(true, memory);
  EXPECT_FALSE(collided.free);
  EXPECT_EQ(collided.zone_rounds, most_zone_rounds);
  EXPECT_EQ(load(beads.end, 0).x, 2);
}

}  // namespace
}  // namespace lockstep::production_cloth
