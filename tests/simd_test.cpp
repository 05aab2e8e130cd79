// common/simd.h against scalar code, lane by lane. What it asserts, of the one back end it is built for:
//
// - every operation gives the bits of the scalar expression that simd.h promises, on special and on random values
// - reductions follow the documented tree, so that all back ends agree
//
// An operation is written once, as a generic lambda: applied to floatv it is what is tested, applied to float it is
// the reference. Lanes and memory: simd_memory_test.cpp.

#include "common/simd.h"

#include <gtest/gtest.h>

#include <functional>
#include <set>
#include <tuple>

#include "tests/simd_values.h"

namespace lockstep {
namespace {

// The scalar counterparts, with the names that the lambdas below use.
float min(float a, float b) { return a < b ? a : b; }
float max(float a, float b) { return a > b ? a : b; }
std::int32_t min(std::int32_t a, std::int32_t b) { return a < b ? a : b; }
std::int32_t max(std::int32_t a, std::int32_t b) { return a > b ? a : b; }
float abs(float a) { return std::fabs(a); }
float sqrt(float a) { return std::sqrt(a); }
float fma(float a, float b, float c) { return std::fma(a, b, c); }
std::int32_t to_int(float a) { return a >= -0x1p31f && a < 0x1p31f ? static_cast<std::int32_t>(a) : INT32_MIN; }
float to_float(std::int32_t a) { return static_cast<float>(a); }
std::int32_t bits_of(float a) { return std::bit_cast<std::int32_t>(a); }
float float_of_bits(std::int32_t a) { return std::bit_cast<float>(a); }

// wide(a, ...) on vectors against narrow(a[l], ...) on each lane, for as many arguments as there are types.
template <class... Array, class Wide, class Narrow>
void check(Nan nan, Wide wide, Narrow narrow) {
  Random random;
  for (int t = 0; t < trials; ++t) {
    const std::tuple<Array...> arguments{random.fill<Array>()...};
    std::apply(
        [&](const auto&... a) {
          ASSERT_TRUE(lanes_are(
              wide(load(a)...), [&](int l) { return narrow(a[l]...); }, nan));
        },
        arguments);
    if (testing::Test::HasFatalFailure()) return;
  }
}
template <class... Array, class Op>
void check(Nan nan, Op op) {
  check<Array...>(nan, op, op);
}

TEST(Simd, BuiltForTheInstructionSetAskedFor) {
  EXPECT_EQ(lanes, 16);
#if defined(LOCKSTEP_ISA_AVX512)
  EXPECT_STREQ(isa_name, "avx512");
#elif defined(LOCKSTEP_ISA_AVX2)
  EXPECT_STREQ(isa_name, "avx2");
#else
  EXPECT_STREQ(isa_name, "portable");
#endif
}

TEST(Simd, FloatArithmetic) {
  check<Floats, Floats>(Nan::computed, [](auto a, auto b) { return a + b; });
  check<Floats, Floats>(Nan::computed, [](auto a, auto b) { return a - b; });
  check<Floats, Floats>(Nan::computed, [](auto a, auto b) { return a * b; });
  check<Floats, Floats>(Nan::computed, [](auto a, auto b) { return a / b; });
  check<Floats, Floats, Floats>(Nan::computed, [](auto a, auto b, auto c) { return fma(a, b, c); });
  check<Floats, Floats, Floats>(Nan::computed, [](auto a, auto b, auto c) { return a * b + c; });  // two roundings
  check<Floats>(Nan::computed, [](auto a) { return sqrt(a); });
  check<Floats>(Nan::copied, [](auto a) { return -a; });
  check<Floats>(Nan::copied, [](auto a) { return abs(a); });
  check<Floats, Floats>(Nan::copied, [](auto a, auto b) { return min(a, b); });
  check<Floats, Floats>(Nan::copied, [](auto a, auto b) { return max(a, b); });
  check<Floats>(Nan::copied, [](auto a) { return max(min(a, 1.0f), 0.0f); });  // with broadcast constants
  check<Floats>(Nan::copied, [](auto a) { return max(0.0f, min(1.0f, a)); });
  check<Floats>(Nan::copied, [](auto a) { return to_int(a); });
  check<Floats>(Nan::copied, [](auto a) { return bits_of(a); });
  check<Ints>(Nan::copied, [](auto a) { return float_of_bits(a); });
}

TEST(Simd, IntArithmetic) {
  using T = std::int32_t;
  constexpr auto wide = [](T a) { return std::int64_t{a}; };
  check<Ints, Ints>(Nan::copied, std::plus<>(), [&](T a, T b) { return static_cast<T>(wide(a) + b); });
  check<Ints, Ints>(Nan::copied, std::minus<>(), [&](T a, T b) { return static_cast<T>(wide(a) - b); });
  check<Ints, Ints>(Nan::copied, std::multiplies<>(), [&](T a, T b) { return static_cast<T>(wide(a) * b); });
  check<Ints, Ints>(Nan::copied, [](auto a, auto b) { return a & b; });
  check<Ints, Ints>(Nan::copied, [](auto a, auto b) { return a | b; });
  check<Ints, Ints>(Nan::copied, [](auto a, auto b) { return a ^ b; });
  check<Ints, Ints>(Nan::copied, [](auto a, auto n) { return a << (n & 31); });
  check<Ints, Ints>(Nan::copied, [](auto a, auto n) { return a >> (n & 31); });
  check<Ints>(Nan::copied, [](auto a) { return a << 3 | a >> 29; });
  check<Ints, Ints>(Nan::copied, [](auto a, auto b) { return min(a, b); });
  check<Ints, Ints>(Nan::copied, [](auto a, auto b) { return max(a, b); });
  check<Ints>(Nan::copied, [](auto a) { return to_float(a); });
}

template <class Array>
void check_comparisons() {
  check<Array, Array>(Nan::copied, [](auto a, auto b) { return a < b; });
  check<Array, Array>(Nan::copied, [](auto a, auto b) { return a <= b; });
  check<Array, Array>(Nan::copied, [](auto a, auto b) { return a > b; });
  check<Array, Array>(Nan::copied, [](auto a, auto b) { return a >= b; });
  check<Array, Array>(Nan::copied, [](auto a, auto b) { return a == b; });
  check<Array, Array>(Nan::copied, [](auto a, auto b) { return a != b; });
  check<Array>(Nan::copied, [](auto a) { return a <= 1; });  // with a broadcast constant
}
TEST(Simd, Comparisons) {
  check_comparisons<Floats>();
  check_comparisons<Ints>();
}

TEST(Simd, Masks) {
  EXPECT_TRUE(lanes_are(lane_index(), [](int l) { return l; }));
  for (int n : {INT_MIN, -1, lanes + 1, INT_MAX}) EXPECT_EQ(bits(first_lanes(n)), n < 0 ? 0u : 0xffffu);
  for (int n = 0; n <= lanes; ++n) EXPECT_EQ(bits(first_lanes(n)), (1u << n) - 1);

  Random random;
  for (std::uint32_t m = 0; m <= 0xffff; ++m) {
    const std::uint32_t other = random.bits() & 0xffff;
    const maskv a = mask_of(m), b = mask_of(other);
    ASSERT_EQ(bits(a), m);
    ASSERT_EQ(any(a), m != 0);
    ASSERT_EQ(all(a), m == 0xffff);
    ASSERT_EQ(none(a), m == 0);
    ASSERT_EQ(count(a), std::popcount(m));
    ASSERT_EQ(bits(a & b), (m & other));
    ASSERT_EQ(bits(a | b), (m | other));
    ASSERT_EQ(bits(a ^ b), (m ^ other));
    ASSERT_EQ(bits(~a), (~m & 0xffff));
    ASSERT_EQ(none(~a), all(a));
  }
}

// `change` changes its first argument: on its own, on a mask through where(), and on a scalar.
template <class Array, class Change>
void check_assignment(Change change) {
  const auto changed = [&](auto a, auto b) {
    change(a, b);
    return a;
  };
  check<Array, Array>(Nan::computed, changed);
  check<Array, Array, Ints>(
      Nan::computed,
      [&](auto a, auto b, intv chosen) {
        change(where(chosen > 0, a), b);
        return a;
      },
      [&](auto a, auto b, std::int32_t chosen) { return chosen > 0 ? changed(a, b) : a; });
}

TEST(Simd, CompoundAndMaskedAssignment) {
  check_assignment<Floats>([](auto&& a, auto b) { a = b; });
  check_assignment<Floats>([](auto&& a, auto b) { a += b; });
  check_assignment<Floats>([](auto&& a, auto b) { a -= b; });
  check_assignment<Floats>([](auto&& a, auto b) { a *= b; });
  check_assignment<Floats>([](auto&& a, auto b) { a /= b; });
  check_assignment<Floats>([](auto&& a, auto) { a += 1.0f; });
  check_assignment<Ints>([](auto&& a, auto b) { a = b; });
  check_assignment<Ints>([](auto&& a, auto b) { a &= b; });
  check_assignment<Ints>([](auto&& a, auto b) { a |= b; });
  check_assignment<Ints>([](auto&& a, auto b) { a ^= b; });
  check_assignment<Ints>([](auto&& a, auto b) { a <<= b & 31; });
  check_assignment<Ints>([](auto&& a, auto b) { a >>= b & 31; });

  // Signed scalars may not wrap around, so these three start from small ones.
  check_assignment<Ints>([](auto&& a, auto b) { a = b & 0xff, a += 7; });
  check_assignment<Ints>([](auto&& a, auto b) { a = b & 0xff, a -= 7; });
  check_assignment<Ints>([](auto&& a, auto b) { a = b & 0xff, a *= 7; });

  maskv mask = first_lanes(5);
  mask |= first_lanes(9);
  mask &= ~first_lanes(2);
  mask ^= first_lanes(3);
  EXPECT_EQ(bits(mask), 0x1fbu);
}

// The documented tree, on scalars.
template <class Array, class Combine>
auto tree(Array a, Combine combine) {
  for (int half = lanes / 2; half > 0; half /= 2)
    for (int l = 0; l < half; ++l) a[l] = combine(a[l], a[l + half]);
  return a[0];
}

TEST(Simd, ReductionsFollowTheTree) {
  Random random;
  for (int t = 0; t < 10 * trials; ++t) {
    Floats a = random;
    if (t % 2)  // finite sums, whose bits tell one order from another
      for (float& x : a) x = std::uniform_real_distribution<float>(-1, 1)(random.engine);
    ASSERT_TRUE(same(reduce_add(load(a)), tree(a, std::plus<>()), Nan::computed));
    ASSERT_TRUE(same(reduce_min(load(a)), tree(a, [](float x, float y) { return min(x, y); }), Nan::copied));
    ASSERT_TRUE(same(reduce_max(load(a)), tree(a, [](float x, float y) { return max(x, y); }), Nan::copied));

    const Ints i = random;
    std::uint32_t sum = 0;
    for (std::int32_t x : i) sum += static_cast<std::uint32_t>(x);
    ASSERT_EQ(reduce_add(load(i)), static_cast<std::int32_t>(sum));
  }
}

// The low four bits of an index count.
TEST(Simd, Permutes) {
  const floatv v = to_float(lane_index());
  for (int shift = -40; shift < 40; ++shift) {
    const floatv permuted = permute(v, 7 * lane_index() + shift);
    for (int l = 0; l < lanes; ++l) EXPECT_EQ(values(permuted)[l], (7 * l + shift) & 15);
  }
}

TEST(Simd, ShiftsByOneLane) {
  const floatv v = to_float(lane_index());
  for (int l = 0; l < lanes; ++l) {
    EXPECT_EQ(values(shift_up(v, -7.f))[l], l > 0 ? l - 1 : -7);
    EXPECT_EQ(values(shift_down(v, -7.f))[l], l + 1 < lanes ? l + 1 : -7);
  }
}

TEST(Simd, MasksFromBits) {
  for (std::uint32_t mask = 0; mask < 0x10000; mask += 37) ASSERT_EQ(bits(lanes_of(mask)), mask);
}

TEST(Simd, Transposes) {
  floatv row[lanes];
  for (int i = 0; i < lanes; ++i) row[i] = to_float(lane_index() + lanes * i);
  transpose(row);
  for (int i = 0; i < lanes; ++i)
    for (int j = 0; j < lanes; ++j) ASSERT_EQ(values(row[i])[j], lanes * j + i);
}

template <int G>
void splits_and_joins() {
  float row[2 * lanes];
  for (int k = 0; k < 2 * lanes; ++k) row[k] = static_cast<float>(k);
  const Halves halves = split<G>(lockstep::load(row), lockstep::load(row + lanes));
  std::set<float> seen;
  for (int l = 0; l < lanes; ++l) {
    const float first = values(halves.first)[l];
    EXPECT_EQ(static_cast<int>(first) % (2 * G) / G, 0);
    EXPECT_EQ(values(halves.second)[l], first + G);
    seen.insert(first);
  }
  EXPECT_EQ(seen.size(), std::size_t(lanes));
  floatv a, b;
  join<G>(halves, a, b);
  for (int l = 0; l < lanes; ++l) {
    EXPECT_EQ(values(a)[l], l);
    EXPECT_EQ(values(b)[l], l + lanes);
  }
}

TEST(Simd, SplitsNeighbours) { splits_and_joins<1>(); }
TEST(Simd, SplitsPairs) { splits_and_joins<2>(); }

}  // namespace
}  // namespace lockstep
