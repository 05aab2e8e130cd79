// The velocity in the air against facts: what a plane surface continues, what stays as it was, and that no order of
// faces and no number of threads changes a bit.
#include <gtest/gtest.h>
#include <omp.h>

#include <map>
#include <random>
#include <string>

#include "common/levelset/field.h"
#include "common/production_fluid/extrapolate.h"
#include "common/production_fluid/scene.h"
#include "tests/production_fluids.h"

namespace lockstep::production_fluid {
namespace {

template <class Real>
void set_velocity(Fluid<Real>& fluid, const auto& value) {
  const double h = fluid.spacing;
  Field<Real>* const components[] = {&fluid.velocity.u, &fluid.velocity.v, &fluid.velocity.w};
  for (int axis = 0; axis < 3; ++axis)
    for_each_place(*components[axis], [&](int x, int y, int z) {
      const auto along = [&](int i, int a) { return (i + (a == axis ? 0 : .5)) * h; };
      (*components[axis])(x, y, z) = static_cast<Real>(value(axis, along(x, 0), along(y, 1), along(z, 2)));
    });
}

// What the contract says of a face by itself.
struct FaceState {
  double distance;
  bool closed, known;
};
template <class Real>
FaceState state_of(const Fluid<Real>& fluid, int axis, int x, int y, int z) {
  const int ax = x - (axis == 0), ay = y - (axis == 1), az = z - (axis == 2);
  const Kind a = cell_at(fluid, ax, ay, az), b = cell_at(fluid, x, y, z);
  const bool closed = a == Kind::closed || b == Kind::closed;
  const auto phi = [&](int x, int y, int z) {
    if (fluid.open_top && y == fluid.ny) return fluid.phi(x, y - 1, z);
    const bool in_box = x >= 0 && x < fluid.nx && y >= 0 && y < fluid.ny && z >= 0 && z < fluid.nz;
    return in_box ? fluid.phi(x, y, z) : Real(0);
  };
  const Real of_a = a == Kind::closed ? phi(x, y, z) : phi(ax, ay, az),
             of_b = b == Kind::closed ? phi(ax, ay, az) : phi(x, y, z), mean = (of_a + of_b) * Real(.5);
  const Real distance = of_a >= 0 && of_b >= 0 ? std::max(mean, Real(1e-30f)) : mean;
  return {distance, closed, closed || a == Kind::liquid || b == Kind::liquid};
}

constexpr double u = std::numeric_limits<float>::epsilon() / 2;

struct Version {
  const char* name;
  Extrapolate<float>* extrapolate;
};
const Version versions[] = {{"serial", serial::extrapolate}, {"openmp", openmp::extrapolate}};

// Along the normal of a level surface, velocity is copied: to the bit.
TEST(ProductionFluidExtrapolate, CopiesAlongANormalThatIsAnAxis) {
  for (const Version& version : versions)
    for (const int nx : {1, 15, 16, 17, 33}) {
      constexpr double h = .1;
      Fluid<float> fluid = make_fluid<float>(nx, 12, 5, h, [&](double, double y, double) { return y - .43; });
      const auto flow = [](int axis, double x, double, double z) { return std::sin(7 * x + 3 * z + axis); };
      set_velocity(fluid, [&](int axis, double x, double y, double z) {
        return y > .43 ? 1e3 : flow(axis, x, y, z);  // what was in the air before must not matter
      });
      version.extrapolate(fluid, 3 * fluid.spacing, fluid.velocity);
      for_each_face(
          fluid, fluid.velocity, [&](const Field<float>& component, int axis, int x, int y, int z, Kind a, Kind b) {
            if (a == Kind::closed || b == Kind::closed) return;
            const double height = (y + (axis == 1 ? 0 : .5)) * h;
            const double expected = height < .43 + 3 * h ? component(x, 1, z) : 0;
            EXPECT_EQ(component(x, y, z), static_cast<float>(expected)) << version.name << ' ' << axis << ' ' << y;
          });
    }
}

// u linear, and constant along the normal: the weights are the normal's components, so that the mean of the nearer
// neighbours is the face's own value. Where a side of the box cuts neighbours off, it is not.
TEST(ProductionFluidExtrapolate, ContinuesAcrossATiltedPlane) {
  constexpr int n = 32;
  constexpr double h = 1. / n, nx = .6, ny = .48, nz = .64;
  const auto distance = [&](double x, double y, double z) {
    return nx * (x - .5) + ny * (y - .5) + nz * (z - .5) - .013 * h;
  };
  const auto flow = [&](int axis, double x, double y, double z) {
    return 1 + axis + (ny * x - nx * y) + (nz * y - ny * z);
  };
  for (const Version& version : versions) {
    Fluid<float> fluid = make_fluid<float>(n, n, n, h, distance);
    set_velocity(fluid, flow);
    Field<float>* const components[] = {&fluid.velocity.u, &fluid.velocity.v, &fluid.velocity.w};
    for (int axis = 0; axis < 3; ++axis)
      for_each_place(*components[axis], [&](int x, int y, int z) {
        if (!state_of(fluid, axis, x, y, z).known) (*components[axis])(x, y, z) = -50;
      });
    version.extrapolate(fluid, 3 * fluid.spacing, fluid.velocity);
    int compared = 0;
    double worst = 0;
    for_each_face(fluid, fluid.velocity, [&](const Field<float>& component, int axis, int x, int y, int z, Kind, Kind) {
      // Three cells of distance are at most 3 / .48 along an axis.
      if (std::min({x, y, z}) < 8 || std::max({x, y, z}) > n - 8) return;
      const double px = (x + (axis == 0 ? 0 : .5)) * h, py = (y + (axis == 1 ? 0 : .5)) * h,
                   pz = (z + (axis == 2 ? 0 : .5)) * h, d = distance(px, py, pz);
      if (d < 1e-5 || d > 3 * h - 1e-5) return;
      const double error = std::abs(component(x, y, z) - flow(axis, px, py, pz));
      worst = std::max(worst, error), ++compared;
      // A step rounds seven times numbers of at most 5, and weights of at least .48 h by the rounding of
      // three distances of at most 1, times what neighbours differ by, at most 1.2 h; 18 steps.
      EXPECT_LE(error, 18 * (7 * 5 * u + 3 * 2 * u / .48 * 1.2)) << version.name << ' ' << axis;
    });
    EXPECT_GT(compared, 3000);
    std::printf("tilted plane, %s: %d faces, worst error %.2e\n", version.name, compared, worst);
  }
}

TEST(ProductionFluidExtrapolate, ContinuesAConstantToTheBit) {
  for (const Version& version : versions) {
    Fluid<float> fluid = make_fluid<float>(
        24, 20, 22, .05, [](double x, double y, double z) { return std::hypot(x - .61, y - .52, z - .58) - .2371; });
    set_velocity(fluid, [](int, double, double, double) { return 100; });
    Field<float>* const components[] = {&fluid.velocity.u, &fluid.velocity.v, &fluid.velocity.w};
    for (int axis = 0; axis < 3; ++axis)
      for_each_place(*components[axis], [&](int x, int y, int z) {
        if (state_of(fluid, axis, x, y, z).known) (*components[axis])(x, y, z) = .1f * (axis + 1);
      });
    version.extrapolate(fluid, 3 * fluid.spacing, fluid.velocity);
    int continued = 0;
    for_each_face(fluid, fluid.velocity, [&](const Field<float>& component, int axis, int x, int y, int z, Kind, Kind) {
      const FaceState state = state_of(fluid, axis, x, y, z);
      const bool beyond = !state.closed && state.distance > double(3 * fluid.spacing);
      EXPECT_EQ(component(x, y, z), beyond ? 0 : .1f * (axis + 1)) << version.name;
      continued += !state.known && !beyond;
    });
    EXPECT_GT(continued, 1000);
  }
}

// The surface through the centres of air cells: the faces between them have not been pushed, and are not known.
TEST(ProductionFluidExtrapolate, DoesNotTrustFacesBetweenAirCellsOnTheSurface) {
  for (const Version& version : versions) {
    Fluid<float> fluid = make_fluid<float>(6, 8, 6, .125, [](double, double y, double) { return y - 3.5 * .125; });
    set_velocity(fluid, [](int, double, double y, double) { return y > .4 ? 9 : 2; });
    version.extrapolate(fluid, 3 * fluid.spacing, fluid.velocity);
    EXPECT_EQ(fluid.velocity.u(3, 3, 3), 2) << version.name;
    EXPECT_EQ(fluid.velocity.w(3, 3, 3), 2) << version.name;
  }
}

TEST(ProductionFluidExtrapolate, ReachesTheOpenTopFromBelow) {
  for (const Version& version : versions) {
    Fluid<float> fluid = make_fluid<float>(6, 8, 6, .125, [](double, double y, double) { return y - .8; });
    fluid.open_top = true;
    set_velocity(fluid, [](int, double, double y, double) { return y > .8 ? 9 : 2; });
    version.extrapolate(fluid, 3 * fluid.spacing, fluid.velocity);
    for (int x = 0; x < 6; ++x) EXPECT_EQ(fluid.velocity.v(x, 8, 3), 2) << version.name;
  }
}

// Near a surface that is in no cell's centre there is nothing to continue.
TEST(ProductionFluidExtrapolate, StopsWhatNothingIsKnownOf) {
  for (const Version& version : versions) {
    Fluid<float> fluid = make_fluid<float>(
        5, 5, 5, .2, [](double x, double y, double z) { return std::hypot(x - .5, y - .5, z - .5) + .02; });
    set_velocity(fluid, [](int axis, double, double, double) { return 3 + axis; });
    // Walls would be known.
    for_each_place(fluid.phi, [&](int x, int y, int z) {
      if (std::min({x, y, z}) == 0 || std::max({x, y, z}) == 4) fluid.phi(x, y, z) = 100;
    });
    version.extrapolate(fluid, 3 * fluid.spacing, fluid.velocity);
    for (int x : {2, 3}) EXPECT_EQ(fluid.velocity.u(x, 2, 2), 0) << version.name;
    for (int y : {2, 3}) EXPECT_EQ(fluid.velocity.v(2, y, 2), 0) << version.name;
  }
}

// Faces in no order at all: each asks its nearer neighbours, which ask theirs.
class Asked {
 public:
  Asked(const Fluid<float>& fluid, const Field<float>& before, int axis, float distance)
      : fluid_(fluid), before_(before), axis_(axis), distance_(distance) {}

