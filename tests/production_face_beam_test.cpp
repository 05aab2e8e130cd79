// Bars of flesh between two bones, against the theory of beams and the closed form of a stretched bar.
//
// Tetrahedra in which displacements are linear are too stiff: a bent bar's reaction falls to its limit as the lattice
// becomes finer, in the second order of its spacing at best. Flesh hardly changes its volume, which stiffens
// tetrahedra further (locking), the more the greater kappa is.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <numbers>

#include "tests/production_faces.h"

namespace lockstep::production_face {
namespace {

constexpr double width = 1 / 64., length = 6 * width;  // m

Body<float> bar(int across) {
  const double h = width / across;
  const Mesh mesh = make_lattice({6 * across, across, across}, h);
  return held_where(make_body(mesh, {}, 0), [](const Vector& x) { return x.x == 0 || x.x == length; });
}

struct Moduli {
  double young, shear, poisson;
};

Moduli moduli_of(const Flesh& flesh) {
  const double shear = 2 * (double(flesh.m10) + flesh.m01);
  const double young = 9 * flesh.kappa * shear / (3 * flesh.kappa + shear);
  return {young, shear, young / (2 * shear) - 1};
}

constexpr double area = width * width, moment_of_area = area * area / 12;

bool at_end(const Vector& x) { return x.x > 0; }

// How stiff a lattice is over how stiff the beam is, for 2, 4 and 8 cells across. With a finest lattice of 16
// across, BEAM_ACROSS=16 prints what notes/production_face.md has.
template <class F>
std::vector<double> ratios(const char* what, const Flesh& flesh, double beam, const F& stiffness) {
  const char* const asked = std::getenv("BEAM_ACROSS");
  const int finest = asked ? std::atoi(asked) : 8;
  std::printf("%s, kappa %.0e Pa, over the beam's:", what, flesh.kappa);
  std::vector<double> all;
  for (int across = 2; across <= finest; across *= 2) {
    all.push_back(stiffness(flesh, across) / beam);
    std::printf(" %.4f", all.back());
  }
  std::printf("\n");
  return all;
}

// --- Bending

// Ends are brought to where the exact field of a bent beam has them, anticlastic sides included:
// u = c (-x y, (x^2 + nu (y^2 - z^2)) / 2, nu y z). The moment is E I c.
double moment(const Flesh& flesh, int across) {
  constexpr double curvature = 1e-4 / length;  // linear: the square of the turn is 1e-8
  const double nu = moduli_of(flesh).poisson;
  const auto from_axis = [](const Vector& x) { return x - Vector{0, .5 * width, .5 * width}; };
  Posed<double> p = posed<double>(bar(across), flesh);
  bring_bones(
      [&](const Vector& at) {
        const Vector x = from_axis(at);
        return at + curvature * Vector{-x.x * x.y, .5 * (x.x * x.x + nu * (x.y * x.y - x.z * x.z)), nu * x.y * x.z};
      },
      p);
  EXPECT_LE(step(p, 1e-6).steps, 4);
  const std::vector<Vector> force = forces_on_nodes(p);
  double sum = 0;
  for (const int n : p.face.body.held)
    if (at_end(rest_of(p, n))) sum -= cross(from_axis(rest_of(p, n)) - Vector{length, 0, 0}, force[n]).z;
  return sum / curvature;
}

// Second order at least: the energy's error is that of strains, squared, and locking fades besides. Each kappa locks
// more than the one before.
TEST(ProductionFaceBeam, MomentFallsToThatOfABentBeam) {
  std::vector<double> before(8, 1);
  for (const float kappa : {3e5f, 3e6f, 3e7f}) {
    const Flesh flesh = {.kappa = kappa};
    const std::vector<double> ratio = ratios("moment", flesh, moduli_of(flesh).young * moment_of_area, moment);
    for (std::size_t k = 0; k < ratio.size(); ++k) EXPECT_GT(ratio[k], std::max(1., before[k]));
    for (std::size_t k = 1; k < ratio.size(); ++k) {
      const double order = std::log2((ratio[k - 1] - 1) / (ratio[k] - 1));
      EXPECT_GE(order, 2) << kappa;
    }
    before = ratio;
  }
}

// --- Shear between clamped ends

// N/m: 12 E I / L^3 / (1 + phi), phi = 12 E I / (G A k L^2), with Cowper's k of a rectangle.
double beam_stiffness(const Flesh& flesh) {
  const Moduli m = moduli_of(flesh);
  const double k = 10 * (1 + m.poisson) / (12 + 11 * m.poisson);
  const double bending = 12 * m.young * moment_of_area / (length * length);
  return bending / length / (1 + bending / (m.shear * area * k));
}

double lattice_stiffness(const Flesh& flesh, int across) {
  constexpr double shift = 1e-4 * length;
  Posed<double> p = posed<double>(bar(across), flesh);
  bring_bones([](const Vector& x) { return x.x == 0 ? x : x + Vector{0, shift, 0}; }, p);
  EXPECT_LE(step(p, 1e-6).steps, 4);
  return reaction(p, at_end).y / shift;
}

// The power of the distance with which displacements vary at an edge where a clamped side meets a free one at a right
// angle: sin^2(p pi / 2) = (4 (1 - nu)^2 - p^2) / (3 - 4 nu) (Williams, J. Appl. Mech. 19, 1952).
double power_at_clamped_edge(double nu) {
  return zero_of(
      [&](double p) {
        return std::pow(std::sin(.5 * std::numbers::pi * p), 2) - (4 * (1 - nu) * (1 - nu) - p * p) / (3 - 4 * nu);
      },
      .5, 1);
}

// Strains are not bounded at the edges of clamped ends, so that the energy converges with twice that power in the end,
// and with no more than the second order; coarse lattices, in which locking fades, are between.
//
// Beams narrow and widen where they bend; clamped ends may not, and are stiffer by a share that grows with Poisson's
// number. What ends do to their surroundings dies away as exp(-4.2 x / width) (Fadle and Papkovich), so they are no
// stiffer than if width / 4.2 of the beam were rigid at either end. The limit is taken by that power.
TEST(ProductionFaceBeam, ReactionFallsToThatOfAClampedBeam) {
  std::vector<double> before(8, 1);
  for (const float kappa : {3e5f, 3e6f, 3e7f}) {
    const Flesh flesh = {.kappa = kappa};
    const std::vector<double> ratio = ratios("reaction", flesh, beam_stiffness(flesh), lattice_stiffness);
    for (std::size_t k = 0; k < ratio.size(); ++k) EXPECT_GT(ratio[k], before[k]);
    for (std::size_t k = 2; k < ratio.size(); ++k) {
      const double order = std::log2((ratio[k - 2] - ratio[k - 1]) / (ratio[k - 1] - ratio[k]));
      EXPECT_GE(order, 2 * power_at_clamped_edge(moduli_of(flesh).poisson)) << kappa;
    }
    // Between what the two orders say.
    const double fall = ratio[ratio.size() - 2] - ratio.back(),
                 slowly = std::pow(2, 2 * power_at_clamped_edge(moduli_of(flesh).poisson));
    EXPECT_GT(ratio.back() - fall / (slowly - 1), 1);
    EXPECT_LT(ratio.back() - fall / 3, std::pow(1 - 2 * width / (4.2 * length), -3));
    before = ratio;
  }
}

// --- Stretch

// What the ends do to their surroundings dies away with distance (Saint-Venant), as exp(-4.2 x / width) or faster. So
// the middle, 2.75 widths and more from either end, is strained as a bar with free sides to 2 exp(-11.5) = 2e-5, all
// alike, and its stress times the area is the reaction.
TEST(ProductionFaceBeam, AStretchedBarsMiddleIsUniaxial) {
  for (const double stretch : {1.3, 1.6}) {
    Posed<double> p = posed<double>(bar(4));
    bring_bones([&](const Vector& x) { return Vector{stretch * x.x, x.y, x.z}; }, p);
    step(p, 1e-8);
    std::vector<Vector> middle;
    for (int t = 0; t < p.face.body.tetrahedra; ++t) {
      double x = 0;
      for (int a = 0; a < 4; ++a) x += .25 * rest_of(p, p.face.body.corner.at(t, a)).x;
      if (std::abs(x - .5 * length) < .25 * width) middle.push_back(svd(strain_of(p, t)).s);
    }
    const double along = middle.front().x, across = across_of(along);
    for (const Vector& s : middle) {
      EXPECT_NEAR(s.x, along, 2e-5);
      EXPECT_NEAR(s.y, across, 2e-5);
      EXPECT_NEAR(s.z, across, 2e-5);
    }
    const double reaction_of_area = reaction(p, at_end).x / area;
    EXPECT_NEAR(reaction_of_area, axial_stress(along, across).x, 2e-5 * moduli_of(p.face.flesh).young);
    std::printf("stretched by %.1f: the middle by %.6f, %.0f Pa; closed form %.0f Pa\n", stretch, along,
                reaction_of_area, axial_stress(along, across).x);
  }
}

}  // namespace
}  // namespace lockstep::production_face
