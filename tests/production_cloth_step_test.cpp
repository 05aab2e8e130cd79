// Whole steps of the production cloth: what is known of them without a simulation, and that bits do not depend on
// threads.
#include "common/production_cloth/step.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/input_error.h"
#include "common/production_cloth/intersections.h"
#include "tests/production_cloth_contacts.h"
#include "tests/temporary_folder.h"
#include "verify/production_cloth/moving.h"

namespace lockstep::production_cloth {
namespace {

struct ProductionClothStep : TemporaryFolder {
  Scene scene_of(const std::string& text) const {
    write_bytes(path("a.toml"), "kind = \"production_cloth\"\n" + text);
    return load_scene(path("a.toml"));
  }
};

const std::string small_sheet =
    "[[sheet]]\norigin = [0, 0, 0]\nacross = [0.5, 0, 0]\ndown = [0, 0, 0.5]\nsquares = [8, 8]\n";

// A scene that steps, serially unless told otherwise.
struct SteppedCloth {
  Scene scene;
  Cloth<float> cloth;
  Motion<float> motion;
  StepMemory<float> memory;
  int steps = 0;

  explicit SteppedCloth(const Scene& scene)
      : scene(scene),
        cloth(verify::make_cloth(scene)),
        motion(verify::motion_at_rest(scene)),
        memory(serial::make_memory(cloth)) {}

