// common/simd.h against scalar code, lane by lane. What it asserts, of the one back end it is built for:
//
// - every operation gives the bits of the scalar expression that simd.h promises, on special and on random values
// - masked memory operations act on active lanes only, and do not touch the memory of inactive ones: it is a page
//   that may not be accessed
// - reductions follow the documented tree, so that all back ends agree
//
// An operation is written once, as a generic lambda: applied to floatv it is what is tested, applied to float it is
// the reference.

#include "common/simd.h"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cfloat>
#include <climits>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <set>
#include <vector>

using namespace lockstep;

namespace {

using Floats = std::array<float, lanes>;
using Ints = std::array<std::int32_t, lanes>;

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

// Test values: every special one meets every other sooner or later, and random bits reach all exponents.
constexpr float inf = std::numeric_limits<float>::infinity();
constexpr float nan = std::numeric_limits<float>::quiet_NaN();
constexpr float denormal = std::numeric_limits<float>::denorm_min();
constexpr float special_floats[] = {
    0,       -0.0f,   denormal,       -denormal, FLT_MIN / 2,     FLT_MIN, -FLT_MIN, 1e-20f,   0.5f, 1,    -1,  -1.5f, 3,
    0x1p23f, 0x1p31f, 0x1.fffffep30f, -0x1p31f,  -0x1.000002p31f, 0x1p64f, FLT_MAX,  -FLT_MAX, inf,  -inf, nan, -nan};
constexpr std::int32_t special_ints[] = {0, 1, -1, 2, 31, 32, 65535, 65536, 0x7fffff, 0x1000001, INT_MAX, INT_MIN, INT_MIN + 1};

struct Random {
  std::mt19937 engine{1};

  std::uint32_t bits() { return static_cast<std::uint32_t>(engine()); }
  int below(int n) { return static_cast<int>(bits() % static_cast<std::uint32_t>(n)); }
  operator float() {
    switch (below(3)) {
      case 0: return special_floats[below(std::size(special_floats))];
      case 1: return std::bit_cast<float>(bits());
      default: return std::uniform_real_distribution<float>(-10, 10)(engine);
    }
  }
  operator std::int32_t() { return below(2) ? special_ints[below(std::size(special_ints))] : static_cast<std::int32_t>(bits()); }
  operator Floats() { return fill<Floats>(); }
  operator Ints() { return fill<Ints>(); }

  template <class Array>
  Array fill() {
    Array a;
    for (auto& x : a) x = *this;
    return a;
  }
  Ints ints_below(int n) {
    Ints a;
    for (auto& x : a) x = below(n);
    return a;
  }
};

floatv load(const Floats& a) { return lockstep::load(a.data()); }
intv load(const Ints& a) { return lockstep::load(a.data()); }

maskv mask_of(std::uint32_t b) { return (intv(static_cast<std::int32_t>(b)) >> lane_index() & 1) != 0; }
bool active(std::uint32_t mask, int l) { return mask >> l & 1; }

// Lane l of a result.
Floats values(floatv v) {
  Floats a;
  store(a.data(), v);
  return a;
}
Ints values(intv v) {
  Ints a;
  store(a.data(), v);
  return a;
}
std::array<bool, lanes> values(maskv m) {
  std::array<bool, lanes> a;
  for (int l = 0; l < lanes; ++l) a[l] = active(bits(m), l);
  return a;
}

// Same bits; where an operation computes rather than copies, any NaN will do for a NaN.
enum class Nan { computed, copied };
bool same(float a, float b, Nan nan) {
  return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b) || (nan == Nan::computed && std::isnan(a) && std::isnan(b));
}
bool same(std::int32_t a, std::int32_t b, Nan) { return a == b; }
bool same(bool a, bool b, Nan) { return a == b; }

// expected(l) is the scalar result of lane l.
template <class V, class Expected>
testing::AssertionResult lanes_are(V v, Expected expected, Nan nan = Nan::copied) {
  const auto got = values(v);
  for (int l = 0; l < lanes; ++l)
    if (!same(got[l], expected(l), nan))
      return testing::AssertionFailure() << "lane " << l << ": " << got[l] << " instead of " << expected(l);
  return testing::AssertionSuccess();
}

constexpr int trials = 3000;

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

