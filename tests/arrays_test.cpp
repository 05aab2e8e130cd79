// The list of a state's arrays, and what follows from it.
#include "verify/arrays.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "verify/inputs.h"
#include "verify/twin.h"

namespace lockstep::arrays_test {

// A record of which the second number is there where `count` says so.
template <class Real>
struct Touch {
  std::int32_t count;
  Vector3<Real> normal;
  Real depth;
  Real unused;
};
template <Is<Touch> T, class F>
void for_each_field(T& touch, const F& f) {
  f("count", touch.count);
  f("normal.x", touch.normal.x), f("normal.y", touch.normal.y), f("normal.z", touch.normal.z);
  if (touch.count > 0) f("depth", touch.depth);
}

template <class Real>
struct State {
  int count = 0;
  Array<std::int32_t> id;
  Vectors<Real> position;
  Array<Touch<Real>> touches;
};
template <Is<State> S, class F>
void for_each_array(S& s, const F& f) {
  f("id", s.id, s.count);
  f("position", s.position, s.count);
  f("touch", s.touches, s.touches.size());
}

namespace {

using verify::bitwise;
using verify::Judgement;

State<float> some_state() {
  State<float> s{.count = 2, .id = {}, .position = {}, .touches = {}};
  s.id.resize(padded(2)), s.position.resize(2);
  s.id[1] = 7;
  s.position.y[1] = 2.5f;
  s.touches = {{1, {0, 1, 0}, .25f, 9}, {0, {0, 0, 1}, 0, 0}};
  return s;
}

TEST(Arrays, EqualStatesAreEqual) {
  const Judgement judgement = bitwise(some_state(), some_state());
  EXPECT_TRUE(judgement.passed);
  EXPECT_EQ(judgement.worst_at, "");
  EXPECT_EQ(verify::hash_of(some_state()), verify::hash_of(some_state()));
}

TEST(Arrays, ADifferenceIsNamedWithBothValues) {
  const auto difference = [](auto change) {
    State<float> changed = some_state();
    change(changed);
    EXPECT_NE(verify::hash_of(changed), verify::hash_of(some_state()));
    const Judgement judgement = bitwise(changed, some_state());
    EXPECT_FALSE(judgement.passed);
    return judgement.worst_at;
  };
  EXPECT_EQ(difference([](auto& s) { s.id[1] = 8; }), "id[1]: openmp 8, serial 7");
  EXPECT_EQ(difference([](auto& s) { s.position.y[1] = 3; }), "position[1].y: openmp 3, serial 2.5");
  EXPECT_EQ(difference([](auto& s) { s.touches[0].normal.y = 0; }), "touch[0].normal.y: openmp 0, serial 1");
  EXPECT_EQ(difference([](auto& s) { s.touches[0].depth = .5f; }), "touch[0].depth: openmp 0.5, serial 0.25");
  EXPECT_EQ(difference([](auto& s) { s.touches.pop_back(); }), "size of touch: openmp 1, serial 2");
  EXPECT_EQ(difference([](auto& s) { s.position.x[0] = -0.f; }), "position[0].x: openmp -0, serial 0");
}

TEST(Arrays, DifferencesAreCounted) {
  State<float> changed = some_state();
  changed.id[0] = 3, changed.position.z[1] = 1, changed.touches[1].count = 0;
  EXPECT_EQ(bitwise(changed, some_state()).error, 2);
}

TEST(Arrays, FieldsThatAreNotThereAndPaddingDoNotCount) {
  State<float> changed = some_state();
  changed.id[2] = 99;              // padding
  changed.touches[0].unused = -1;  // no field
  changed.touches[1].depth = 4;    // not there: count is 0
  EXPECT_TRUE(bitwise(changed, some_state()).passed);
  EXPECT_EQ(verify::hash_of(changed), verify::hash_of(some_state()));
}

TEST(Arrays, ElementsHaveNames) {
  State<float> changed = some_state();
  changed.position.y[1] = 3;
  EXPECT_EQ(bitwise(changed, some_state(), verify::of_element("particle")).worst_at,
            "position.y of particle 1: openmp 3, serial 2.5");
}

TEST(Arrays, PoisonLeavesNoNumber) {
  State<float> s = some_state();
  verify::poison(s);
  EXPECT_EQ(s.id[1], -1);
  EXPECT_TRUE(std::isnan(s.position.x[0]));
  EXPECT_TRUE(std::isnan(s.position.x.back()));
  EXPECT_EQ(s.touches[0].count, -1);
}

TEST(Arrays, TheFirstNumberThatIsNotFiniteIsNamed) {
  EXPECT_EQ(verify::first_not_finite(some_state()), "");
  for (const float wrong : {std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()}) {
    State<float> s = some_state();
    s.position.z[1] = wrong, s.touches[0].depth = wrong;
    EXPECT_EQ(verify::first_not_finite(s), "position[1].z is not finite");
  }
}

TEST(Arrays, KeepsWhatARunNeeds) {
  State<float> s = some_state(), other;
  const auto kept = verify::keep_all(s), of_other = verify::keep_all(other);
  ASSERT_EQ(kept.size(), of_other.size());
  for (std::size_t k = 0; k < kept.size(); ++k) {
    const auto bytes = kept[k].bytes();
    std::ranges::copy(bytes, of_other[k].room(bytes.size()).begin());
  }
  other.count = s.count;
  EXPECT_TRUE(bitwise(other, s).passed);
}

TEST(Arrays, WideningIsExactAndComesBack) {
  State<float> s = some_state(), back;
  s.touches.pop_back();  // all records list the same fields
  State<double> wide;
  convert_arrays<double>(s, wide);
  EXPECT_EQ(wide.position.y[1], 2.5);
  EXPECT_EQ(wide.touches[0].depth, .25);
  EXPECT_EQ(wide.id, s.id);
  convert_arrays<float>(wide, back);
  back.count = s.count;
  EXPECT_TRUE(bitwise(back, s).passed);
}

TEST(Arrays, BytesAreWhatTheArraysHold) {
  State<float> s;
  EXPECT_EQ(bytes_of(s), 0);
  s.id.reserve(100);
  EXPECT_EQ(bytes_of(s), 400);
}

// --- The case that one builder makes

TEST(TwinCase, ComparesWithTheSerialForm) {
  verify::Twin<State<float>> twin;
  twin.start = std::make_shared<const State<float>>(some_state());
  twin.serial = [](State<float>& s) { s.position.x[0] += 1; };
  twin.openmp = [](State<float>& s) { s.position.x[0] += 1; };
  const verify::Case same = verify::make_case(twin);
  same.reset(), same.openmp();
  EXPECT_TRUE(same.judge().passed);

  twin.openmp = [](State<float>& s) { s.position.x[0] += 2; };
  const verify::Case other = verify::make_case(twin);
  other.reset(), other.openmp();
  EXPECT_EQ(other.judge().worst_at, "position[0].x: openmp 2, serial 1");
  EXPECT_NE(other.hash(), same.hash());
}

TEST(TwinCase, ResetsToTheStart) {
  verify::Twin<State<float>> twin;
  twin.start = std::make_shared<const State<float>>(some_state());
  twin.serial = twin.openmp = [](State<float>& s) { s.position.x[0] += 1; };
  const verify::Case run = verify::make_case(twin);
  for (int repeat = 0; repeat < 3; ++repeat) {
    run.reset(), run.openmp();
    EXPECT_TRUE(run.judge().passed);
  }
  run.openmp();  // from where the last run ended
  EXPECT_FALSE(run.judge().passed);
}

// --- Inputs

struct Big {
  double bytes;
};
double bytes_of(const Big& big) { return big.bytes; }

TEST(Inputs, AreMadeOnceAndDroppedByTheBudget) {
  int made = 0;
  const auto ask = [&](const std::string& key, double bytes) {
    return verify::inputs<Big>(key, [&] { return ++made, Big{bytes}; });
  };
  const double half = verify::inputs_budget * .6;
  ask("a", half), ask("a", half);
  EXPECT_EQ(made, 1);
  const auto held = ask("b", half);  // both do not fit
  EXPECT_EQ(made, 2);
  ask("b", half);
  EXPECT_EQ(made, 2);
  ask("a", half);
  EXPECT_EQ(made, 3);
  EXPECT_EQ(held->bytes, half) << "whoever uses it keeps it alive";
  ask("larger than all", 2 * verify::inputs_budget), ask("larger than all", 0);
  EXPECT_EQ(made, 4) << "the last one is kept, however large";
}

}  // namespace
}  // namespace lockstep::arrays_test
