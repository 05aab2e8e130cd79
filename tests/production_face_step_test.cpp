// Frames of the face: how Newton's method converges and where it stops, what must hold of frames in a row, and how
// bones and muscles move between keys.
#include "common/production_face/step.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdio>
#include <thread>

#include "common/production_face/muscle.h"
#include "common/production_face/scene.h"
#include "tests/production_faces.h"

namespace lockstep::production_face {
namespace {

constexpr auto in_place = [](const Vector& x) { return x; };

Scene scene_of(const char* name) { return load_scene("scenes/production_face/" + std::string(name) + ".toml"); }

// --- A jaw

// The jaw of bar_turns turns about its pivot at once, and opens as it turns.
template <class Real>
Posed<Real> turned_jaw(const Scene& scene, double angle) {
  Posed<Real> p = posed<Real>(scene.body);
  Motion motion = scene.motion;
  motion.keys.back().bones[1] = {.turn = {0, 0, -angle}, .shift = {0, .01 * angle, 0}};
  p.target.held = convert<Real>(target_at(scene.body, motion, 1).held);
  return p;
}

TEST(ProductionFaceStep, AJawThatTurnsAtOnceTurnsNothingInsideOut) {
  const Scene scene = scene_of("bar_turns");
  for (const double angle : {.1, .3, .5}) {
    Posed<float> p = turned_jaw<float>(scene, angle);
    const Frame& frame = step(p, 1e-3);
    EXPECT_GT(least_volume(p), .9) << angle;
    EXPECT_LE(frame.last, 1e-3 * frame.first);
    EXPECT_LE(frame.steps, 6);
    EXPECT_EQ(frame.halvings, 0);
    std::printf("%.1f rad: %d steps, %d iterations, least volume %.3f\n", angle, frame.steps, frame.iterations,
                least_volume(p));
  }
}

// Six digits more take two steps more: each step may leave the share of |f| that |f| itself is of the first, or 1e-5.
// Of a method that is linear, such as one whose stiffness stays definite, a step leaves a tenth.
TEST(ProductionFaceStep, DigitsDoubleNearTheEnd) {
  const Scene scene = scene_of("bar_turns");
  for (const double angle : {.1, .5}) {
    Posed<double> rough = turned_jaw<double>(scene, angle), fine = rough;
    step(rough, 1e-3), step(fine, 1e-9);
    EXPECT_LE(fine.memory.frame.last, 1e-9 * fine.memory.frame.first);
    EXPECT_LE(fine.memory.frame.steps, rough.memory.frame.steps + 2);
  }
}

// From a rough frame on, by steps of the same stiffness and forces with exact solves: below a hundredth of the first
// |f|, each step squares it but for a factor.
TEST(ProductionFaceStep, NewtonsMethodIsQuadratic) {
  Posed<double> p = turned_jaw<double>(scene_of("bar_turns"), .3);
  step(p, .1);
  const double first = p.memory.frame.first;
  std::vector<double> force;
  for (int k = 0; k < 5 && (k == 0 || force.back() > 1e-9 * first); ++k) {
    const Correction correction = correction_of(p);
    force.push_back(correction.force);
    for (int n = 0; n < p.face.body.nodes; ++n)
      store(p.pose.displacement, n, load(p.pose.displacement, n) + at_node<double>(correction.change, n));
    std::printf("%s%.1e", k ? ", " : "|f|: ", force.back());
  }
  std::printf(" N\n");
  ASSERT_GE(force.size(), 4u);
  for (std::size_t k = force.size() - 2; k < force.size(); ++k) {
    EXPECT_LT(force[k - 2], 1e-2 * first);
    EXPECT_GT(std::log(force[k] / force[k - 1]) / std::log(force[k - 1] / force[k - 2]), 1.8) << k;
  }
}

// --- Frames in a row

// A small bar between two bones, with a muscle on either side.
Body<float> small_bar() {
  constexpr double h = 1 / 128.;
  const Mesh mesh = make_lattice({8, 4, 2}, h);
  std::vector<Fibre> fibres;
  for (std::int32_t t = 0; t < std::ssize(mesh.tetrahedra); ++t) {
    double y = 0;
    for (const std::int32_t n : mesh.tetrahedra[t]) y += .25 * mesh.nodes[n].y;
    if (y < h || y > 3 * h) fibres.push_back({t, y > h, {1, 0, 0}, 1});
  }
  return held_where(make_body(mesh, fibres, 2), [=](const Vector& x) { return x.x == 0 || x.x == 8 * h; });
}

// From rest to the end of a motion in frames of equal shares of it.
Posed<float> brought_in(int frames, double tolerance) {
  Posed<float> p = posed<float>(small_bar());
  for (int f = 1; f <= frames; ++f) {
    const double share = double(f) / frames, angle = .4 * share;
    const Matrix turn = {{std::cos(angle), std::sin(angle), 0}, {-std::sin(angle), std::cos(angle), 0}, {0, 0, 1}};
    bring_bones([&](const Vector& x) { return x.x == 0 ? x : turn * x; }, p);
    p.target.activation = {static_cast<float>(.8 * share), 0};
    step(p, tolerance);
  }
  return p;
}

// Without inertia, only the end of a motion matters.
TEST(ProductionFaceStep, SlownessChangesNothing) {
  const Posed<float> fast = brought_in(3, 1e-5), slow = brought_in(6, 1e-5), at_once = brought_in(1, 1e-5);
  EXPECT_GT(distance_from(in_place, fast), 1e-3);
  for (const Posed<float>* other : {&slow, &at_once}) {
    double off = 0;
    for (int n = 0; n < fast.face.body.nodes; ++n) {
      const Vector by = place_of(fast, n) - place_of(*other, n);
      off = std::max(off, std::sqrt(dot(by, by)));
    }
    EXPECT_LE(off, 2 * (error_of(fast) + error_of(*other)));
    EXPECT_LE(off, 1e-3 / 128);
  }
}

TEST(ProductionFaceStep, BonesAndMusclesAtRestBringFleshToRest) {
  Posed<float> p = brought_in(2, 1e-4);
  bring_bones(in_place, p);
  p.target.activation = {0, 0};
  step(p, 1e-6);
  EXPECT_LE(distance_from(in_place, p), 1e-4 / 128);
}

// Where the energy falls by less than its rounding, |f| may grow in a step before it falls: a frame must not end there.
TEST(ProductionFaceStep, EveryFrameEndsWithinItsTolerance) {
  const Scene scene = scene_of("bar_pulls");
  Posed<float> p = posed<float>(scene.body);
  for (int f = 1; f <= scene.frames; ++f) {
    p.target = target_at(scene.body, scene.motion, f * frame_time);
    const Frame& frame = step(p, scene.tolerance);
    EXPECT_LE(frame.last, std::max(scene.tolerance * frame.first, force_of_rounding(p.face))) << f;
    EXPECT_GT(least_volume(p), .9);
  }
  EXPECT_LE(distance_from(in_place, p), 2 * error_of(p));  // one second later, it is at rest
}

// The lattice's diagonals are their own mirror images where it has an even number of cells across.
TEST(ProductionFaceStep, SymmetricMusclesMakeASymmetricPose) {
  constexpr double across = 4 / 128.;
  Posed<double> p = posed<double>(small_bar());
  bring_bones([](const Vector& x) { return x.x == 0 ? x : .9 * x + Vector{0, .05 * across, 0}; }, p);
  p.target.activation = {.8, .8};
  step(p, 1e-9);
  const auto node_at = [&](const Vector& x) {
    int nearest = 0;
    for (int n = 0; n < p.face.body.nodes; ++n) {
      const Vector a = rest_of(p, n) - x, b = rest_of(p, nearest) - x;
      if (dot(a, a) < dot(b, b)) nearest = n;
    }
    return nearest;
  };
  const auto mirrored = [](const Vector& x) { return Vector{x.x, across - x.y, x.z}; };
  double off = 0;
  for (int n = 0; n < p.face.body.nodes; ++n) {
    const Vector by = mirrored(place_of(p, n)) - place_of(p, node_at(mirrored(rest_of(p, n))));
    off = std::max(off, std::sqrt(dot(by, by)));
  }
  EXPECT_LE(off, 4 * error_of(p));
  EXPECT_LE(off, 1e-8);
  EXPECT_GT(distance_from(in_place, p), 1e-3);
}

// Of the flesh's stress, kappa's part alone has a trace along F: tr P F^T = 3 kappa ln J; of a fibre's, t l. In balance
// the sum of all of these, times volumes, is that of places times bones' forces, whatever flesh is made of. So these
// say by how much the body's volume changes, but for J - 1 - ln J, and for forces that are left at free nodes. Singular
// values are off by 1e-6, of which kappa makes a strain of 3e-6 / 3.
TEST(ProductionFaceStep, AMuscleShortensAndTheBodyKeepsItsVolume) {
  const Scene scene = scene_of("bar_pulls");
  Posed<float> p = posed<float>(scene.body);
  p.target = target_at(scene.body, scene.motion, .25);
  EXPECT_EQ(p.target.activation[0], 1);
  step(p, scene.tolerance);
  double volume = 0, pulls = 0, second_order = 0, stretch = 0, pulling = 0, by_bones = 0, largest = 0;
  const std::vector<Vector> force = forces_on_nodes(p);
  for (const int n : p.face.body.held) by_bones -= dot(force[n], place_of(p, n));
  for (int n = 0; n < p.face.body.nodes; ++n)
    largest = std::max(largest, std::sqrt(dot(place_of(p, n), place_of(p, n))));
  for (int t = 0; t < p.face.body.tetrahedra; ++t) {
    const double v = p.face.body.volume.at(t, 0);
    const Matrix f = strain_of(p, t);
    volume += v * determinant(f), second_order += v * (determinant(f) - 1 - std::log(determinant(f)));
    pulls += v * inner(stress_of(p, t) + (-1.) * stress_of_flesh(p.face.flesh, f), f);
    for (int slot = p.face.body.first_fibre[t / lanes]; slot < p.face.body.first_fibre[t / lanes + 1]; ++slot)
      if (p.face.body.muscle.at(slot * lanes + t % lanes, 0) == 0) {
        stretch += v * std::sqrt(dot(f.x, f.x)), pulling += v;
      }
  }
  const double change = volume / p.face.volume - 1, of_kappa = 3 * p.face.flesh.kappa * p.face.volume;
  const double by_stress = (by_bones - pulls) / p.face.flesh.kappa / 3;
  const double left = std::sqrt(double(p.face.body.nodes)) * p.memory.frame.last * largest;
  std::printf("bar_pulls: the muscle is %.4f of its length, volume %+.2e of it, by stress %+.2e\n", stretch / pulling,
              change, by_stress / p.face.volume);
  EXPECT_LT(stretch / pulling, .95);
  EXPECT_NEAR(change, (by_stress + second_order) / p.face.volume, left / of_kappa + 1e-6);
  EXPECT_LE(std::abs(change), muscle_stress / (3 * p.face.flesh.kappa));
  EXPECT_GT(least_volume(p), .9);
}

// --- Ends of a frame

TEST(ProductionFaceStep, NothingToDoTakesNoStep) {
  Posed<float> p = posed<float>(small_bar());
  EXPECT_EQ(step(p, 1e-6).steps, 0);
  EXPECT_EQ(distance_from(in_place, p), 0);
  Posed<float> moved = brought_in(1, 1e-6);
  const Pose<float> before = moved.pose;
  EXPECT_EQ(step(moved, 1e-6).steps, 0);  // it has come to where rounding ends
  EXPECT_EQ(moved.pose.displacement.x, before.displacement.x);
}

TEST(ProductionFaceStep, BonesMayHoldAllNodes) {
  Posed<float> p =
      posed<float>(held_where(make_body(make_lattice({2, 1, 1}, .005), {}, 0), [](const Vector&) { return true; }));
  const auto to = [](const Vector& x) { return 1.5 * x + Vector{0, .001, 0}; };
  bring_bones(to, p);
  EXPECT_EQ(step(p, 1e-6).steps, 1);
  EXPECT_EQ(p.memory.frame.last, 0);
  EXPECT_LE(distance_from(to, p), 1e-9);
}

// Stiffness is singular then, but what turns and shifts meets no force, so solves need not mind.
TEST(ProductionFaceStep, ABodyMayHaveNoBones) {
  Posed<float> p = posed<float>(small_bar());
  p.face.body.held.clear();
  p = posed<float>(p.face.body);
  p.target.activation = {.6f, .6f};
  const Frame& frame = step(p, 1e-4);
  EXPECT_LE(frame.last, 1e-4 * frame.first);
  EXPECT_GT(least_volume(p), .9);
  Vector middle = {0, 0, 0}, rest = {0, 0, 0};
  for (int n = 0; n < p.face.body.nodes; ++n) middle = middle + place_of(p, n), rest = rest + rest_of(p, n);
  const Vector by = (1. / p.face.body.nodes) * (middle - rest);
  EXPECT_LE(std::sqrt(dot(by, by)), .05 / 128);  // it does not wander off
}

// A bar whose end turns by half a turn at once is torn. The frame ends, and what it leaves is finite.
TEST(ProductionFaceStep, AFrameEndsAfterItsMostSteps) {
  Posed<float> p = posed<float>(small_bar());
  bring_bones([](const Vector& x) { return x.x == 0 ? x : Vector{-x.x, -x.y, x.z}; }, p);
  EXPECT_EQ(step(p, 1e-6).steps, most_steps);
  EXPECT_TRUE(std::isfinite(p.memory.frame.last));
  EXPECT_TRUE(std::isfinite(distance_from(in_place, p)));
}

// --- Slow numbers

// Processors take a hundred cycles and more for a number below 2^-126. At rest, and near it, there are none.
TEST(ProductionFaceStep, RestHasNoDenormals) {
  const Scene scene = scene_of("bar_turns");
  for (const float shake : {0.f, 1e-12f, 1e-8f}) {
    Posed<float> p = posed<float>(scene.body);
    std::mt19937 generator(1);
    for (int n = 0; n < p.face.body.nodes; ++n)
      store(p.pose.displacement, n, shake * convert<float>(random_matrix(generator).x));
    serial::update_state(p.face.body, p.face.flesh, p.pose, true, p.memory.strained);
    serial::forces(p.face.body, p.memory.strained, p.memory.force);
    serial::assemble(p.face.body, p.memory.strained, p.face.pattern, p.memory.k);
    const auto expect_none = [&](const char* name, const Array<float>& values, std::size_t) {
      EXPECT_EQ(std::ranges::count_if(values, [](float x) { return std::fpclassify(x) == FP_SUBNORMAL; }), 0)
          << name << ' ' << shake;
    };
    for_each_array(p.memory.strained, expect_none);
    expect_none("force", p.memory.force, 0), expect_none("k", p.memory.k.value, 0);
  }
}

// Nor are there any on the way to what arrays hold: the state at rest takes no longer than a strained one. The two take
// turns, and a host that takes the core away for a while is waited for: denormals would slow every try down.
TEST(ProductionFaceStep, RestIsNotSlow) {
  const Scene scene = scene_of("bar_turns");
  Posed<float> rest = posed<float>(scene.body), strained = turned_jaw<float>(scene, .3);
  step(strained, 1e-3);
  const auto seconds = [](Posed<float>& p) {
    const auto begin = std::chrono::steady_clock::now();
    serial::update_state(p.face.body, p.face.flesh, p.pose, true, p.memory.strained);
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  double at_rest = 1, elsewhere = 0;
  for (int tries = 0; tries < 6 && at_rest > 1.5 * elsewhere; ++tries) {
    if (tries > 0) std::this_thread::sleep_for(std::chrono::seconds(1));
    at_rest = elsewhere = 1e9;
    for (int run = 0; run < 20; ++run)
      at_rest = std::min(at_rest, seconds(rest)), elsewhere = std::min(elsewhere, seconds(strained));
  }
  EXPECT_LE(at_rest, 1.5 * elsewhere);
  std::printf("a state at rest %.2f ms, strained %.2f ms\n", 1e3 * at_rest, 1e3 * elsewhere);
}

// --- Keys

const Motion motion = {.bones = {{.name = "a", .pivot = {1, 2, 0}}, {.name = "b", .pivot = {}}},
                       .bone_of_held = {0, 1},
                       .keys = {{.time = 0, .activation = {0}, .bones = {{}, {}}},
                                {.time = 2, .activation = {1}, .bones = {{.turn = {0, 0, 2}}, {.shift = {4, 0, 0}}}},
                                {.time = 3, .activation = {.5f}, .bones = {{}, {}}}}};

TEST(ProductionFaceMotion, KeysAreJoinedSmoothly) {
  const auto share = [](double w) { return w * w * (3 - 2 * w); };
  for (const double time : {0., .5, 1., 1.7}) {
    const Key key = key_at(motion, time);
    EXPECT_FLOAT_EQ(key.activation[0], share(time / 2));
    EXPECT_DOUBLE_EQ(key.bones[0].turn.z, 2 * share(time / 2));
    EXPECT_DOUBLE_EQ(key.bones[1].shift.x, 4 * share(time / 2));
  }
  EXPECT_FLOAT_EQ(key_at(motion, 2.5).activation[0], .75f);
  for (const double time : {3., 4., 100.}) {
    EXPECT_EQ(key_at(motion, time).activation[0], .5f);
    EXPECT_EQ(key_at(motion, time).bones[1].shift.x, 0);
  }
}

TEST(ProductionFaceMotion, RepeatsAfterItsLastKey) {
  Motion repeated = motion;
  repeated.repeats = true;
  EXPECT_EQ(key_at(repeated, 3).activation[0], .5f);
  for (const double time : {.5, 1., 2.5}) {
    EXPECT_EQ(key_at(repeated, time + 3).activation, key_at(motion, time).activation);
    EXPECT_EQ(key_at(repeated, time + 9).bones[1].shift.x, key_at(motion, time).bones[1].shift.x);
  }
  repeated.keys.resize(1);
  EXPECT_EQ(key_at(repeated, 5).activation[0], 0);  // one key alone holds
}

// Displacements of float round by 2^-24 of themselves.
TEST(ProductionFaceMotion, BonesTurnAboutTheirPivots) {
  Body<float> body = make_body({{{0, 2, 0}, {1, 2, 3}, {2, 2, 0}, {1, 3, 0}}, {{0, 3, 2, 1}}}, {}, 1);
  body.held = {0, 1};
  for (const double time : {1., 2., 3.}) {
    const Target<float> target = target_at(body, motion, time);
    const double angle = key_at(motion, time).bones[0].turn.z;
    EXPECT_FLOAT_EQ(target.held.x[0], 1 - std::cos(angle));
    EXPECT_FLOAT_EQ(target.held.y[0], -std::sin(angle));
    EXPECT_EQ(target.held.z[0], 0);
    EXPECT_FLOAT_EQ(target.held.x[1], key_at(motion, time).bones[1].shift.x);
    EXPECT_EQ(target.held.y[1], 0);
    EXPECT_EQ(target.activation[0], key_at(motion, time).activation[0]);
  }
}

}  // namespace
}  // namespace lockstep::production_face
