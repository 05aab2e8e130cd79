// Gravity and projection against facts: no divergence is left, a pool at rest stays so, and a pressure that is known.
#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "common/production_fluid/apply_forces.h"
#include "common/production_fluid/pressure_solve.h"
#include "common/production_fluid/project.h"
#include "common/production_fluid/scene.h"
#include "common/simd_double.h"
#include "tests/production_fluids.h"
#include "verify/arrays.h"

namespace lockstep::production_fluid {
namespace {

template <class Real>
struct Version {
  MakeSystem<Real>* make_system;
  PressureSolve<Real>* solve;
  ApplyForces<Real>* apply_forces;
  Project<Real>* project;
};
template <class Real>
constexpr Version<Real> serial_version = {serial::make_system, serial::pressure_solve_mic, serial::apply_forces,
                                          serial::project};
constexpr Version<float> openmp_version = {openmp::make_system, openmp::pressure_solve_mic, openmp::apply_forces,
                                           openmp::project};

template <class Real>
struct Solved {
  System<Real> system;
  Array<double> q;
  double residual = 0, right = 0;  // norms
};
template <class Real>
Solved<Real> solve(const Version<Real>& version, const Fluid<Real>& fluid, double tolerance) {
  Solved<Real> solved;
  version.make_system(fluid, solved.system);
  const linear::Solution solution = version.solve(
      solved.system, {.modification = {.tau = .97, .sigma = .25}, .stop = {.tolerance = tolerance, .iterations = 1000}},
      scratch_for(solved.system), solved.q);
  for (const Real b : solved.system.right) solved.right += double(b) * b;
  solved.right = std::sqrt(solved.right);
  solved.residual = solution.true_residual * solved.right;
  return solved;
}

// A cell's row says: velocities in, minus A q, are what flows in after the push. So what is left is an element of the
// residual, at most its norm, and roundings, u each: of six faces, of their sums in `right` (five) and in the diagonal
// (six terms, and the inverse of theta), of `right` less the mean of a pocket, which is itself a rounding.
template <class Real>
void expect_no_divergence(const Version<Real>& version, const char* scene, double tolerance) {
  Fluid<Real> fluid = convert<Real>(load_scene(std::string("scenes/production_fluid/") + scene + ".toml").fluid);
  const Solved<Real> solved = solve(version, fluid, tolerance);
  EXPECT_LE(solved.residual, tolerance * solved.right) << scene;
  Faces<Real> faces = fluid.velocity;
  version.project(fluid, solved.system, solved.q, faces);
  const double u = std::numeric_limits<Real>::epsilon() / 2;
  // A mean is the sum, in double, over cells of what rounding left in each: as large as the largest of them.
  double largest = 0;
  for_each_array(fluid.velocity, [&](const char*, const Array<Real>& array, std::size_t) {
    for (const Real value : array) largest = std::max(largest, std::abs(double(value)));
  });
  double worst = 0;
  for_each_place(fluid.phi, [&](int x, int y, int z) {
    if (cell_at(fluid, x, y, z) != Kind::liquid) return;
    const std::size_t i = solved.system.cells.index(x, y, z);
    if (solved.system.diagonal[i] == 0) return;  // no face is open
    const auto sum = [&](const Faces<Real>& f, auto value) {
      return value(f.u(x, y, z), 1) + value(f.u(x + 1, y, z), -1) + value(f.v(x, y, z), 1) +
             value(f.v(x, y + 1, z), -1) + value(f.w(x, y, z), 1) + value(f.w(x, y, z + 1), -1);
    };
    const auto in = [](Real value, int sign) { return sign * double(value); };
    const auto size = [](Real value, int) { return std::abs(double(value)); };
    const double divergence = std::abs(sum(faces, in));
    const double bound = solved.residual + u * (sum(faces, size) + 5 * sum(fluid.velocity, size) + 2 * 6 * largest +
                                                8 * double(solved.system.diagonal[i]) * std::abs(solved.q[i]));
    if (divergence > bound) ADD_FAILURE() << scene << ": " << x << ' ' << y << ' ' << z << ": " << divergence;
    worst = std::max(worst, divergence);
  });
  std::printf("%-12s %s: divergence in %.2e (norm), left %.2e (largest), residual %.2e (norm)\n", scene,
              sizeof(Real) == 4 ? "float " : "double", solved.right, worst, solved.residual);
  for_each_face(fluid, faces, [&](const Field<Real>& component, int axis, int x, int y, int z, Kind a, Kind b) {
    const Field<Real>& before = axis == 0 ? fluid.velocity.u : axis == 1 ? fluid.velocity.v : fluid.velocity.w;
    const bool closed = a == Kind::closed || b == Kind::closed;
    if (!closed && (a != Kind::air || b != Kind::air)) return;
    if (component(x, y, z) != (closed ? 0 : before(x, y, z)))
      ADD_FAILURE() << scene << ": " << axis << " at " << x << ' ' << y << ' ' << z;
  });
}

TEST(ProductionFluidProject, LeavesNoDivergence) {
  for (const char* scene : {"drop_64", "obstacle_48", "two_pockets", "open_top", "one_cell", "full_box"}) {
    expect_no_divergence(serial_version<double>, scene, 1e-10);
    expect_no_divergence(serial_version<float>, scene, 1e-6);
    expect_no_divergence(openmp_version, scene, 1e-6);
  }
}

// p = rho g (H - y) solves the system exactly, wherever the surface is between two centres: the line that theta is
// taken from is the pressure's own. Where theta is clamped, p is another, with which the velocity is 0 all the same, as
// long as matrix and push clamp alike.
//
// Let e be the error of q, so that A e = r, the residual. A face gets c times the difference of e, and the sum of c
// (difference)^2 over the faces is e.r <= |r|^2 / lambda, where the least eigenvalue lambda is at least that of a
// column of ny cells below its surface, (pi / (2 ny))^2 / 2 or more. So a face gets at most sqrt(2 c) |r| 2 ny / pi.
// Besides come the roundings of b and the diagonal, each at most 8 u of what gravity gave, in each of ny cells.
template <class Real>
void expect_rest(const Version<Real>& version, double height, double tolerance) {
  constexpr int nx = 17, ny = 12, nz = 9;
  constexpr double h = .125, g = 10, dt = .01;
  Fluid<Real> fluid = make_fluid<Real>(nx, ny, nz, h, [&](double, double y, double) { return y - height; });
  version.apply_forces({0, -g, 0}, static_cast<Real>(dt), fluid.velocity);
  const Solved<Real> solved = solve(version, fluid, tolerance);
  version.project(fluid, solved.system, solved.q, fluid.velocity);
  const double u = std::numeric_limits<Real>::epsilon() / 2, pi = std::acos(-1.);
  const double theta = height / h - .5 - std::floor(height / h - .5);
  double worst = 0;
  for_each_face(
      fluid, fluid.velocity, [&](const Field<Real>& component, int axis, int x, int y, int z, Kind a, Kind b) {
        if (a == Kind::air && b == Kind::air) return;
        const bool surface = (a == Kind::air) != (b == Kind::air);
        const double c = surface ? 1 / std::max(theta, least_theta) : 1;
        EXPECT_LE(std::abs(component(x, y, z)), std::sqrt(2 * c) * solved.residual * 2 * ny / pi + 8 * ny * u * g * dt)
            << "H " << height / h << " cells: " << axis << " at " << x << ' ' << y << ' ' << z;
        worst = std::max(worst, std::abs(double(component(x, y, z))));
      });
  std::printf("H = %.9f cells, %s: largest velocity %.2e of %.2e\n", height / h,
              sizeof(Real) == 4 ? "float " : "double", worst, g * dt);
}

TEST(ProductionFluidProject, APoolAtRestStaysAtRest) {
  constexpr double h = .125;
  for (const double cells : {5., 5.3, 5.5, 5.5 + 1e-9, 5.5 - 1e-9, 5.5 + 2e-3, 5.5 - 2e-3, 5.75, 6., 6.49}) {
    expect_rest(serial_version<double>, cells * h, 1e-12);
    expect_rest(serial_version<float>, cells * h, 1e-7);
    expect_rest(openmp_version, cells * h, 1e-7);
  }
}

// p = (R^2 - r^2) (1 + sin(3 x) / 2) is 0 on a sphere. Errors of p, largest and mean.
std::pair<double, double> errors_of_sphere(int n) {
  constexpr double R = .31, cx = .503, cy = .497, cz = .511;
  const double h = 1. / n;
  const auto r2 = [&](double x, double y, double z) {
    return (x - cx) * (x - cx) + (y - cy) * (y - cy) + (z - cz) * (z - cz);
  };
  const Fluid<double> fluid =
      make_fluid<double>(n, n, n, h, [&](double x, double y, double z) { return std::sqrt(r2(x, y, z)) - R; });
  System<double> system;
  serial::make_system(fluid, system);
  const auto for_each_cell = [&](const auto& f) {
    for_each_place(fluid.phi, [&](int x, int y, int z) {
      const std::size_t i = system.cells.index(x, y, z);
      if (system.diagonal[i] > 0) f(i, (x + .5) * h, (y + .5) * h, (z + .5) * h);
    });
  };
  // The system is that of -h^2 times the Laplacian.
  for_each_cell([&](std::size_t i, double x, double y, double z) {
    const double s = 1 + std::sin(3 * x) / 2, s1 = 1.5 * std::cos(3 * x), s2 = -4.5 * std::sin(3 * x);
    const double laplacian = -6 * s + 2 * -2 * (x - cx) * s1 + (R * R - r2(x, y, z)) * s2;
    system.right[i] = -h * h * laplacian;
  });
  Array<double> q;
  serial::pressure_solve_mic(
      system, {.modification = {.tau = .97, .sigma = .25}, .stop = {.tolerance = 1e-10, .iterations = 1000}},
      scratch_for(system), q);
  double most = 0, sum = 0, cells = 0;
  for_each_cell([&](std::size_t i, double x, double y, double z) {
    const double error = std::abs(q[i] - (R * R - r2(x, y, z)) * (1 + std::sin(3 * x) / 2));
    most = std::max(most, error), sum += error, ++cells;
  });
  return {most, sum / cells};
}

TEST(ProductionFluidProject, PressureIsOfSecondOrderOnASphere) {
  const auto [most_32, mean_32] = errors_of_sphere(32);
  const auto [most_64, mean_64] = errors_of_sphere(64);
  const auto [most_96, mean_96] = errors_of_sphere(96);
  std::printf("largest %.3e %.3e %.3e, mean %.3e %.3e %.3e\n", most_32, most_64, most_96, mean_32, mean_64, mean_96);
  const auto order = [](double coarse, double fine, double ratio) { return std::log(coarse / fine) / std::log(ratio); };
  EXPECT_GE(order(mean_32, mean_96, 3), 1.9);
  EXPECT_GE(order(most_32, most_96, 3), 1.7);
  EXPECT_GE(order(mean_32, mean_64, 2), 1.8);
  EXPECT_GE(order(most_32, most_64, 2), 1.6);
}

TEST(ProductionFluidForces, AddTheSameToEachFaceAndNothingToThePadding) {
  for (const int nx : {1, 14, 15, 16, 17, 33})
    for (ApplyForces<float>* apply_forces : {serial::apply_forces, openmp::apply_forces}) {
      Faces<float> faces = make_faces<float>(nx, 3, 2, 1);
      apply_forces({1, 0, -4}, .5f, faces);
      const auto expect = [&](const Field<float>& component, float value) {
        double sum = 0;
        for (const float v : component.value) sum += v;
        for_each_place(component, [&](int x, int y, int z) { EXPECT_EQ(component(x, y, z), value) << nx; });
        EXPECT_EQ(sum, double(value) * component.nx * component.ny * component.nz) << "padding, " << nx;
      };
      expect(faces.u, .5f), expect(faces.v, 0), expect(faces.w, -2);
    }
}

// No bit of a component without gravity changes, not even the sign of zero.
TEST(ProductionFluidForces, KeepAComponentWithoutGravity) {
  for (ApplyForces<float>* apply_forces : {serial::apply_forces, openmp::apply_forces}) {
    Faces<float> faces = make_faces<float>(5, 5, 5, 1);
    faces.u.value.assign(faces.u.value.size(), -0.f);
    apply_forces({0, -9.81f, 0}, .1f, faces);
    for_each_place(faces.u, [&](int x, int y, int z) { EXPECT_TRUE(std::signbit(faces.u(x, y, z))); });
  }
}

TEST(ProductionFluidProject, LanesOfDoubleLoadAndRound) {
  double wide[lanes];
  for (int l = 0; l < lanes; ++l) wide[l] = (l % 2 ? -1 : 1) * (1 + l / 3. * 1e-7);
  float rounded[lanes];
  store(rounded, to_float(load(wide)));
  for (int l = 0; l < lanes; ++l) EXPECT_EQ(rounded[l], static_cast<float>(wide[l])) << l;
}

}  // namespace
}  // namespace lockstep::production_fluid