// One page of T that may be accessed, between two that may not.
template <class T>
class GuardedPage {
 public:
  GuardedPage() {
    void* pages = mmap(nullptr, 3 * bytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (pages == MAP_FAILED) throw std::bad_alloc();
    first = reinterpret_cast<T*>(static_cast<char*>(pages) + bytes);
    if (mprotect(first, bytes, PROT_READ | PROT_WRITE) != 0) throw std::bad_alloc();
  }
  ~GuardedPage() { munmap(reinterpret_cast<char*>(first) - bytes, 3 * bytes); }
  GuardedPage(const GuardedPage&) = delete;

  T* begin() const { return first; }
  T* end() const { return first + size(); }
  int size() const { return static_cast<int>(bytes / sizeof(T)); }

 private:
  const std::size_t bytes = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  T* first;
};

// Calls body(p, mask) with every way in which sixteen lanes at p can hang over either end of the page, and masks
// that are active on the page only: all of it, or a random part.
template <class T, class Body>
void at_the_edges(const GuardedPage<T>& page, Body body) {
  Random random;
  for (int n = 0; n <= lanes; ++n)
    for (int t = 0; t < 20; ++t) {
      const std::uint32_t some = t == 0 ? 0xffff : random.bits() & 0xffff;
      body(page.end() - n, bits(first_lanes(n)) & some);
      body(page.begin() - (lanes - n), ~bits(first_lanes(lanes - n)) & some);
    }
}

template <class Array>
class SimdMemory : public testing::Test {};
using Arrays = testing::Types<Floats, Ints>;
TYPED_TEST_SUITE(SimdMemory, Arrays);

TYPED_TEST(SimdMemory, LoadAndStoreAtAnyAlignment) {
  Random random;
  alignas(64) std::array<typename TypeParam::value_type, 3 * lanes> memory;
  for (int offset = 0; offset < lanes; ++offset) {
    for (auto& x : memory) x = random;
    EXPECT_TRUE(lanes_are(lockstep::load(&memory[offset]), [&](int l) { return memory[offset + l]; }));

    auto expected = memory;
    const TypeParam a = random;
    std::copy(a.begin(), a.end(), &expected[offset]);
    store(&memory[offset], load(a));
    for (std::size_t i = 0; i < memory.size(); ++i) EXPECT_TRUE(same(memory[i], expected[i], Nan::copied));
  }
}

TYPED_TEST(SimdMemory, MaskedLoadTouchesActiveLanesOnly) {
  using T = typename TypeParam::value_type;
  Random random;
  const GuardedPage<T> page;
  for (T& x : page) x = random;
  at_the_edges(page, [&](const T* p, std::uint32_t mask) {
    EXPECT_TRUE(lanes_are(lockstep::load(p, mask_of(mask)), [&](int l) { return active(mask, l) ? p[l] : T(0); }));
  });
}

TYPED_TEST(SimdMemory, MaskedStoreTouchesActiveLanesOnly) {
  using T = typename TypeParam::value_type;
  Random random;
  const GuardedPage<T> page;
  at_the_edges(page, [&](T* p, std::uint32_t mask) {
    const TypeParam before = random, a = random;
    const auto on_page = [&](int l) { return p + l >= page.begin() && p + l < page.end(); };
    for (int l = 0; l < lanes; ++l)
      if (on_page(l)) p[l] = before[l];
    store(p, load(a), mask_of(mask));
    for (int l = 0; l < lanes; ++l)
      if (on_page(l)) {
        EXPECT_TRUE(same(p[l], active(mask, l) ? a[l] : before[l], Nan::copied));
      }
  });
}

// Indices of active lanes lie on the page, of inactive ones before it, behind it, or nowhere.
Ints indices_on_page(Random& random, int size, std::uint32_t mask) {
  Ints index = random.ints_below(size);
  const std::int32_t elsewhere[] = {-1, size, INT_MIN, INT_MAX};
  for (int l = 0; l < lanes; ++l)
    if (!active(mask, l)) index[l] = elsewhere[random.below(4)];
  return index;
}

TYPED_TEST(SimdMemory, GatherTouchesActiveLanesOnly) {
  using T = typename TypeParam::value_type;
  Random random;
  const GuardedPage<T> page;
  for (T& x : page) x = random;
  T* const middle = page.begin() + page.size() / 2;
  for (int t = 0; t < trials; ++t) {
    const std::uint32_t mask = random.bits() & 0xffff;
    const Ints index = indices_on_page(random, page.size(), mask);
    ASSERT_TRUE(lanes_are(gather(page.begin(), load(index), mask_of(mask)),
                          [&](int l) { return active(mask, l) ? page.begin()[index[l]] : T(0); }));

    const Ints either_side = values(load(random.ints_below(page.size())) - page.size() / 2);
    ASSERT_TRUE(lanes_are(gather(middle, load(either_side)), [&](int l) { return middle[either_side[l]]; }));
  }
}

TYPED_TEST(SimdMemory, CompressMovesActiveLanesToTheFront) {
  using T = typename TypeParam::value_type;
  Random random;
  for (std::uint32_t mask = 0; mask <= 0xffff; ++mask) {
    const TypeParam a = random;
    TypeParam expected{};
    int n = 0;
    for (int l = 0; l < lanes; ++l)
      if (active(mask, l)) expected[n++] = a[l];
    ASSERT_TRUE(lanes_are(compress(mask_of(mask), load(a)), [&](int l) -> T { return expected[l]; })) << mask;
  }
}

TYPED_TEST(SimdMemory, SelectAndBroadcast) {
  using T = typename TypeParam::value_type;
  Random random;
  for (int t = 0; t < trials; ++t) {
    const std::uint32_t mask = random.bits() & 0xffff;
    const TypeParam a = random, b = random;
    ASSERT_TRUE(lanes_are(select(mask_of(mask), load(a), load(b)), [&](int l) { return active(mask, l) ? a[l] : b[l]; }));
    ASSERT_TRUE(lanes_are(decltype(load(a))(a[0]), [&](int) -> T { return a[0]; }));
  }
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

TEST(Simd, LoadsWholeRecords) {
  constexpr int records = 40;
  alignas(32) float base[8 * records];
  for (int k = 0; k < 8 * records; ++k) base[k] = static_cast<float>(k);
  std::mt19937 random(7);
  for (int repeat = 0; repeat < 100; ++repeat) {
    Ints index;
    for (std::int32_t& i : index) i = static_cast<std::int32_t>(random() % records);
    const Records r = load_records(base, index.data());
    for (int f = 0; f < 8; ++f)
      for (int l = 0; l < lanes; ++l) ASSERT_EQ(values(r.field[f])[l], base[8 * index[l] + f]);
  }
}

TEST(Simd, StoresWholeRecords) {
  constexpr int records = 40;
  alignas(32) float base[8 * records];
  Records r;
  for (int f = 0; f < 8; ++f) r.field[f] = to_float(lane_index() * 8 + f);
  std::mt19937 random(13);
  std::vector<std::int32_t> index(records);
  for (int k = 0; k < records; ++k) index[k] = k;
  for (int repeat = 0; repeat < 100; ++repeat) {
    std::shuffle(index.begin(), index.end(), random);
    std::fill_n(base, 8 * records, -1.f);
    store_records(base, index.data(), r);
    for (int k = 0; k < records; ++k)
      for (int f = 0; f < 8; ++f) ASSERT_EQ(base[8 * index[k] + f], k < lanes ? 8 * k + f : -1);
    const std::uint32_t some = random() & 0xffff;
    std::fill_n(base, 8 * records, -1.f);
    store_records(base, index.data(), r, lanes_of(some));
    for (int k = 0; k < records; ++k)
      for (int f = 0; f < 8; ++f) ASSERT_EQ(base[8 * index[k] + f], k < lanes && some >> k & 1 ? 8 * k + f : -1);
  }
}

TEST(Simd, RecordsOneByOne) {
  alignas(32) const float a[8] = {1, 2, 3, 4, 5, 6, 7, 8}, b[8] = {.5f, -1, 2, 0, 7, .25f, -3, 9};
  alignas(32) float out[8];
  const auto check = [&](recordv r, auto expected) {
    store_record(out, r);
    for (int f = 0; f < 8; ++f) EXPECT_EQ(out[f], expected(f)) << f;
  };
  check(load_record(a) + load_record(b), [&](int f) { return a[f] + b[f]; });
  check(load_record(a) - load_record(b), [&](int f) { return a[f] - b[f]; });
  check(load_record(a) * load_record(b), [&](int f) { return a[f] * b[f]; });
  check(repeat_pair(b + 1), [&](int f) { return b[1 + f % 2]; });
  check(recordv(3.f), [](int) { return 3.f; });
  float pairs[2 * lanes];
  store_pairs(pairs, to_float(lane_index()), to_float(lane_index() + 100));
  for (int l = 0; l < lanes; ++l) {
    EXPECT_EQ(pairs[2 * l], l);
    EXPECT_EQ(pairs[2 * l + 1], l + 100);
  }
}

TEST(Simd, LoadsAndStoresQuads) {
  constexpr int records = 40;
  alignas(16) float base[4 * records], target[4 * records];
  for (int k = 0; k < 4 * records; ++k) base[k] = static_cast<float>(k);
  std::mt19937 random(11);
  std::vector<std::int32_t> index(records);
  for (int k = 0; k < records; ++k) index[k] = k;
  for (int repeat = 0; repeat < 100; ++repeat) {
    std::shuffle(index.begin(), index.end(), random);
    const Quads q = load_quads(base, index.data());
    for (int f = 0; f < 4; ++f)
      for (int l = 0; l < lanes; ++l) ASSERT_EQ(values(q.field[f])[l], base[4 * index[l] + f]);
    const std::uint32_t mask = random() & 0xffff;
    std::fill_n(target, 4 * records, -1.f);
    store_quads(target, index.data(), q, mask_of(mask));
    for (int k = 0; k < records; ++k)
      for (int f = 0; f < 4; ++f) ASSERT_EQ(target[4 * index[k] + f], k < lanes && active(mask, k) ? base[4 * index[k] + f] : -1.f) << mask;
  }
}

// Pairs may begin at any float, and the outermost reach the ends of the page.
TEST(Simd, GathersPairsOfNeighbours) {
  Random random;
  const GuardedPage<float> page;
  for (float& x : page) x = random;
  float* const middle = page.begin() + page.size() / 2;
  for (int t = 0; t < trials; ++t) {
    Ints index = values(load(random.ints_below(page.size() - 1)) - page.size() / 2);
    index[random.below(lanes)] = -page.size() / 2;
    index[random.below(lanes)] = page.size() - page.size() / 2 - 2;
    const Halves pairs = gather_pairs(middle, load(index));
    ASSERT_TRUE(lanes_are(pairs.first, [&](int l) { return middle[index[l]]; }));
    ASSERT_TRUE(lanes_are(pairs.second, [&](int l) { return middle[index[l] + 1]; }));
  }
}

// Address space for records that begin at 2^33 bytes, and as much before them, where a product that wraps around in 32 bits would
// lead. Only one page is there on either side.
class FarRecords {
 public:
  FarRecords() {
    void* space = mmap(nullptr, 2 * distance + page, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (space == MAP_FAILED) throw std::bad_alloc();
    begin = static_cast<char*>(space) + distance;
    for (char* p : {begin - distance, begin + distance})
      if (mprotect(p, page, PROT_READ | PROT_WRITE) != 0) throw std::bad_alloc();
  }
  ~FarRecords() { munmap(begin - distance, 2 * distance + page); }
  FarRecords(const FarRecords&) = delete;

  float* base() const { return reinterpret_cast<float*>(begin); }
  float* far() const { return reinterpret_cast<float*>(begin + distance); }
  float* wrapped() const { return reinterpret_cast<float*>(begin - distance); }

 private:
  static constexpr std::size_t distance = std::size_t{1} << 33, page = 1 << 16;
  char* begin;
};

// The fields of 16 records among the first 32 from `first` on, which is where 2^33 bytes have gone by.
template <int floats, class Fields, class Load, class Store>
void check_far_records(std::int32_t first, Load load_fields, Store store_fields) {
  const FarRecords memory;
  Ints index;
  for (int l = 0; l < lanes; ++l) index[l] = first + (7 * l + 3) % 32;
  Fields fields;
  for (int f = 0; f < floats; ++f) fields.field[f] = to_float(lane_index() * floats + f + 1);
  store_fields(memory.base(), index.data(), fields, first_lanes(lanes));
  for (int l = 0; l < lanes; ++l)
    for (int f = 0; f < floats; ++f) {
      const int k = floats * (index[l] - first) + f;
      ASSERT_EQ(memory.far()[k], floats * l + f + 1) << "record 2^33 B + " << index[l] - first;
      ASSERT_EQ(memory.wrapped()[k], 0) << "record 2^33 B + " << index[l] - first << " before the first";
    }
  const Fields loaded = load_fields(memory.base(), index.data());
  for (int f = 0; f < floats; ++f) EXPECT_TRUE(lanes_are(loaded.field[f], [&](int l) { return float(floats * l + f + 1); }));
}

TEST(Simd, RecordsBeyondTwoToTheTwentyEight) {
  check_far_records<8, Records>(
      1 << 28, load_records, [](float* base, const std::int32_t* index, const Records& r, maskv mask) { store_records(base, index, r, mask); });
  check_far_records<4, Quads>(1 << 29, load_quads, store_quads);
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