  double time() const { return steps * scene.frame_time / scene.substeps; }
  void step(Step<float>* form = serial::step_original) {
    const double start = time();
    ++steps;
    form(cloth, script_of(scene, start, time()), motion, memory);
  }
  double energy_of_motion() const {
    double sum = 0;
    for (int v = 0; v < cloth.topology.vertices; ++v)
      sum += .5 * cloth.mass[v] * dot(load(motion.velocity, v), load(motion.velocity, v));
    return sum;
  }
};

// Nothing deforms what falls, but rounding: springs are off by two units of their stiffness at the most, which
// accelerates a vertex of eight springs by 16 u Y / m. All vertices fall as far as they should; each step rounds
// position and velocity to half a unit in the last place of what they are, and h g as well.
TEST_F(ProductionClothStep, FallsFreelyWithoutADeformation) {
  SteppedCloth cloth(
      scene_of("gravity = [0, -9.75, 0]\nframe_time = 0.015625\nsubsteps = 16\n[material]\n"
               "stiffness = 1\nbend = \"none\"\n" +
               small_sheet));
  for (int k = 0; k < 64; ++k) cloth.step();
  const double t = cloth.time();
  float lightest = 1;
  for (int v = 0; v < cloth.cloth.topology.vertices; ++v) lightest = std::min(lightest, cloth.cloth.mass[v]);
  const double off = .5 * t * t * 16 * 0x1p-24 / lightest;
  for (int v = 0; v < cloth.cloth.topology.vertices; ++v) {
    EXPECT_NEAR(cloth.motion.position.y[v], cloth.motion.position.y[0], off);
    EXPECT_NEAR(cloth.motion.position.x[v], cloth.scene.rest.x[v], off);
  }
  EXPECT_NEAR(cloth.motion.velocity.y[0], -9.75 * t, 64 * 3 * .6 * 0x1p-24 + 2 * off / t);
  EXPECT_NEAR(cloth.motion.position.y[0], -.5 * 9.75 * t * t,
              64 * (.02 * 0x1p-24 + t / 64 * 64 * 3 * .6 * 0x1p-24) + off);
}

// Held vertices are where the scene has them, to the bit, whatever the rest of the cloth does.
TEST_F(ProductionClothStep, HoldsVerticesInTheirPlaces) {
  SteppedCloth cloth(scene_of("substeps = 20\n" + small_sheet +
                              "[[hold]]\nfrom = [0, 0, 0]\nto = [0, 0, 1]\n[[hold.key]]\ntime = 0\n[[hold.key]]\n"
                              "time = 1\nshift = [0.25, 0.5, 0]\n"));
  for (int k = 0; k < 30; ++k) cloth.step();
  const Script<float> now = script_of(cloth.scene, 0, cloth.time());
  ASSERT_EQ(now.held.size(), 9);
  for (std::size_t k = 0; k < now.held.size(); ++k) {
    EXPECT_EQ(cloth.motion.position.x[now.held[k]], now.place.x[k]);
    EXPECT_EQ(cloth.motion.position.y[now.held[k]], now.place.y[k]);
    EXPECT_NEAR(cloth.motion.velocity.y[now.held[k]], .5, 1e-3);  // a difference of floats over 1/1200 s
  }
  EXPECT_LT(cloth.motion.position.y[cloth.cloth.topology.vertices - 1], .02);
}

// A cloth on a ball comes to rest: in three seconds its energy of motion falls below a hundredth of its greatest.
TEST_F(ProductionClothStep, ComesToRestOnABall) {
  SteppedCloth cloth(scene_of("substeps = 10\n" + small_sheet +
                              "[material]\nstiffness = 1\nstretch_damping = 2\nbend_damping = 0.5\n"
                              "[[sphere]]\ncentre = [0.25, -0.22, 0.25]\nradius = 0.2\nfriction = 1\n"));
  cloth.memory = openmp::make_memory(cloth.cloth);
  double greatest = 0;
  for (int k = 0; k < 1800; ++k) {
    cloth.step(openmp::step_batches);
    greatest = std::max(greatest, cloth.energy_of_motion());
  }
  EXPECT_GT(greatest, 1e-3);
  EXPECT_LT(cloth.energy_of_motion(), 1e-2 * greatest);
}

struct Forms {
  Step<float>*serial, *openmp;
};

// Step by step: the same bits at every number of threads, and never an intersection. Returns what the steps took.
std::vector<Collided> steps_alike(const std::string& name, int steps, const Forms& forms) {
  const Scene scene = load_scene("scenes/production_cloth/" + name + ".toml");
  SteppedCloth expected(scene);
  std::vector<Collided> collided;
  for (int k = 0; k < steps; ++k) {
    expected.step(forms.serial);
    collided.push_back(expected.memory.took.collided);
    EXPECT_EQ(count_intersections(expected.cloth.topology, expected.motion.position), 0) << "step " << k;
  }
  at_each_team([&] {
    SteppedCloth cloth(scene);
    cloth.memory = openmp::make_memory(cloth.cloth);
    for (int k = 0; k < steps; ++k) cloth.step(forms.openmp);
    EXPECT_TRUE(same_vectors(cloth.motion.position, expected.motion.position, scene.topology.vertices));
    EXPECT_TRUE(same_vectors(cloth.motion.velocity, expected.motion.velocity, scene.topology.vertices));
  });
  return collided;
}

constexpr Forms by_batches = {serial::step_batches, openmp::step_batches};
constexpr Forms by_jacobi = {serial::step_jacobi, openmp::step_jacobi};

// Impulses do.
void crumples_alike(const Forms& forms) {
  int impacts = 0;
  for (const Collided& c : steps_alike("crumple", 60, forms)) impacts += c.impacts;
  EXPECT_GT(impacts, 100);
}
TEST_F(ProductionClothStep, CrumplesToTheSameBitsInBatches) { crumples_alike(by_batches); }
TEST_F(ProductionClothStep, CrumplesToTheSameBitsByJacobi) { crumples_alike(by_jacobi); }

// Zones are needed, and may not do: such a step is cut off, and leaves no intersection either.
void is_wrung_alike(const Forms& forms) {
  int zones = 0;
  for (const Collided& c : steps_alike("wrung_tube", 110, forms)) zones += c.zone_vertices;
  EXPECT_GT(zones, 0);
}
TEST_F(ProductionClothStep, IsWrungToTheSameBitsInBatches) { is_wrung_alike(by_batches); }
TEST_F(ProductionClothStep, IsWrungToTheSameBitsByJacobi) { is_wrung_alike(by_jacobi); }

// So do inelastic zones.
void slides_alike(const Forms& forms) {
  int rounds = 0;
  for (const Collided& c : steps_alike("wrung_tube_slides", 110, forms)) rounds += c.inelastic_rounds;
  EXPECT_GT(rounds, 0);
}
TEST_F(ProductionClothStep, SlidesToTheSameBitsInBatches) { slides_alike(by_batches); }
TEST_F(ProductionClothStep, SlidesToTheSameBitsByJacobi) { slides_alike(by_jacobi); }

TEST_F(ProductionClothStep, RefusesStepsThatAreUnstable) {
  const std::string stiff = small_sheet + "[material]\nstiffness = 100\n";
  try {
    verify::require_stability(scene_of("substeps = 2\n" + stiff));
    FAIL();
  } catch (const InputError& error) {
    const std::string text = error.what(), from = "expected substeps of at least ";
    const std::size_t place = text.find(from);
    ASSERT_NE(place, std::string::npos) << text;
    verify::require_stability(scene_of("substeps = " + text.substr(place + from.size()) + "\n" + stiff));
  }
}

// Two masses and a spring of stiffness k: w^2 = k (1 / m1 + 1 / m2). One edge's far vertices held leave one degree of
// freedom along it.
TEST_F(ProductionClothStep, KnowsTheHighestFrequency) {
  const Scene scene = scene_of(
      "[[sheet]]\norigin = [0, 0, 0]\nacross = [0.5, 0, 0]\ndown = [0, 0, 0.5]\nsquares = [1, 1]\n"
      "[material]\nstiffness = 2\nbend = \"none\"\n"
      "[[hold]]\nfrom = [-1, -1, -1]\nto = [0.1, 1, 1]\n[[hold]]\nfrom = [0.4, -1, 0.4]\nto = [1, 1, 1]\n");
  // The free vertex is at (.5, 0, 0). It has the edges of its triangles: two sides, and the diagonal if it is there.
  const auto& t = scene.topology;
  int free = -1;
  for (int v = 0; v < 4; ++v)
    if (scene.rest.x[v] > .4 && scene.rest.z[v] < .1) free = v;
  double xx = 0, xz = 0, zz = 0, mass = 0;
  for (const auto& [a, b] : t.edges) {
    if (a != free && b != free) continue;
    const Vector3<double> along = load(scene.rest, b) - load(scene.rest, a);
    const double length = std::sqrt(dot(along, along)), k = 2 / length;
    xx += k * along.x * along.x / (length * length), zz += k * along.z * along.z / (length * length);
    xz += k * along.x * along.z / (length * length);
  }
  for (std::size_t k = 0; k < t.triangles.size(); ++k)
    for (const std::int32_t v : t.corners(k)) mass += v == free ? scene.material.density * .125 / 3 : 0;
  const double greatest = .5 * (xx + zz + std::hypot(xx - zz, 2 * xz));
  // Forty rounds from a start that is not orthogonal; differences over a millionth of an edge.
  EXPECT_NEAR(verify::highest_frequency(scene), std::sqrt(greatest / mass), 1e-4 * std::sqrt(greatest / mass));
}

}  // namespace
}  // namespace lockstep::production_cloth
