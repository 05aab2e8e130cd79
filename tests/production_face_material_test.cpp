// The material of flesh and muscle against its energy, by differences, and against closed forms of rubber elasticity.
#include "common/production_face/flesh_material.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "common/production_face/muscle.h"
#include "common/simd.h"
#include "tests/production_face_matrices.h"

namespace lockstep::production_face {
namespace {

constexpr Flesh flesh;

Svd<double> svd_of(const Matrix& f) { return svd(f); }

double energy(const Matrix& f) { return flesh_slopes(flesh, svd_of(f).s).energy; }

Matrix stress(const Matrix& f) {
  const Svd<double> d = svd_of(f);
  const Vector3<double> p = principal_stress(flesh_slopes(flesh, d.s), d.s);
  return product({p.x * d.u.x, p.y * d.u.y, p.z * d.u.z}, transposed(d.v));
}

Matrix derivative(const Matrix& f, const Matrix& df) {
  const Svd<double> d = svd_of(f);
  const StressDerivative<double> a = stress_derivative(flesh_slopes(flesh, d.s), d.s);
  return applied(a, d.u, d.v, df);
}

// Rotations with noise, matrices of any kind, half of them inside out, and flat ones.
std::vector<Matrix> deformations() {
  std::mt19937 generator(1);
  std::vector<Matrix> all;
  for (int i = 0; i < 200; ++i) {
    const Matrix noise = random_matrix(generator), turn = svd_of(random_matrix(generator)).u;
    all.push_back(product(turn, identity + .15 * noise));
    all.push_back(noise);
    all.push_back({noise.x, noise.y, 1e-9 * noise.z});
  }
  return all;
}

// --- Flesh

// A central difference is off by the third derivative times step^2 / 6. One of twice the step is off by four times as
// much, so a third of what the two differ by is the error, to the next order; twice that is allowed for the next order,
// and for a third derivative that jumps where crushing begins.
//
// Rounding, by step: of the energy 16 u of its terms, u = 2^-53, which are no more than it and twice what is taken from
// it; and F is off by 1.8e-14 of its greatest singular value (svd.h). Last, the 2/3 of J^(-2/3) is a float in double,
// too, so that the slope of j is off by 2^-24 of it.
//
// Besides, both agree to 1e-6.
TEST(ProductionFaceMaterial, StressIsTheSlopeOfTheEnergy) {
  std::mt19937 generator(2);
  constexpr double step = 1e-5;
  for (const Matrix& f : deformations()) {
    const Matrix df = random_matrix(generator), p = stress(f);
    const auto slope = [&](double h) { return (energy(f + h * df) - energy(f + (-h) * df)) / (2 * h); };
    const double terms = energy(f) + 6 * (double(flesh.m10) + flesh.m01);
    const double rounding = 16 * 0x1p-53 * terms + 3 * 1.8e-14 * norm(f) * norm(p);
    const double two_thirds =
        0x1p-24 * 4 / 3 * terms * norm(cofactors(f)) / std::max<double>(std::abs(determinant(f)), crushed) * norm(df);
    const double bound = 2. / 3 * std::abs(slope(2 * step) - slope(step)) + 4 * rounding / step + two_thirds;
    EXPECT_NEAR(inner(p, df), slope(step), bound);
    EXPECT_NEAR(inner(p, df), slope(step), 1e-6 * (norm(p) + 1e-2 * norm(derivative(f, df)) + 1e3) * norm(df));
  }
}

TEST(ProductionFaceMaterial, DerivativeIsTheSlopeOfTheStress) {
  std::mt19937 generator(3);
  constexpr double step = 1e-6;
  for (const Matrix& f : deformations()) {
    const Matrix df = random_matrix(generator), found = derivative(f, df);
    const auto slope = [&](double h) { return (.5 / h) * (stress(f + h * df) + (-1.) * stress(f + (-h) * df)); };
    const Matrix by_differences = slope(step);
    // As above; the stress is off by what F is times its slope, and by 16 u of terms that are no more than kappa's.
    const double of_strain = norm(derivative(f, (1 / norm(f)) * f)) + norm(found) / norm(df) + flesh.kappa;
    const double rounding = 3 * 1.8e-14 * norm(f) * of_strain + 16 * 0x1p-53 * norm(stress(f));
    const double bound = 2. / 3 * norm(slope(2 * step) + (-1.) * by_differences) + 4 * rounding / step;
    EXPECT_LE(norm(found + (-1.) * by_differences), bound);
    EXPECT_LE(norm(found + (-1.) * by_differences), 1e-6 * (norm(found) + 1e6));
  }
}

TEST(ProductionFaceMaterial, NothingJumpsWhereCrushingBegins) {
  const auto at = [](double volume) {
    const double s = std::cbrt(volume);
    return flesh_slopes(flesh, Vector3<double>{1.5 * s, s, s / 1.5});
  };
  const auto above = at(crushed * (1 + 1e-9)), below = at(crushed * (1 - 1e-9));
  EXPECT_NEAR(above.energy, below.energy, 1e-7 * above.energy);
  EXPECT_NEAR(above.by_j, below.by_j, -1e-7 * above.by_j);
  EXPECT_NEAR(above.by_j_j, below.by_j_j, 1e-7 * above.by_j_j);
  EXPECT_NEAR(above.by_i_j, below.by_i_j, -1e-7 * above.by_i_j);
}

TEST(ProductionFaceMaterial, EnergyGrowsInsideOut) {
  double before = 0;
  for (double z = 1; z > -3; z -= .125) {
    const double now = flesh_slopes(flesh, Vector3<double>{1, 1, z}).energy;
    EXPECT_GE(now, before);
    before = now;
  }
}

// --- Closed forms

// The stretch across that leaves the sides without stress.
template <class F>
double side_without_stress(const F& stress_of_side) {
  double low = .2, high = 3;
  for (int i = 0; i < 200; ++i) {
    const double middle = .5 * (low + high);
    (stress_of_side(middle) < 0 ? low : high) = middle;
  }
  return .5 * (low + high);
}

double uniaxial(const Flesh& material, double l) {
  const auto stress = [&](double side) {
    const Vector3<double> s = {l, side, side};
    return principal_stress(flesh_slopes(material, s), s);
  };
  return stress(side_without_stress([&](double side) { return stress(side).y; })).x;
}

double equibiaxial(const Flesh& material, double l) {
  const auto stress = [&](double side) {
    const Vector3<double> s = {l, l, side};
    return principal_stress(flesh_slopes(material, s), s);
  };
  return stress(side_without_stress([&](double side) { return stress(side).z; })).x;
}

TEST(ProductionFaceMaterial, UniaxialAndEquibiaxialStretch) {
  EXPECT_NEAR(uniaxial(flesh, .7), -233371, 1);
  EXPECT_NEAR(uniaxial(flesh, 1.3), 104483, 1);
  EXPECT_NEAR(uniaxial(flesh, 1.6), 170443, 1);
  EXPECT_NEAR(equibiaxial(flesh, 1.3), 179248, 1);
}

// The gap to rubber that keeps its volume falls as 1 / kappa.
TEST(ProductionFaceMaterial, StiffVolumeLeadsToIncompressibleRubber) {
  const double m10 = flesh.m10, m01 = flesh.m01;
  const auto gaps = [&](float kappa) {
    const Flesh stiff = {flesh.m10, flesh.m01, kappa};
    const double l = 1.3;
    return std::pair{2 * (l - 1 / (l * l)) * (m10 + m01 / l) - uniaxial(stiff, l),
                     2 * (l - std::pow(l, -5)) * (m10 + m01 * l * l) - equibiaxial(stiff, l)};
  };
  const auto soft = gaps(3e8f), stiff = gaps(3e9f);
  EXPECT_NEAR(soft.first / stiff.first, 10, .01);
  EXPECT_NEAR(soft.second / stiff.second, 10, .01);
}

TEST(ProductionFaceMaterial, SimpleShearAndPressure) {
  for (const double shear : {.1, .5, 1.5}) {
    const Matrix f = {{1, 0, 0}, {shear, 1, 0}, {0, 0, 1}};
    EXPECT_NEAR(stress(f).y.x, 2 * (double(flesh.m10) + flesh.m01) * shear, 1e-6 * flesh.m10);
  }
  // P = p J F^-T of a pressure p = kappa ln J / J.
  for (const double volume : {.3, .9, 1.2}) {
    const double s = std::cbrt(volume);
    const auto p = principal_stress(flesh_slopes(flesh, Vector3<double>{s, s, s}), Vector3<double>{s, s, s});
    EXPECT_NEAR(p.x, flesh.kappa * std::log(volume) / volume * s * s, 1e-6 * flesh.kappa);
  }
}

TEST(ProductionFaceMaterial, RestHasNoStress) {
  const Vector3<float> one = {1, 1, 1};
  const Vector3<float> p = principal_stress(flesh_slopes(flesh, one), one);
  EXPECT_EQ(p.x, 0);
  EXPECT_EQ(p.y, 0);
  EXPECT_EQ(p.z, 0);
}

// --- Muscle

TEST(ProductionFaceMaterial, TensionIsTheSlopeOfItsEnergy) {
  constexpr double step = 1e-6, pull = 2e5, passive = 3e5;
  const auto at = [&](double l) { return tension<double>(l, pull, passive, false); };
  const auto of = [&](double l) { return l * at(l).per_stretch; };
  for (double l = .26; l < 2; l += .0173) {
    const double slope = (of(l + step) - of(l - step)) / (2 * step);
    EXPECT_NEAR(of(l), (at(l + step).energy - at(l - step).energy) / (2 * step), 1e-6 * passive) << l;
    EXPECT_NEAR(at(l).along * l * l + at(l).per_stretch, slope, 1e-5 * passive) << l;
  }
}

TEST(ProductionFaceMaterial, CurvesHaveNoStepsAndNoKinks) {
  for (const double l : {.4, .6, 1., 1.4, 1.6}) {
    const double before = l - 1e-9, after = l + 1e-9;
    for (const auto curve : {active_curve<double>, passive_curve<double>}) {
      EXPECT_NEAR(curve(before).value, curve(after).value, 1e-6);
      EXPECT_NEAR(curve(before).slope, curve(after).slope, 1e-6);
      EXPECT_NEAR(curve(before).integral, curve(after).integral, 1e-6);
    }
  }
  EXPECT_NEAR(active_curve(1.).value, 1, 1e-12);
  EXPECT_EQ(active_curve(.39).value, 0);
  EXPECT_EQ(passive_curve(.99).value, 0);
  EXPECT_NEAR(passive_curve(1.5).value, 4.2943 * 1.5 - 5.4933, 1e-4);
}

TEST(ProductionFaceMaterial, AFibreWithoutLengthDoesNotPull) {
  for (const float l : {0.f, 1e-30f, .2f}) {
    const Tension<float> t = tension<float>(l, 3e5f, 3e5f, true);
    EXPECT_EQ(t.per_stretch, 0);
    EXPECT_EQ(t.along, 0);
  }
}

// --- Lanes

TEST(ProductionFaceMaterial, LanesHaveTheBitsOfNumbers) {
  std::mt19937 generator(4);
  std::uniform_real_distribution<float> uniform(-1.5f, 2);
  for (int i = 0; i < 500; ++i) {
    float x[lanes], y[lanes], z[lanes], energy[lanes], xy[lanes], beta[lanes], along[lanes];
    for (int l = 0; l < lanes; ++l) x[l] = uniform(generator), y[l] = uniform(generator), z[l] = uniform(generator);
    const Vector3<floatv> s = {load(x), load(y), load(z)};
    const FleshSlopes<floatv> d = flesh_slopes(flesh, s);
    const StressDerivative<floatv> a = stress_derivative(d, s);
    const Tension<floatv> t = tension(abs(s.x), floatv(2e5f), floatv(3e5f), first_lanes(lanes));
    store(energy, d.energy), store(xy, a.xy), store(beta, a.beta.z), store(along, t.along);
    for (int l = 0; l < lanes; ++l) {
      const Vector3<float> number = {x[l], y[l], z[l]};
      const FleshSlopes<float> of_number = flesh_slopes(flesh, number);
      const StressDerivative<float> derivative = stress_derivative(of_number, number);
      EXPECT_EQ(energy[l], of_number.energy);
      EXPECT_EQ(xy[l], derivative.xy);
      EXPECT_EQ(beta[l], derivative.beta.z);
      EXPECT_EQ(along[l], tension(std::abs(x[l]), 2e5f, 3e5f, true).along);
    }
  }
}

}  // namespace
}  // namespace lockstep::production_face