  struct Answer {
    bool known;
    float velocity;
  };
  Answer operator()(int x, int y, int z) {
    const std::size_t i = before_.index(x, y, z);
    if (const auto found = answers_.find(i); found != answers_.end()) return found->second;
    return answers_[i] = ask(x, y, z);
  }

 private:
  Answer ask(int x, int y, int z) {
    const FaceState state = state_of(fluid_, axis_, x, y, z);
    if (state.known) return {true, before_(x, y, z)};
    if (state.distance > double(distance_)) return {false, 0};
    const auto neighbour = [&](int x, int y, int z) -> Neighbour<float> {
      const Neighbour<float> none = {levelset::far<float>, 0};
      if (x < 0 || x >= before_.nx || y < 0 || y >= before_.ny || z < 0 || z >= before_.nz) return none;
      const FaceState other = state_of(fluid_, axis_, x, y, z);
      if (other.distance >= state.distance) return none;
      const Answer answer = (*this)(x, y, z);
      return answer.known ? Neighbour<float>{static_cast<float>(other.distance), answer.velocity} : none;
    };
    Continued<float> face;
    const float d = static_cast<float>(state.distance);
    add_axis(d, neighbour(x - 1, y, z), neighbour(x + 1, y, z), face);
    add_axis(d, neighbour(x, y - 1, z), neighbour(x, y + 1, z), face);
    add_axis(d, neighbour(x, y, z - 1), neighbour(x, y, z + 1), face);
    return face.weight > 0 ? Answer{true, face.velocity} : Answer{false, 0};
  }

