// Cloths at rest under their weight, by Newton's method with CHOLMOD: the elastica of a cantilever, a strip that hangs.
#define EIGEN_DONT_VECTORIZE  // lanes of other widths than the rest of the program's

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "tests/production_cloth_newton.h"

namespace lockstep::production_cloth {
namespace {

// --- A cantilever

// A strip of squares along x, clamped across the middle of its first squares, x = 0: the vertices on either side of it
// are held, and the crease behind these bends over half a square at either side. So `length` is a half square less than
// the squares'.
struct Strip {
  int squares, rows;
  double side;
  SmallCloth cloth;

  double length() const { return (squares - .5) * side; }
  double width() const { return rows * side; }
  bool is_tip(int i) const { return cloth.rest.x[i] > length() - .1 * side; }
  ImplicitCloth clamped() const {
    return ImplicitCloth(cloth, [this](const Vector3<double>& at) { return at.x < .6 * side; });
  }
};

// A tenth as wide as long. Sides are powers of two, so that vertices are floats.
Strip strip_of(int squares, const Material& material) {
  const int rows = squares / 10;
  const double side = .3125 / squares;
  return {squares, rows, side,
          cloth_of(make_sheet({.origin = {-.5 * side, 0, 0},
                               .across = {side * squares, 0, 0},
                               .down = {0, 0, side * rows},
                               .squares = {squares, rows}}),
                   material)};
}

// A plate in the plane, without damping; 1 kg/m^2.
Material plate(Bend bend, double membrane) {
  return {.density = 1,
          .stretch = Stretch::stvk,
          .membrane = membrane,
          .poisson = 0,
          .stretch_damping = 0,
          .bend = bend,
          .bending = 1,
          .bend_damping = 0};
}

// The plate constant D of a strip's bend along x where the material's `bending` is 1: from how far a small force P at
// its tip moves it, P L^3 / (3 D width). The membrane plays no part.
double measured_plate_constant(Bend bend, int squares) {
  const Strip strip = strip_of(squares, plate(bend, 1e4));
  ImplicitCloth c = strip.clamped();
  Eigen::VectorXd force = Eigen::VectorXd::Zero(3 * c.vertices);
  for (int i = 0; i < c.vertices; ++i) {
    const double z = strip.cloth.rest.z[i];
    const bool is_corner = z < .1 * strip.side || z > strip.width() - .1 * strip.side;
    if (strip.is_tip(i)) force[3 * i + 1] = (is_corner ? .5 : 1.) / strip.rows;
  }
  const Array<double> none(c.mass.size(), 0.);
  const Eigen::VectorXd moved = solve_directly(c.assemble(strip.cloth.rest, 1, none), force);
  return std::pow(strip.length(), 3) / (3 * force.dot(moved) * strip.width());
}

// m: how far the tip sinks, and how far it reaches, both by the length; the mean over the tip.
struct Tip {
  double drop, reach;
};
double apart(const Tip& a, const Tip& b) { return std::hypot(a.drop - b.drop, a.reach - b.reach); }

// Of a strip whose weight w gives gamma = w L^3 / D.
Tip tip_at_rest(Bend bend, double gamma, int squares) {
  Material material = plate(bend, 0);
  const double length = strip_of(squares, material).length();
  const double weight = gamma * measured_plate_constant(bend, squares) / std::pow(length, 3);
  material.membrane = 1e5 * weight * length;
  const Strip strip = strip_of(squares, material);
  ImplicitCloth c = strip.clamped();
  Eigen::VectorXd load = Eigen::VectorXd::Zero(3 * c.vertices);
  for (int i = 0; i < c.vertices; ++i) load[3 * i + 1] = -weight * c.mass[i];
  Vectors<double> x = strip.cloth.rest;
  const NewtonSolution solution = minimise(c, load, x, 0, 0, 1e-6 * load.norm(), 500, x);
  EXPECT_LE(solution.gradient, 1e-6 * load.norm()) << gamma << ' ' << squares;
  Tip tip = {0, 0};
  for (int i = 0; i < c.vertices; ++i)
    if (strip.is_tip(i))
      tip = {tip.drop - x.y[i] / length / (strip.rows + 1), tip.reach + x.x[i] / length / (strip.rows + 1)};
  return tip;
}

// The boundary value problem D theta'' = -w (L - s) cos theta, solved to 1e-10, rounded to 1e-6.
struct Elastica {
  double gamma;
  Tip tip;
};
constexpr Elastica elastica[] = {{.1, {.012498, .999911}},
                                 {1, {.123471, .991246}},
                                 {10, {.700200, .656354}},
                                 {100, {.937524, .159223}},
                                 {1000, {.981141, .045986}}};

// A smooth bend along the sides of the squares has three times the isotropic D, and Bridson's hinges a quarter of their
// k; shear adds turns of the squares between diagonals that lean alike. All is of the second order of the side: N = L /
// side gives 1 / (4 N^2) to the sum over creases in place of the integral, and the turns as much again, or twice.
TEST(ProductionClothStatics, PlateConstantOfTheMesh) {
  for (const auto& [bend, smooth] : {std::pair(Bend::quadratic, 3.), std::pair(Bend::hinges, .25)}) {
    double off_before = 0;
    for (const int squares : {20, 40, 80}) {
      const double off = std::abs(measured_plate_constant(bend, squares) / smooth - 1);
      EXPECT_LE(off, 1.5 / std::pow(squares - .5, 2)) << squares;
      if (off_before > 0) {
        EXPECT_LE(off, off_before / std::pow(2, 1.5));
      }
      off_before = off;
    }
  }
}

// How far the table's tip moves, by L, as ln gamma grows by 1: at most by .41, between 5 and 10; and by little more
// than the drop, gamma / 8, for small gamma.
double tip_by_constant(double gamma) { return std::min(.41, .13 * gamma); }

// The mesh states its error, of two parts. Creases in place of a curve: errors of the second order, of which 2^1.5 as
// the side is halved is taken for granted, so that what the first two resolutions differ by is at least 1 - 2^-1.5 of
// the first one's. The third is foretold. And the plate constant depends on the load by as much as that of the tip is
// off that of a smooth bend. Besides: the membrane lets the tip down by w L^2 / (2 Y) = 5e-6 L at most, the equilibrium
// is that of a load off by 1e-6, and the table is rounded by 1e-6.
void expect_elastica(Bend bend, double smooth, const Elastica& exact) {
  Tip tips[3];
  for (int k = 0; k < 3; ++k) tips[k] = tip_at_rest(bend, exact.gamma, 20 << k);
  const double by_half = std::pow(2, -1.5);
  double creases = apart(tips[0], tips[1]) / (1 - by_half);
  for (int k = 0; k < 3; ++k, creases *= by_half) {
    const double constant =
        tip_by_constant(exact.gamma) * std::abs(measured_plate_constant(bend, 20 << k) / smooth - 1);
    const double stated = creases + constant + 7e-6;
    EXPECT_LE(apart(tips[k], exact.tip), stated) << exact.gamma << ' ' << (20 << k);
    std::printf("gamma %g, %d squares: off by %.1e L, stated %.1e\n", exact.gamma, 20 << k, apart(tips[k], exact.tip),
                stated);
  }
}

TEST(ProductionClothStatics, QuadraticBendingIsTheElastica) {
  for (const Elastica& exact : elastica) expect_elastica(Bend::quadratic, 3, exact);
}
TEST(ProductionClothStatics, HingesAreTheElastica) {
  for (const int k : {1, 3}) expect_elastica(Bend::hinges, .25, elastica[k]);
}

// --- A strip that hangs

// Without bending, which would resist changes of stretch, and without contraction across, each row of squares carries
// what hangs below its middle: exactly, for every number of rows. A vertex is loaded by a quarter of each square at it;
// thirds of triangles would load the corners unevenly. Co-rotated membranes pull by Y (s - 1), St. Venant and
// Kirchhoff's by Y s (s^2 - 1) / 2, s the stretch.
double stretch_under(Stretch stretch, double tension) {
  if (stretch == Stretch::corotated) return 1 + tension;
  double s = 1 + tension;
  for (int k = 0; k < 50; ++k) s -= (s * (s * s - 1) / 2 - tension) / ((3 * s * s - 1) / 2);
  return s;
}

TEST(ProductionClothStatics, StripHangsByItsWeight) {
  constexpr double side = .0625, strain = .4;  // w L / Y
  for (const Stretch stretch : {Stretch::stvk, Stretch::corotated})
    for (const int rows : {1, 4, 16, 50}) {
      const double length = rows * side;
      const SmallCloth cloth = cloth_of(
          make_sheet({.origin = {0, 0, 0}, .across = {3 * side, 0, 0}, .down = {0, -length, 0}, .squares = {3, rows}}),
          {.density = 1,
           .stretch = stretch,
           .membrane = length / strain,
           .poisson = 0,
           .stretch_damping = 0,
           .bend = Bend::none});
      ImplicitCloth c(cloth, [&](const Vector3<double>& at) { return at.y > -.1 * side; });
      Eigen::VectorXd load = Eigen::VectorXd::Zero(3 * c.vertices);
      for (int i = 0; i < c.vertices; ++i) {
        const double x = cloth.rest.x[i], y = -cloth.rest.y[i];
        const bool is_side = x < .1 * side || x > 2.9 * side, is_end = y < .1 * side || y > length - .1 * side;
        load[3 * i + 1] = -side * side * (is_side ? .5 : 1.) * (is_end ? .5 : 1.);
      }
      Vectors<double> x = cloth.rest;
      const NewtonSolution solution = minimise(c, load, x, 0, 1e-6, 1e-12 * load.norm(), 50, x);
      EXPECT_LE(solution.gradient, 1e-12 * load.norm()) << rows;
      Array<double> depth = {0};
      for (int r = 0; r < rows; ++r)
        depth.push_back(depth.back() + side * stretch_under(stretch, strain * (rows - r - .5) / rows));
      if (stretch == Stretch::corotated) {
        EXPECT_NEAR(depth.back(), length * (1 + strain / 2), 1e-12);
      }
      // A residual of 1e-12 of the load, over a compliance of the length by the load: 1e-12 of the length, for each of
      // the vertices of a row.
      for (int i = 0; i < c.vertices; ++i) {
        const int row = static_cast<int>(std::lround(-cloth.rest.y[i] / side));
        EXPECT_NEAR(x.y[i], -depth[row], 1e-11 * length) << rows;
        EXPECT_NEAR(x.x[i], cloth.rest.x[i], 1e-11 * length);
        EXPECT_NEAR(x.z[i], 0, 1e-11 * length);
      }
    }
}

}  // namespace
}  // namespace lockstep::production_cloth
