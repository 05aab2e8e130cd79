// Where flesh rests, against what is known without finite elements: affine and rigid displacements, the closed form of
// a bar of muscle, balance of forces and torques, and rest, wherever nodes begin.
#include <gtest/gtest.h>

#include <cstdio>

#include "common/production_face/muscle.h"
#include "common/production_face/scene.h"
#include "tests/production_faces.h"

namespace lockstep::production_face {
namespace {

constexpr double u = 0x1p-24;
constexpr Flesh flesh;

// A gradient is no longer than 2 / h in the lattice: the greatest face of a tetrahedron, h^2 / 2, over three times the
// volume, h^3 / 12. F has three of them times differences of two displacements.
double strain_of_error(double error, double h) { return 3 * 2 * error * 2 / h; }

// The derivative of the stress is kappa times the sum of 1 / s^2, no more than 3.5 for the strains of these tests, and
// .3 kappa that resists shape: dP <= 4 kappa dF. In float, F is off by 1e-6 of its greatest entry in nine entries (the
// singular values), and U and V turn by as much.
template <class Real>
double stress_bound(double error, double h) {
  return 4 * flesh.kappa * (strain_of_error(error, h) + (sizeof(Real) == 4 ? 3e-6 : 1e-12));
}

// --- Affine and rigid

// Held nodes move the free ones by about as much as their places are rounded; error_of knows of forces alone.
template <class Real>
double placed(const Vector& size) {
  return sizeof(Real) == 4 ? 4 * u * std::sqrt(dot(size, size)) : 0;
}

template <class Real, class F>
void expect_all_at(const F& to, const Matrix& f, double h, const Posed<Real>& p) {
  const double error = error_of(p), off = distance_from(to, p);
  EXPECT_LE(error, (sizeof(Real) == 4 ? 1e-4 : 1e-6) * h);
  EXPECT_LE(off, 2 * error + placed<Real>({.2, .2, .2}));
  const Matrix expected = stress_of_flesh(flesh, f);
  for (int t = 0; t < p.face.body.tetrahedra; ++t)
    EXPECT_LE(norm(stress_of(p, t) + (-1.) * expected), stress_bound<Real>(off, h)) << t;
}

const std::vector<Matrix> affine = {{{1.3, 0, 0}, {0, .9, 0}, {0, 0, .9}},
                                    {{.7, 0, 0}, {0, 1.2, 0}, {0, 0, 1.2}},
                                    {{1, 0, 0}, {.5, 1, 0}, {0, .2, 1}},
                                    {{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}},
                                    {{1.1, .05, -.2}, {-.1, .9, .1}, {.15, .02, 1.05}}};

template <class Real>
void expect_affine() {
  constexpr double h = 1 / 128.;
  const Body<float> body = held_where(make_body(make_lattice({4, 3, 3}, h), {}, 0), on_box({4 * h, 3 * h, 3 * h}));
  for (const Matrix& f : affine) {
    Posed<Real> p = posed<Real>(body);
    const auto to = [&](const Vector& x) { return f * x + Vector{.02, .01, 0}; };
    bring_bones(to, p);
    // The linear answer is affine, too, so steps beyond the first correct its solve, which is rough: to .05 at first.
    EXPECT_LE(step(p, 1e-9).steps, 12);
    expect_all_at(to, f, h, p);
  }
}

TEST(ProductionFaceOracles, AffineBonesMoveAllFleshAffinely) { expect_affine<float>(), expect_affine<double>(); }

template <class Real>
void expect_rigid() {
  constexpr double h = 1 / 128.;
  const Body<float> body =
      held_where(make_body(make_lattice({5, 2, 3}, h), {}, 0), [](const Vector& x) { return x.x == 0; });
  for (const double angle : {.1, 1., 2.}) {
    Posed<Real> p = posed<Real>(body);
    const Matrix turn = {{std::cos(angle), std::sin(angle), 0}, {-std::sin(angle), std::cos(angle), 0}, {0, 0, 1}};
    const auto to = [&](const Vector& x) { return turn * x + Vector{.02, .03, -.01}; };
    bring_bones(to, p);
    step(p, 1e-9);
    expect_all_at(to, turn, h, p);
  }
}

TEST(ProductionFaceOracles, FleshFollowsABoneThatTurns) { expect_rigid<float>(), expect_rigid<double>(); }

// A bar with a muscle beside its middle, which bends it.
Body<float> bent_bar(double h) {
  const Mesh mesh = make_lattice({6, 3, 2}, h);
  std::vector<Fibre> fibres;
  for (std::int32_t t = 0; t < std::ssize(mesh.tetrahedra); ++t) {
    double y = 0;
    for (const std::int32_t n : mesh.tetrahedra[t]) y += .25 * mesh.nodes[n].y;
    if (y > 2 * h) fibres.push_back({t, 0, {1, 0, 0}, 1});
  }
  return held_where(make_body(mesh, fibres, 1), [](const Vector& x) { return x.x == 0; });
}

TEST(ProductionFaceOracles, TurnedInputGivesTurnedOutput) {
  constexpr double h = 1 / 128.;
  Posed<double> p = posed<double>(bent_bar(h)), turned = p;
  const Matrix turn = svd(affine.back()).u;
  const auto to = [&](const Vector& x) { return turn * x + Vector{.02, 0, .01}; };
  bring_bones(to, turned);
  p.target.activation = turned.target.activation = {.8};
  step(p, 1e-9), step(turned, 1e-9);
  EXPECT_GT(distance_from([](const Vector& x) { return x; }, p), h);  // so there is something to turn
  double off = 0;
  for (int n = 0; n < p.face.body.nodes; ++n) {
    const Vector by = place_of(turned, n) - to(place_of(p, n));
    off = std::max(off, std::sqrt(dot(by, by)));
  }
  EXPECT_LE(off, 2 * (error_of(p) + error_of(turned)));
  EXPECT_LE(off, 1e-6 * h);
}

// --- A bar

// P_11 + t with free sides.
double pull_of(double along, double activation) {
  const Tension<double> t = tension<double>(along, muscle_stress * activation, muscle_stress, false);
  return axial_stress(along, across_of(along)).x + along * t.per_stretch;
}

Body<float> muscle_bar(double h) {
  const Mesh mesh = make_lattice({4, 2, 2}, h);
  std::vector<Fibre> fibres;
  for (std::int32_t t = 0; t < std::ssize(mesh.tetrahedra); ++t) fibres.push_back({t, 0, {1, 0, 0}, 1});
  return make_body(mesh, fibres, 1);
}

// One node is held, so nothing is restrained, and the bar may turn: F^T F is compared, which is off by 2 |F| of what F
// is. |f| over a face of a tetrahedron, at least h^2 / 8, is a stress; a bar twice as long as wide multiplies it by no
// more than 16 as it bends. The coefficients of the curves are float, off by 3e-8.
TEST(ProductionFaceOracles, AMuscleShortensItsBarByAClosedForm) {
  constexpr double h = 1 / 128., young = 4.716e5;
  for (const float activation : {.1f, .5f, 1.f}) {
    Posed<double> p =
        posed<double>(held_where(muscle_bar(h), [](const Vector& x) { return x.x == 0 && x.y == 0 && x.z == 0; }));
    p.target.activation = {activation};
    step(p, 1e-10);
    const double along = zero_of([&](double l) { return pull_of(l, activation); }, .5, 1), across = across_of(along);
    EXPECT_LT(along, 1);
    const double bound = 2 * 2 * 16 * 8 / (h * h) * p.memory.frame.last / young + 1e-7;
    for (int t = 0; t < p.face.body.tetrahedra; ++t) {
      const Matrix f = strain_of(p, t), square = product(transposed(f), f);
      const Matrix expected = {{along * along, 0, 0}, {0, across * across, 0}, {0, 0, across * across}};
      EXPECT_LE(norm(square + (-1.) * expected), bound) << activation;
    }
    std::printf("activation %.1f: stretch %.6f, across %.6f, %d steps, bound %.1e\n", activation, along, across,
                p.memory.frame.steps, bound);
  }
}

// Both ends are held where free sides would be, so all of the bar is strained alike. Flesh pulls its bones together.
TEST(ProductionFaceOracles, ABarPullsItsBonesByAClosedForm) {
  constexpr double h = 1 / 128., area = 4 * h * h;
  const Body<float> body = held_where(muscle_bar(h), [](const Vector& x) { return x.x == 0 || x.x > 3.9 * h; });
  const auto expect = [&]<class Real>(Posed<Real> p, double along, Real activation, bool is_passive) {
    const double across = across_of(along);
    bring_bones([&](const Vector& x) { return Vector{along * x.x, across * x.y, across * x.z}; }, p);
    p.target.activation.assign(p.face.body.muscles, activation);
    step(p, 1e-8);
    const double expected = area * (is_passive ? axial_stress(along, across).x : pull_of(along, activation));
    const double bound = area * (stress_bound<Real>(2 * error_of(p) + placed<Real>({.04, .02, .02}), h));
    const Vector low = reaction(p, [](const Vector&x) { return x.x == 0; }),
                 high = reaction(p, [](const Vector&x) { return x.x > 0; });
    EXPECT_LE(bound, .02 * std::abs(expected));
    EXPECT_NEAR(low.x, -expected, bound) << along << ' ' << activation;
    EXPECT_NEAR(high.x, expected, bound) << along << ' ' << activation;
    for (const double other : {low.y, low.z, high.y, high.z}) EXPECT_NEAR(other, 0, bound);
    return high.x / area;
  };
  const Body<float> flesh_alone = held_where(make_body(make_lattice({4, 2, 2}, h), {}, 0),
                                             [](const Vector& x) { return x.x == 0 || x.x > 3.9 * h; });
  for (const auto& [along, known] : {std::pair{.7, -233371.}, {1.3, 104483.}, {1.6, 170443.}}) {
    EXPECT_NEAR(expect(posed<double>(flesh_alone), along, 0., true), known, 2);
    expect(posed<float>(flesh_alone), along, 0.f, true);
  }
  for (const double along : {.8, 1., 1.2}) {
    expect(posed<double>(body), along, .6, false);
    expect(posed<float>(body), along, .6f, false);
  }
}

// --- Balance

// What rounding makes of forces and torques that sum to 0. A tetrahedron's forces, volume |P| |gradient|, round by 4 u,
// those of the first corner by 3 more; a node adds no more than 32 of them: 40 u of the sum of their sizes. A torque
// has the same about the origin; besides, P F^T is symmetric but for U and V, which are rotations to 1.2e-6 each, and
// the principal stresses' F, off by 3e-6.
struct Balance {
  Vector force = {0, 0, 0}, torque = {0, 0, 0};
  double force_bound = 0, torque_bound = 0;
};

Balance balance_of(const Posed<float>& p) {
  Balance balance;
  const Body<float>& body = p.face.body;
  const std::vector<Vector> force = forces_on_nodes(p);
  for (int n = 0; n < body.nodes; ++n)
    balance.force = balance.force + force[n], balance.torque = balance.torque + cross(place_of(p, n), force[n]);
  for (int t = 0; t < body.tetrahedra; ++t) {
    const double volume = body.volume.at(t, 0), stress = norm(stress_of(p, t));
    double parts = 0, arm = 0;
    for (int a = 0; a < 3; ++a) {
      const Vector g = {body.gradient.at(t, 3 * a), body.gradient.at(t, 3 * a + 1), body.gradient.at(t, 3 * a + 2)};
      parts += 2 * volume * stress * std::sqrt(dot(g, g));
    }
    for (int a = 0; a < 4; ++a) {
      const Vector x = place_of(p, body.corner.at(t, a));
      arm = std::max(arm, std::sqrt(dot(x, x)));
    }
    balance.force_bound += 40 * u * parts;
    balance.torque_bound += 40 * u * parts * arm + 5.4e-6 * volume * stress * norm(strain_of(p, t));
  }
  return balance;
}

void expect_balance(const Posed<float>& p, const char* name) {
  const Balance b = balance_of(p);
  const double force = std::sqrt(dot(b.force, b.force)), torque = std::sqrt(dot(b.torque, b.torque));
  EXPECT_LE(force, b.force_bound) << name;
  EXPECT_LE(torque, b.torque_bound) << name;
  std::printf("%s: sum of forces %.1e N (bound %.1e), of torques %.1e N m (bound %.1e)\n", name, force, b.force_bound,
              torque, b.torque_bound);
}

// Inside out, too: the energy goes on there.
TEST(ProductionFaceOracles, ForcesAndTorquesBalance) {
  for (const char* name : {"bar_shaken", "inside_out"}) {
    const Scene scene = load_scene("scenes/production_face/" + std::string(name) + ".toml");
    Posed<float> p = posed<float>(scene.body);
    p.pose = scene.pose;
    serial::update_state(p.face.body, p.face.flesh, p.pose, false, p.memory.strained);
    expect_balance(p, name);
  }
}

// At rest in its bones' hands, the bones' forces are all there are.
TEST(ProductionFaceOracles, BonesBalanceEachOther) {
  Posed<float> p = posed<float>(bent_bar(1 / 128.));
  p.face.body.held.clear();
  const auto held = [](const Vector& x) { return x.x == 0 || x.x > 5.9 / 128; };
  p = posed<float>(held_where(p.face.body, held));
  bring_bones([](const Vector& x) { return x.x == 0 ? x : x + Vector{-.004, .006, .002}; }, p);
  p.target.activation = {.7f};
  const Frame& frame = step(p, 1e-6);
  expect_balance(p, "bent bar");
  const Vector low = reaction(p, [](const Vector&x) { return x.x == 0; }),
               high = reaction(p, [](const Vector&x) { return x.x > 0; }), sum = low + high;
  EXPECT_GT(std::sqrt(dot(low, low)), 1);
  // |sum over free nodes| <= sqrt(nodes) |f|.
  EXPECT_LE(std::sqrt(dot(sum, sum)), balance_of(p).force_bound + std::sqrt(double(p.face.body.nodes)) * frame.last);
}

// --- Inside out

TEST(ProductionFaceOracles, CrushedFleshFindsBackToRest) {
  constexpr double h = .005;
  constexpr Vector size = {6 * h, 4 * h, 6 * h};
  const Body<float> body = held_where(make_body(make_lattice({6, 4, 6}, h), {}, 0), on_box(size));
  std::mt19937 generator(1);
  const auto anywhere = [&](double to) { return to * std::uniform_real_distribution<double>(0, 1)(generator); };
  const auto expect = [&](const char* name, int most_frames, const auto& at) {
    Posed<float> p = posed<float>(body);
    const std::vector<bool> is_held = held_nodes(body);
    for (int n = 0; n < body.nodes; ++n)
      if (!is_held[n]) store(p.pose.displacement, n, convert<float>(at(rest_of(p, n)) - rest_of(p, n)));
    EXPECT_LE(least_volume(p), 0) << name;
    int frames = 0;
    const auto off = [&] { return distance_from([](const Vector& x) { return x; }, p) / h; };
    do {
      const Frame& frame = step(p, 1e-6);
      ++frames;
      std::printf("%s: %d steps, %d halved, %d iterations, |f| %.1e -> %.1e N, least volume %.3f, %.1e h from rest\n",
                  name, frame.steps, frame.halvings, frame.iterations, frame.first, frame.last, least_volume(p), off());
      ASSERT_TRUE(std::isfinite(frame.last)) << name;
    } while (frames < most_frames && p.memory.frame.steps == most_steps);
    EXPECT_LT(off(), 1e-4) << name;
    EXPECT_GT(least_volume(p), .99) << name;
  };
  expect("anywhere", 4, [&](const Vector&) { return Vector{anywhere(size.x), anywhere(size.y), anywhere(size.z)}; });
  expect("at a point", 1, [&](const Vector&) { return .5 * size; });
  expect("on a plane", 1, [&](const Vector& x) { return Vector{x.x, x.y, .5 * size.z}; });
  expect("mirrored", 1, [&](const Vector& x) { return Vector{size.x - x.x, x.y, x.z}; });
  expect("mirrored thrice", 1, [&](const Vector& x) { return size - x; });
}

}  // namespace
}  // namespace lockstep::production_face
