// What a pose makes of tetrahedra: against closed forms in double, by differences, and both versions against each
// other.
#include <gtest/gtest.h>
#include <omp.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "common/convert.h"
#include "common/production_face/make.h"
#include "common/production_face/scene.h"
#include "common/production_face/update_state.h"
#include "tests/production_face_matrices.h"

namespace lockstep::production_face {
namespace {

constexpr Flesh flesh;
constexpr double u = 0x1p-24;

Matrix rotation(std::mt19937& generator) { return svd(random_matrix(generator)).u; }

template <class Real>
Matrix matrix_at(const Blocked<Real>& from, int t) {
  const auto column = [&](int k) { return Vector{from.at(t, k), from.at(t, k + 1), from.at(t, k + 2)}; };
  return {column(0), column(3), column(6)};
}

template <class Real>
Vector displacement_at(const Body<Real>& body, const Pose<Real>& pose, int t, int a) {
  return convert<double>(load(pose.displacement, body.corner.at(t, a)));
}

template <class Real>
Vector gradient_at(const Body<Real>& body, int t, int a) {
  return {body.gradient.at(t, 3 * a), body.gradient.at(t, 3 * a + 1), body.gradient.at(t, 3 * a + 2)};
}

// F in double, of what stands in the arrays.
template <class Real>
Matrix strain_at(const Body<Real>& body, const Pose<Real>& pose, int t) {
  Matrix f = identity;
  for (int a = 0; a < 3; ++a)
    f = f + outer(displacement_at(body, pose, t, a + 1) - displacement_at(body, pose, t, 0), gradient_at(body, t, a));
  return f;
}

// How far each entry of F may be from that of displacements that were not rounded, to first order. Displacements were
// rounded, and so was their difference, by 2 u times the two. A gradient, its product and three sums round by 5 u of
// what is added, and the sums with the identity by 3 u more.
Matrix strain_error(const Body<float>& body, const Pose<float>& pose, int t) {
  Matrix error = (3 * u) * Matrix{{1, 1, 1}, {1, 1, 1}, {1, 1, 1}};
  const Vector first = displacement_at(body, pose, t, 0);
  for (int a = 0; a < 3; ++a) {
    const Vector other = displacement_at(body, pose, t, a + 1), gradient = size_of(gradient_at(body, t, a));
    error = error + outer(2 * u * (size_of(other) + size_of(first)) + 5 * u * size_of(other - first), gradient);
  }
  return error;
}

// How far a stress may be from that of the exact F, in the Frobenius norm and to first order, for J >= crushed.
//
// Nine entries of U diag(s) V^T are each off by 1e-6 of the greatest of F (svd.h), as though F itself was: with F's own
// error, that times the stiffness, no more than the greatest sum of a row of the derivative. U and V are rotations to
// 1.2e-6, so what is composed of them is off by 2.4e-6 of the stress. A principal stress is a sum of parts, of which
// none passes more than sixteen operations, a logarithm and a cube root counted as two each: 16 u times the sum of
// their sizes.
double stress_error(const Matrix& f, const Matrix& of_strain) {
  const Vector s = svd(f).s, squares = {s.x * s.x, s.y * s.y, s.z * s.z};
  const FleshSlopes<double> d = flesh_slopes(flesh, s);
  const StressDerivative<double> a = stress_derivative(d, s);
  const double stiffness =
      std::max({std::abs(a.xx) + std::abs(a.xy) + std::abs(a.zx), std::abs(a.xy) + std::abs(a.yy) + std::abs(a.yz),
                std::abs(a.zx) + std::abs(a.yz) + std::abs(a.zz), std::abs(a.alpha.x) + std::abs(a.beta.x),
                std::abs(a.alpha.y) + std::abs(a.beta.y), std::abs(a.alpha.z) + std::abs(a.beta.z)});
  const double volume = s.x * s.y * s.z, j = std::pow(volume, -2. / 3), i = dot(s, s);
  const double pairs = .5 * (i * i - dot(squares, squares));
  const double by_volume =
      (2. / 3 * j * (flesh.m10 * i + 2 * flesh.m01 * j * pairs) + flesh.kappa * std::abs(std::log(volume))) / volume;
  const auto part = [&](double x) {
    return 2 * j * (flesh.m10 + flesh.m01 * j * (i + x * x)) * x + by_volume * volume / x;
  };
  const Vector parts = {part(s.x), part(s.y), part(s.z)};
  EXPECT_GE(volume, crushed);
  return stiffness * (norm(of_strain) + 3e-6 * most(f)) + 2.4e-6 * norm(stress_of_flesh(flesh, f)) +
         16 * u * std::sqrt(dot(parts, parts));
}

// Displacements that move a body's points by a function of their place.
template <class F>
Pose<float> moved(const Body<float>& body, const F& to) {
  Pose<float> pose;
  pose.displacement.resize(body.nodes);
  for (int n = 0; n < body.nodes; ++n) {
    const Vector x = convert<double>(load(body.rest, n));
    store(pose.displacement, n, convert<float>(to(x) - x));
  }
  pose.activation.assign(body.muscles, 1);
  return pose;
}

Strained<float> serially(const Body<float>& body, const Pose<float>& pose, bool definite) {
  Strained<float> strained = make_strained(body);
  serial::update_state(body, flesh, pose, definite, strained);
  return strained;
}

const Matrix affine = {{1.1, .05, -.2}, {-.1, .9, .1}, {.15, .02, 1.05}};

// --- Strain and stress

// A fibre along an axis says where F brings the axis, without another rounding.
TEST(ProductionFaceUpdateState, AffineDisplacementsStrainAllAlike) {
  const Mesh mesh = make_lattice({3, 2, 2}, .0028);
  std::vector<Fibre> fibres;
  for (std::int32_t t = 0; t < std::ssize(mesh.tetrahedra); ++t)
    for (const Vector& axis : {identity.x, identity.y, identity.z}) fibres.push_back({t, 0, axis, 1});
  const Body<float> body = make_body(mesh, fibres, 1);
  const Pose<float> pose = moved(body, [](const Vector& x) { return affine * x + Vector{.02, -.03, .01}; });
  const Strained<float> strained = serially(body, pose, false);
  for (int t = 0; t < body.tetrahedra; ++t) {
    const auto along = [&](int axis) {
      const int place = (body.first_fibre[t / lanes] + axis) * lanes + t % lanes;
      return Vector{strained.pull.at(place, 0), strained.pull.at(place, 1), strained.pull.at(place, 2)};
    };
    const Matrix off = Matrix{along(0), along(1), along(2)} + (-1.) * affine, error = strain_error(body, pose, t);
    for (const auto& [found, bound] : {std::pair{off.x, error.x}, {off.y, error.y}, {off.z, error.z}}) {
      EXPECT_LE(std::abs(found.x), bound.x);
      EXPECT_LE(std::abs(found.y), bound.y);
      EXPECT_LE(std::abs(found.z), bound.z);
    }
  }
}

TEST(ProductionFaceUpdateState, AffineDisplacementsStressAllAlike) {
  const Body<float> body = make_body(make_lattice({3, 2, 2}, .0028), {}, 0);
  std::mt19937 generator(1);
  for (int i = 0; i < 20; ++i) {
    const Matrix f = i == 0 ? affine : product(rotation(generator), identity + .1 * random_matrix(generator));
    const Pose<float> pose = moved(body, [&](const Vector& x) { return f * x; });
    const Strained<float> strained = serially(body, pose, false);
    for (int t = 0; t < body.tetrahedra; ++t)
      EXPECT_LE(norm(matrix_at(strained.stress, t) + (-1.) * stress_of_flesh(flesh, f)),
                stress_error(f, strain_error(body, pose, t)));
  }
}

// The bound is 250 to 800 Pa at .1 m, kappa times a strain of 1e-4 and more: displacements are rounded by 6e-9 m, and
// tetrahedra are 2.8 mm wide.
TEST(ProductionFaceUpdateState, RigidMotionsMakeNoStress) {
  const Body<float> body = make_body(make_lattice({2, 2, 2}, .0028), {}, 0);
  std::mt19937 generator(2);
  for (int i = 0; i < 30; ++i) {
    const Matrix turn = rotation(generator);
    const Vector by = .1 * random_matrix(generator).x;
    const Pose<float> pose = moved(body, [&](const Vector& x) { return turn * x + by; });
    const Strained<float> strained = serially(body, pose, false);
    for (int t = 0; t < body.tetrahedra; ++t) {
      const double bound = stress_error(turn, strain_error(body, pose, t));
      EXPECT_LE(norm(matrix_at(strained.stress, t)), bound);
      EXPECT_LE(bound, 1e-3 * flesh.kappa);
    }
  }
}

TEST(ProductionFaceUpdateState, RestHasNoStress) {
  const Body<float> body = make_body(make_lattice({2, 2, 2}, .0028), {}, 0);
  const Strained<float> strained = serially(body, moved(body, [](const Vector& x) { return x; }), true);
  for (const float p : strained.stress.value) EXPECT_EQ(p, 0);
}

// Each of the two poses is as its own displacements in double say; that of the turned one has its rounding in it, too.
TEST(ProductionFaceUpdateState, StressTurnsWithTheInput) {
  const Body<float> body = make_body(make_lattice({3, 3, 2}, .0028), {}, 0);
  std::mt19937 generator(3);
  const Matrix turn = rotation(generator);
  Pose<float> pose = moved(body, [&](const Vector& x) { return x + .0002 * random_matrix(generator).x; });
  Pose<float> turned = pose;
  for (int n = 0; n < body.nodes; ++n) {
    const Vector x = convert<double>(load(body.rest, n)), at = x + convert<double>(load(pose.displacement, n));
    store(turned.displacement, n, convert<float>(turn * at - x));
  }
  const Strained<float> before = serially(body, pose, false), after = serially(body, turned, false);
  for (int t = 0; t < body.tetrahedra; ++t) {
    const Matrix f = strain_at(body, pose, t),
                 difference = matrix_at(after.stress, t) + (-1.) * product(turn, matrix_at(before.stress, t));
    EXPECT_LE(norm(difference), stress_error(f, strain_error(body, pose, t)) +
                                    stress_error(product(turn, f), strain_error(body, turned, t)));
  }
}

TEST(ProductionFaceUpdateState, AnythingIsFinite) {
  const Body<float> body = make_body(make_lattice({1, 1, 1}, .005), {{0, 0, {1, 0, 0}, 1}, {5, 0, {0, 1, 0}, 1}}, 1);
  const Matrix worst =
      39. * Matrix{{1, 1, -1}, {1, -1, 1}, {1, 1, 1}};  // of all with such entries, of the greatest volume
  const std::vector<Matrix> strains = {{{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                       {{-1, 0, 0}, {0, -1, 0}, {0, 0, -1}},
                                       {{1, 0, 0}, {0, 1, 0}, {0, 0, 0}},
                                       {{1, 0, 0}, {0, 0, 0}, {0, 0, 0}},
                                       {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}},
                                       {{.1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                       {{.01, 0, 0}, {0, .01, 0}, {0, 0, -.01}},
                                       {{1e-20, 0, 0}, {0, 1e-20, 0}, {0, 0, 1e-20}},
                                       worst,
                                       (-1.) * worst};
  for (const Matrix& f : strains)
    for (const bool definite : {false, true}) {
      const Strained<float> s = serially(body, moved(body, [&](const Vector& x) { return f * x; }), definite);
      for_each_array(s, [&](const char* name, const Array<float>& values, std::size_t) {
        for (const float x : values) ASSERT_TRUE(std::isfinite(x)) << name;
      });
    }
}

// --- The derivative

template <class Real>
StressDerivative<double> derivative_at(const Strained<Real>& s, int t) {
  const auto d = [&](int k) { return static_cast<double>(s.derivative.at(t, k)); };
  return {d(0), d(1), d(2), d(3), d(4), d(5), {d(6), d(7), d(8)}, {d(9), d(10), d(11)}};
}

// What the fibres of a tetrahedron add to dP of dF.
template <class Real>
Matrix of_fibres(const Body<Real>& body, const Strained<Real>& s, int t, const Matrix& df) {
  Matrix sum = 0. * identity;
  for (int slot = body.first_fibre[t / lanes]; slot < body.first_fibre[t / lanes + 1]; ++slot) {
    const int place = slot * lanes + t % lanes;
    const Vector w = {body.fibre.at(place, 0), body.fibre.at(place, 1), body.fibre.at(place, 2)}, dw = df * w;
    const Vector along = {s.pull.at(place, 0), s.pull.at(place, 1), s.pull.at(place, 2)};
    sum = sum + outer(double(s.pull.at(place, 3)) * dw + double(s.pull.at(place, 4)) * dot(along, dw) * along, w);
  }
  return sum;
}

// The form of the flesh's block is definite but for the rounding of its entries, 12 u of it (production_face_svd_test),
// and U and V lengthen dF by less than that; pairs are. A fibre's is (t / l) |dw|^2 + c (F w . dw)^2 >= 0, since (F w .
// dw)^2 <= l^2 |dw|^2; l^2, c l^2 and both products round by 8 u of t / l.
TEST(ProductionFaceUpdateState, DefiniteFormsAreNotNegative) {
  const Scene scene = load_scene("scenes/production_face/inside_out.toml");
  std::mt19937 generator(4);
  int negative = 0, with_fibres = 0;
  const Strained<float> definite = serially(scene.body, scene.pose, true),
                        exact = serially(scene.body, scene.pose, false);
  for (int t = 0; t < scene.body.tetrahedra; ++t)
    for (int i = 0; i < 8; ++i) {
      const Matrix df = random_matrix(generator);
      const auto form = [&](const Strained<float>& s) {
        return inner(df, applied(derivative_at(s, t), matrix_at(s.u, t), matrix_at(s.v, t), df) +
                             of_fibres(scene.body, s, t, df));
      };
      const StressDerivative<double> d = derivative_at(definite, t);
      const double block =
          std::sqrt(d.xx * d.xx + d.yy * d.yy + d.zz * d.zz + 2 * (d.xy * d.xy + d.yz * d.yz + d.zx * d.zx));
      double pulls = 0;
      for (int slot = scene.body.first_fibre[t / lanes]; slot < scene.body.first_fibre[t / lanes + 1]; ++slot)
        pulls += definite.pull.at(slot * lanes + t % lanes, 3);
      EXPECT_GE(form(definite), -u * (13 * block + 8 * pulls) * inner(df, df)) << t;
      negative += form(exact) < 0;
      with_fibres += pulls > 0;
    }
  EXPECT_GT(negative, 1000);  // so there was something to make definite
  EXPECT_GT(with_fibres, 1000);
}

// Central differences of double: the error is step^2 times the third derivative, and the stress's rounding by step.
TEST(ProductionFaceUpdateState, DerivativeIsTheSlopeOfTheStress) {
  const Scene scene = load_scene("scenes/production_face/bar_shaken.toml");
  const Body<double> body = in_double(scene.body);
  const Pose<double> pose = {convert<double>(scene.pose.displacement), convert<double>(scene.pose.activation)};
  std::mt19937 generator(5);
  Vectors<double> direction;
  direction.resize(body.nodes);
  for (int n = 0; n < body.nodes; ++n) store(direction, n, .005 * random_matrix(generator).x);
  const auto at = [&](double step) {
    Pose<double> moved = pose;
    for (int n = 0; n < body.nodes; ++n)
      store(moved.displacement, n, load(pose.displacement, n) + step * load(direction, n));
    return moved;
  };
  const auto strained = [&](const Pose<double>& p) {
    Strained<double> s = make_strained(body);
    serial::update_state(body, flesh, p, false, s);
    return s;
  };
  constexpr double step = 1e-6;
  const Pose<double> further = at(step);
  const Strained<double> here = strained(pose), plus = strained(further), minus = strained(at(-step));
  for (int t = 0; t < body.tetrahedra; ++t) {
    const Matrix df = (1 / step) * (strain_at(body, further, t) + (-1.) * strain_at(body, pose, t));
    const Matrix slope = (.5 / step) * (matrix_at(plus.stress, t) + (-1.) * matrix_at(minus.stress, t));
    const Matrix found =
        applied(derivative_at(here, t), matrix_at(here.u, t), matrix_at(here.v, t), df) + of_fibres(body, here, t, df);
    EXPECT_LE(norm(found + (-1.) * slope), 1e-6 * (norm(found) + 1e6)) << t;
  }
}

// --- Both versions

void expect_same_bits(const Body<float>& body, const Pose<float>& pose) {
  for (const bool definite : {false, true}) {
    const Strained<float> expected = serially(body, pose, definite);
    for (const int threads : {1, 2, 3, 4, 8}) {
      omp_set_num_threads(threads);
      Strained<float> found = make_strained(body);
      for (Array<float>* values :
           {&found.stress.value, &found.u.value, &found.v.value, &found.derivative.value, &found.pull.value})
        std::ranges::fill(*values, std::numeric_limits<float>::quiet_NaN());
      openmp::update_state(body, flesh, pose, definite, found);
      const auto same = [](const Blocked<float>& a, const Blocked<float>& b) {
        return a.value.empty() || std::memcmp(a.value.data(), b.value.data(), a.value.size() * sizeof(float)) == 0;
      };
      EXPECT_TRUE(same(found.stress, expected.stress)) << threads;
      EXPECT_TRUE(same(found.u, expected.u) && same(found.v, expected.v)) << threads;
      EXPECT_TRUE(same(found.derivative, expected.derivative)) << threads;
      EXPECT_TRUE(same(found.pull, expected.pull)) << threads;
    }
  }
}

TEST(ProductionFaceUpdateState, ThreadsKeepTheBits) {
  const int before = omp_get_max_threads();
  for (const char* name : {"bar_shaken", "inside_out"}) {
    const Scene scene = load_scene("scenes/production_face/" + std::string(name) + ".toml");
    expect_same_bits(scene.body, scene.pose);
  }
  // Twelve tetrahedra, twenty-four, with fibres at the ends of blocks and without.
  std::mt19937 generator(6);
  for (const int cells : {1, 2, 4})
    for (const bool has_fibres : {false, true}) {
      const Mesh mesh = make_lattice({cells, 1, 1}, .005);
      const auto last = static_cast<std::int32_t>(mesh.tetrahedra.size()) - 1;
      std::vector<Fibre> fibres;
      if (has_fibres) fibres = {{0, 0, {1, 0, 0}, 1}, {last, 0, {0, .6, .8}, .5}, {last, 1, {0, 1, 0}, 1}};
      const Body<float> body = make_body(mesh, fibres, has_fibres ? 2 : 0);
      expect_same_bits(body, moved(body, [&](const Vector& x) { return x + .001 * random_matrix(generator).x; }));
    }
  omp_set_num_threads(before);
}

}  // namespace
}  // namespace lockstep::production_face
