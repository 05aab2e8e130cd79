// Elastic forces of a cloth: the slope of energies, balance, known stretches, none at rest and in rigid motions; and
// the serial bits.
#include "common/production_cloth/forces.h"

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cstring>
#include <limits>

#include "tests/production_cloths.h"

namespace lockstep::production_cloth {
namespace {

using Vector = Vector3<double>;
double size_of(const Vector& v) { return std::sqrt(dot(v, v)); }

template <class Real>
Vectors<Real> forces_of(const SmallCloth& cloth, const Vectors<Real>& position) {
  const Elements<Real> elements = make_elements<Real>(cloth.topology, cloth.rest, cloth.material);
  State<Real> state = serial::make_state(elements);
  Vectors<Real> force;
  force.resize(cloth.topology.vertices);
  for (Array<Real>* c : {&force.x, &force.y, &force.z}) std::ranges::fill(*c, std::numeric_limits<Real>::quiet_NaN());
  serial::forces(elements, position, state, force);
  return force;
}

double largest(const Vectors<double>& force, int vertices) {
  double most = 0;
  for (int i = 0; i < vertices; ++i) most = std::max(most, size_of(load(force, i)));
  return most;
}

// --- Energies, from the mesh alone

double spring_energy(const SmallCloth& c, const Vectors<double>& x) {
  double sum = 0;
  for (const auto& [a, b] : c.topology.edges) {
    const double rest = size_of(load(c.rest, b) - load(c.rest, a)), length = size_of(load(x, b) - load(x, a));
    sum += .5 * c.material.stiffness / rest * (length - rest) * (length - rest);
  }
  return sum;
}

// Of a triangle's C = F^T F in a frame of its own: by the metrics of its sides, C = A^-T G A^-1, G = (sides . sides)
// now, A^T A = G at rest.
double membrane_energy(const SmallCloth& c, const Vectors<double>& x) {
  const double nu = c.material.poisson, lambda = c.material.membrane * nu / (1 - nu * nu),
               mu = c.material.membrane / (2 * (1 + nu));
  double sum = 0;
  for (std::size_t t = 0; t < c.topology.triangles.size(); ++t) {
    const auto corner = c.topology.corners(t);
    const auto metric = [&](const Vectors<double>& at, double(&g)[3]) {
      const Vector a = load(at, corner[1]) - load(at, corner[0]), b = load(at, corner[2]) - load(at, corner[0]);
      g[0] = dot(a, a), g[1] = dot(a, b), g[2] = dot(b, b);
    };
    double rest[3], now[3];
    metric(c.rest, rest), metric(x, now);
    // Cholesky: A is upper triangular.
    const double p = std::sqrt(rest[0]), q = rest[1] / p, r = std::sqrt(rest[2] - q * q);
    const double xx = now[0] / (p * p), xy = (now[1] / p - q * xx) / r,
                 yy = (now[2] - 2 * q * now[1] / p + q * q * xx) / (r * r);
    double density;
    if (c.material.stretch == Stretch::stvk) {
      const double exx = (xx - 1) / 2, eyy = (yy - 1) / 2, exy = xy / 2;
      density = .5 * lambda * (exx + eyy) * (exx + eyy) + mu * (exx * exx + eyy * eyy + 2 * exy * exy);
    } else {
      const double trace = std::sqrt(xx + yy + 2 * std::sqrt(xx * yy - xy * xy));
      density = mu * (xx + yy - 2 * trace + 2) + .5 * lambda * (trace - 2) * (trace - 2);
    }
    sum += .5 * p * r * density;
  }
  return sum;
}

double quadratic_energy(const SmallCloth& c, const Vectors<double>& x) {
  double sum = 0;
  for (const auto& h : c.topology.hinges) {
    const auto at = [&](int k) { return load(c.rest, h[k]); };
    const auto cot = [&](int o, int a, int b) {
      const Vector u = at(a) - at(o), v = at(b) - at(o);
      return dot(u, v) / size_of(cross(u, v));
    };
    const double areas =
        .5 * (size_of(cross(at(2) - at(0), at(3) - at(0))) + size_of(cross(at(2) - at(1), at(3) - at(1))));
    const double c03 = cot(3, 2, 0), c04 = cot(3, 2, 1), c01 = cot(2, 3, 0), c02 = cot(2, 3, 1);
    const Vector kx = (c03 + c04) * load(x, h[2]) + (c01 + c02) * load(x, h[3]) - (c01 + c03) * load(x, h[0]) -
                      (c02 + c04) * load(x, h[1]);
    sum += 1.5 * c.material.bending / areas * dot(kx, kx);
  }
  return sum;
}

double energy_of(const SmallCloth& c, const Vectors<double>& x) {
  return (c.material.stretch == Stretch::springs ? spring_energy(c, x) : membrane_energy(c, x)) +
         (c.material.bend == Bend::quadratic ? quadratic_energy(c, x) : 0);
}

std::vector<SmallCloth> small_cloths(const Material& material) {
  return {sheet_of(3, 2, material), tube_of(3, 2, material), tube_of(7, 3, material), closed_of(material)};
}

// Energies are curved over the length of an edge, 2 cm: the error is about (2e-6 / 2e-2)^2 = 1e-8 of the force, and
// rounding leaves 2^-53 energy / step = 1e-10 N m / m of energies of 1 J.
TEST(ProductionClothForces, AreMinusTheSlopeOfTheEnergy) {
  for (const Material& material : all_materials()) {
    if (material.bend == Bend::hinges) continue;  // which have no potential
    for (const SmallCloth& cloth : small_cloths(material)) {
      const int n = cloth.topology.vertices;
      const Vectors<double> x = shaken(cloth.rest, n, .004);
      const Vectors<double> force = forces_of(cloth, x);
      const double size = largest(force, n);
      ASSERT_GT(size, 0);
      constexpr double step = 2e-6;
      for (int i = 0; i < n; ++i)
        for (int c = 0; c < 3; ++c) {
          const auto energy_at = [&](double by) {
            Vectors<double> moved = x;
            (c == 0 ? moved.x : c == 1 ? moved.y : moved.z)[i] += by;
            return energy_of(cloth, moved);
          };
          const double slope = (energy_at(step) - energy_at(-step)) / (2 * step);
          const Vector f = load(force, i);
          EXPECT_NEAR(c == 0 ? f.x : c == 1 ? f.y : f.z, -slope, 1e-6 * size) << int(material.stretch) << ' ' << i;
        }
    }
  }
}

// Of elements alone, so that it holds for hinges without a potential, too. Vertices have up to 30 parts, each rounded
// like a dozen operations: 100 u of the sum of the parts' sizes, which is below 30 times that of the forces.
TEST(ProductionClothForces, HaveNeitherSumNorTorque) {
  for (const Material& material : all_materials())
    for (const SmallCloth& cloth : small_cloths(material)) {
      const int n = cloth.topology.vertices;
      const Vectors<double> x = shaken(cloth.rest, n, .004), force = forces_of(cloth, x);
      Vector sum = {0, 0, 0}, torque = {0, 0, 0};
      double size = 0, farthest = 0;
      for (int i = 0; i < n; ++i) {
        sum = sum + load(force, i), torque = torque + cross(load(x, i), load(force, i));
        size += 30 * size_of(load(force, i)), farthest = std::max(farthest, size_of(load(x, i)));
      }
      EXPECT_LE(size_of(sum), 100 * 0x1p-53 * size);
      EXPECT_LE(size_of(torque), 100 * 0x1p-53 * size * farthest) << int(material.stretch) << ' ' << int(material.bend);
    }
}

// A hinge of two right triangles, folded by theta: sin(theta / 2) without the loss of 1 - n1 . n2, in float; and the
// corners are pulled back, along the slope.
TEST(ProductionClothForces, HingesTurnBack) {
  for (const double theta : {-3., -1., -1e-3, -1e-6, 1e-6, 1e-4, .5, 2., 3.1}) {
    const auto at = [&](double angle, double side) {
      return convert<float>(Vector{side * std::cos(angle), .3, side * std::sin(angle)});
    };
    // Far corners at either side of the y axis; theta / 2 each, up for negative angles.
    const Vector3<float> x0 = at(theta / 2, -1), x1 = at(-theta / 2, 1);
    const Vector3<float> x2 = {0, 0, 0}, x3 = {0, 1, 0};
    const Fold<float> fold = fold_of(x0, x1, x2, x3);
    EXPECT_NEAR(fold.sine, std::sin(theta / 2), 0x1p-22) << theta;
    const Facet<float> first = facet_of(x0, x2, x3), second = facet_of(x1, x3, x2);
    const float torque =
        resistance_of_hinge(1.f, 0.f, 0.f, first.normal, first.size, second.normal, second.size, x3 - x2).torque;
    EXPECT_EQ(torque,
              resistance_of_hinge(1.f, 0.f, 0.f, second.normal, second.size, first.normal, first.size, x2 - x3).torque);
    const Sides<float> push1 = pushes_of_facet(first.at, {torque, 0, 0}),
                       push2 = pushes_of_facet(second.at, {torque, 0, 0});
    const Parts<float, 4> parts = {{push1.of[0] * first.normal, push2.of[0] * second.normal,
                                    push1.of[1] * first.normal + push2.of[2] * second.normal,
                                    push1.of[2] * first.normal + push2.of[1] * second.normal}};
    // Up is against the fold where both are up.
    EXPECT_LT(parts.of[0].z * -std::sin(theta / 2), 0) << theta;
    EXPECT_LT(parts.of[1].z * -std::sin(theta / 2), 0) << theta;
    for (int c = 0; c < 4; ++c)
      EXPECT_LE(std::sqrt(dot(cross(parts.of[c], fold.slope[c]), cross(parts.of[c], fold.slope[c]))), 1e-6f);
  }
}

TEST(ProductionClothForces, HingeSlopeIsThatOfTheAngle) {
  const SmallCloth cloth = sheet_of(1, 1, {.bend = Bend::hinges});
  ASSERT_EQ(cloth.topology.hinges.size(), 1u);
  const Vectors<double> x = shaken(cloth.rest, 4, .006);
  const auto& corner = cloth.topology.hinges[0];
  const auto fold_at = [&](const Vectors<double>& at) {
    return fold_of(load(at, corner[0]), load(at, corner[1]), load(at, corner[2]), load(at, corner[3]));
  };
  const auto theta = [&](const Vectors<double>& at) { return 2 * std::asin(fold_at(at).sine); };
  for (int k = 0; k < 4; ++k)
    for (int c = 0; c < 3; ++c) {
      const auto moved = [&](double by) {
        Vectors<double> at = x;
        (c == 0 ? at.x : c == 1 ? at.y : at.z)[corner[k]] += by;
        return theta(at);
      };
      const Vector slope = fold_at(x).slope[k];
      EXPECT_NEAR(c == 0 ? slope.x : c == 1 ? slope.y : slope.z, -(moved(1e-6) - moved(-1e-6)) / 2e-6, 1e-4);
    }
}

// Springs and hinges find the bits of their rest. F of membranes is off by a few u at rest, and sums of quadratic
// bending by u of their terms: both bounds are of the terms, |P| <= 8 u (lambda + 2 mu) and |w d|.
TEST(ProductionClothForces, AreNotThereAtRestAndInFreeFall) {
  for (const Material& material : all_materials()) {
    const SmallCloth cloth = sheet_of(7, 5, material);
    Vectors<float> x = convert<float>(cloth.rest);
    const Elements<float> e = make_elements<float>(cloth.topology, cloth.rest, material);
    double bound = 0;
    for (int k = 0; k < e.links; ++k) bound = std::max(bound, std::abs(double(e.bending[k])) * .05);
    bound = 12 * 2 * 0x1p-24 * bound;
    if (material.stretch != Stretch::springs) bound += 6 * 16 * 0x1p-24 * (e.lambda + 2 * e.mu) * .02;
    for (const float fall : {0.f, -.37f, -123.456f}) {
      std::ranges::fill(x.y, fall);
      const Vectors<float> force = forces_of(cloth, x);
      for (int i = 0; i < cloth.topology.vertices; ++i) {
        EXPECT_EQ(force.y[i], 0);
        EXPECT_LE(std::abs(force.x[i]), bound);
        EXPECT_LE(std::abs(force.z[i]), bound);
      }
    }
  }
}

TEST(ProductionClothForces, AreNotThereInRigidMotions) {
  const auto turned = [](const Vector& v) {  // about (1, 2, 2) / 3 by 1.1
    const Vector k = {1. / 3, 2. / 3, 2. / 3};
    const double c = std::cos(1.1), s = std::sin(1.1);
    return c * v + s * cross(k, v) + ((1 - c) * dot(k, v)) * k + Vector{3, -2, 1};
  };
  for (const Material& material : all_materials())
    for (const bool flat : {true, false}) {
      if (!flat && material.bend == Bend::quadratic) continue;  // which is flat at rest
      const SmallCloth cloth = flat ? sheet_of(4, 3, material) : tube_of(9, 3, material);
      Vectors<double> x = cloth.rest;
      for (int i = 0; i < cloth.topology.vertices; ++i) store(x, i, turned(load(cloth.rest, i)));
      // Positions near 4 m round by 4 u of double; a strain of an edge of 2 cm is off by 8 u / .02 m times 50 N/m, and
      // a hinge's angle by that times 1e-4 N.
      EXPECT_LE(largest(forces_of(cloth, x), cloth.topology.vertices), 12 * 64 * 0x1p-53 / .02 * 50 * .02 * 4);
    }
}

// F = diag(s, 1) in the plane: P is known, forces on the right side add up to -P_xx times its width, on the lower side
// to -P_yy, and those inside are 0.
TEST(ProductionClothForces, MembranesOfKnownStretch) {
  for (const double s : {.9, 1.3})
    for (const Stretch stretch : {Stretch::stvk, Stretch::corotated}) {
      Material material = {.stretch = stretch, .membrane = 70, .poisson = .2, .bend = Bend::none};
      const SmallCloth cloth = sheet_of(6, 4, material);
      const double lambda = 70 * .2 / (1 - .04), mu = 70 / 2.4, strain = (s * s - 1) / 2;
      const double pxx = stretch == Stretch::stvk ? s * (lambda + 2 * mu) * strain : (lambda + 2 * mu) * (s - 1),
                   pyy = stretch == Stretch::stvk ? lambda * strain : lambda * (s - 1);
      Vectors<double> x = cloth.rest;
      for (double& c : x.x) c *= s;
      const Vectors<double> force = forces_of(cloth, x);
      double right = 0, lower = 0;
      for (int i = 0; i < cloth.topology.vertices; ++i) {
        const Vector at = load(cloth.rest, i), f = load(force, i);
        const bool is_right = at.x > .119, is_lower = at.z > .079;
        if (is_right) right += f.x;
        if (is_lower) lower += f.z;
        EXPECT_NEAR(is_right || at.x < .001 ? 0 : f.x, 0, 1e-6);
        EXPECT_NEAR(is_lower || at.z < .001 ? 0 : f.z, 0, 1e-6);
      }
      // Vertices are floats: their places are off by 2^-24 of up to .12 m, which is 4e-7 of an edge.
      EXPECT_NEAR(right, -pxx * .08, 1e-5);
      EXPECT_NEAR(lower, -pyy * .12, 1e-5);
    }
}

TEST(ProductionClothForces, AreFiniteWhereTheClothHasCollapsed) {
  for (const Material& material : all_materials()) {
    const SmallCloth cloth = sheet_of(3, 3, material);
    Vectors<float> x = convert<float>(cloth.rest);
    const auto expect_finite = [&] {
      const Vectors<float> force = forces_of(cloth, x);
      for (int i = 0; i < cloth.topology.vertices; ++i)
        EXPECT_TRUE(std::isfinite(force.x[i]) && std::isfinite(force.y[i]) && std::isfinite(force.z[i]));
    };
    store(x, 5, load(x, 6));
    expect_finite();
    std::ranges::fill(x.z, 0.f);  // a line
    expect_finite();
    for (Array<float>* c : {&x.x, &x.y, &x.z}) std::ranges::fill(*c, 0.f);  // a point
    expect_finite();
  }
}

// 2 to 54 vertices beyond whole vectors, and elements likewise.
TEST(ProductionClothForces, LanesHaveTheSerialBitsAtEverySizeAndThreadCount) {
  for (const Material& material : all_materials())
    for (const SmallCloth& cloth :
         {sheet_of(1, 1, material), sheet_of(4, 2, material), sheet_of(3, 3, material), sheet_of(8, 5, material),
          tube_of(3, 4, material), tube_of(16, 2, material), closed_of(material), sheet_of(20, 33, material)}) {
      const int n = cloth.topology.vertices;
      const Elements<float> elements = make_elements<float>(cloth.topology, cloth.rest, material);
      const Vectors<float> x = convert<float>(shaken(cloth.rest, n, .004));
      const Vectors<float> expected = forces_of(cloth, x);
      for (const int threads : {1, 2, 3, 4, 8}) {
        omp_set_num_threads(threads);
        State<float> state = openmp::make_state(elements);
        Vectors<float> force;
        force.resize(n);
        openmp::forces(elements, x, state, force);
        const auto same = [&](const Array<float>& a, const Array<float>& b) {
          return std::memcmp(a.data(), b.data(), 4 * n) == 0;
        };
        ASSERT_TRUE(same(force.x, expected.x) && same(force.y, expected.y) && same(force.z, expected.z))
            << n << ' ' << threads << ' ' << int(material.stretch) << ' ' << int(material.bend);
      }
    }
  omp_set_num_threads(1);
}

}  // namespace
}  // namespace lockstep::production_cloth