  const Fluid<float>& fluid_;
  const Field<float>& before_;
  int axis_;
  float distance_;
  std::map<std::size_t, Answer> answers_;
};

void expect_as_asked(const Fluid<float>& fluid, const Faces<float>& found, const std::string& what) {
  const float distance = 3 * fluid.spacing;
  const Field<float>* const before[] = {&fluid.velocity.u, &fluid.velocity.v, &fluid.velocity.w};
  const Field<float>* const after[] = {&found.u, &found.v, &found.w};
  for (int axis = 0; axis < 3; ++axis) {
    Asked asked(fluid, *before[axis], axis, distance);
    int wrong = 0;
    for_each_place(*before[axis],
                   [&](int x, int y, int z) { wrong += asked(x, y, z).velocity != (*after[axis])(x, y, z); });
    EXPECT_EQ(wrong, 0) << what << ", axis " << axis;
  }
}

void expect_same_for_all_threads(const Fluid<float>& fluid, const Faces<float>& expected, const std::string& what) {
  const int threads_before = omp_get_max_threads();
  for (const int threads : {1, 2, 3, 8}) {
    omp_set_num_threads(threads);
    Faces<float> faces = fluid.velocity;
    openmp::extrapolate(fluid, 3 * fluid.spacing, faces);
    EXPECT_TRUE(same_bits(faces, expected)) << what << ", " << threads << " threads";
  }
  omp_set_num_threads(threads_before);
}

TEST(ProductionFluidExtrapolate, NoOrderChangesABit) {
  for (const char* scene : {"obstacle_48", "two_pockets", "open_top", "one_cell", "full_box"}) {
    const Fluid<float> fluid = load_scene(std::string("scenes/production_fluid/") + scene + ".toml").fluid;
    Faces<float> faces = fluid.velocity;
    serial::extrapolate(fluid, 3 * fluid.spacing, faces);
    expect_as_asked(fluid, faces, scene);
    expect_same_for_all_threads(fluid, faces, scene);
  }
}

// Boxes of all sizes full of drops, holes and solid cells, with distances of which many are equal: long chains, faces
// that nothing is known of, faces that wait for six.
TEST(ProductionFluidExtrapolate, NoOrderChangesABitOfNoise) {
  std::mt19937 random(7);
  const auto below = [&](int n) { return static_cast<int>(random() % n); };
  for (int trial = 0; trial < 25; ++trial) {
    const int steps = 1 + below(40), solids = below(3);
    Fluid<float> fluid = make_fluid<float>(1 + below(36), 1 + below(9), 1 + below(9), 1, [&](double, double, double) {
      return (below(5 * steps) - steps) * 1. / steps;
    });
    fluid.open_top = below(2);
    for_each_place(fluid.phi, [&](int x, int y, int z) { fluid.solid(x, y, z) = below(10) < solids ? -1 : 1; });
    set_velocity(fluid, [&](int, double, double, double) { return below(1000) - 500; });
    Faces<float> faces = fluid.velocity;
    serial::extrapolate(fluid, 3 * fluid.spacing, faces);
    expect_as_asked(fluid, faces, "trial " + std::to_string(trial));
    expect_same_for_all_threads(fluid, faces, "trial " + std::to_string(trial));
  }
}

// A surface that slopes a little: a chain of faces as long as the box.
TEST(ProductionFluidExtrapolate, NoOrderChangesABitOfALongChain) {
  for (const double slope : {1e-3, -1e-3}) {
    Fluid<float> fluid = make_fluid<float>(
        70, 10, 60, 1, [&](double x, double y, double z) { return y - 4.3 + slope * x - 2 * slope * z; });
    set_velocity(fluid, [](int axis, double x, double y, double z) { return std::sin(x + 2 * y + 3 * z + axis); });
    Faces<float> faces = fluid.velocity;
    serial::extrapolate(fluid, 3, faces);
    expect_as_asked(fluid, faces, "slope");
    expect_same_for_all_threads(fluid, faces, "slope");
  }
}

// A mean of what is known lies between the least and the greatest of it. Known and closed faces keep their bits, and
// faces beyond get 0.
TEST(ProductionFluidExtrapolate, StaysBetweenWhatIsKnown) {
  for (const Version& version : versions)
    for (const char* scene : {"drop_64", "obstacle_48"}) {
      const Fluid<float> fluid = load_scene(std::string("scenes/production_fluid/") + scene + ".toml").fluid;
      Faces<float> faces = fluid.velocity;
      version.extrapolate(fluid, 3 * fluid.spacing, faces);
      float least[3] = {1e9f, 1e9f, 1e9f}, most[3] = {-1e9f, -1e9f, -1e9f};
      const Field<float>* const before[] = {&fluid.velocity.u, &fluid.velocity.v, &fluid.velocity.w};
      for_each_face(fluid, faces, [&](const Field<float>& component, int axis, int x, int y, int z, Kind, Kind) {
        if (!state_of(fluid, axis, x, y, z).known) return;
        EXPECT_EQ(component(x, y, z), (*before[axis])(x, y, z)) << version.name;
        least[axis] = std::min(least[axis], component(x, y, z)), most[axis] = std::max(most[axis], component(x, y, z));
      });
      for_each_face(fluid, faces, [&](const Field<float>& component, int axis, int x, int y, int z, Kind, Kind) {
        const FaceState state = state_of(fluid, axis, x, y, z);
        if (state.known) return;
        if (state.distance > double(3 * fluid.spacing)) {
          EXPECT_EQ(component(x, y, z), 0) << version.name;
        } else {
          // Seven roundings a step, fewer than a hundred steps.
          const double rounding = 100 * 7 * u * std::max(-least[axis], most[axis]);
          EXPECT_GE(component(x, y, z), least[axis] - rounding) << version.name << ' ' << scene;
          EXPECT_LE(component(x, y, z), most[axis] + rounding) << version.name << ' ' << scene;
        }
      });
    }
}

}  // namespace
}  // namespace lockstep::production_fluid
