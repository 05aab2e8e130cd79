// Lanes and memory: common/simd.h's loads, stores, gathers and records. What it asserts, of the one back end it is
// built for:
//
// - every access reads or writes what simd.h promises, at any alignment it allows
// - masked operations act on active lanes only, and do not touch the memory of inactive ones: it is a page that may
//   not be accessed
// - records and pairs are found beyond 2^33 bytes, too

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <new>
#include <vector>

#include "common/simd.h"
#include "tests/simd_values.h"

namespace lockstep {
namespace {

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
    ASSERT_TRUE(
        lanes_are(select(mask_of(mask), load(a), load(b)), [&](int l) { return active(mask, l) ? a[l] : b[l]; }));
    ASSERT_TRUE(lanes_are(decltype(load(a))(a[0]), [&](int) -> T { return a[0]; }));
  }
}
TEST(Simd, StreamsWhatStoresWrite) {
  Random random;
  alignas(64) std::array<float, 3 * lanes> streamed, stored;
  streamed.fill(7), stored.fill(7);
  const auto value = random.fill<std::array<float, lanes>>();
  stream(&streamed[lanes], load(value.data()));
  finish_streams();
  store(&stored[lanes], load(value.data()));
  EXPECT_EQ(std::memcmp(streamed.data(), stored.data(), sizeof(stored)), 0);
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

struct alignas(32) Mixed {
  float x;
  std::int32_t before;
  float y[5];
  std::int32_t after;
};

// Not inline, so that the compiler knows no more of the memory than the types.
[[gnu::noinline]] int add_in_records(Mixed* records, const std::int32_t* index) {
  for (int l = 0; l < lanes; ++l) records[l].before = 1, records[l].after = 2;
  Records r = load_records(&records->x, index);
  r.field[7] = float_of_bits(bits_of(r.field[1]) + 5);
  store_records(&records->x, index, r);
  int sum = 0;
  for (int l = 0; l < lanes; ++l) sum += records[l].after;
  return sum + reduce_add(bits_of(r.field[1]));
}

TEST(Simd, RecordsMayHoldIntegers) {
  Mixed records[lanes] = {};
  EXPECT_EQ(add_in_records(records, values(lane_index()).data()), 16 * (1 + 5) + 16);
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
      for (int f = 0; f < 4; ++f)
        ASSERT_EQ(target[4 * index[k] + f], k < lanes && active(mask, k) ? base[4 * index[k] + f] : -1.f) << mask;
  }
}

// Calls check(middle, index) for indices at which `count` neighbours begin. The outermost reach the ends of a page.
template <class Check>
void check_neighbours(int count, const Check& check) {
  Random random;
  const GuardedPage<float> page;
  for (float& x : page) x = random;
  float* const middle = page.begin() + page.size() / 2;
  for (int t = 0; t < trials; ++t) {
    Ints index = values(load(random.ints_below(page.size() - count + 1)) - page.size() / 2);
    index[random.below(lanes)] = -page.size() / 2;
    index[random.below(lanes)] = page.size() - page.size() / 2 - count;
    check(middle, index);
  }
}

TEST(Simd, GathersPairsOfNeighbours) {
  check_neighbours(2, [](const float* middle, const Ints& index) {
    const Halves pairs = gather_pairs(middle, load(index));
    ASSERT_TRUE(lanes_are(pairs.first, [&](int l) { return middle[index[l]]; }));
    ASSERT_TRUE(lanes_are(pairs.second, [&](int l) { return middle[index[l] + 1]; }));
  });
}

TEST(Simd, GathersFourNeighbours) {
  check_neighbours(4, [](const float* middle, const Ints& index) {
    const Quads fours = gather_fours(middle, load(index));
    for (int f = 0; f < 4; ++f) ASSERT_TRUE(lanes_are(fours.field[f], [&](int l) { return middle[index[l] + f]; }));
  });
}

// Address space for records that begin at 2^33 bytes, and as much before them, where a product that wraps around in 32
// bits would lead. Only one page is there on either side.
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
  for (int f = 0; f < floats; ++f)
    EXPECT_TRUE(lanes_are(loaded.field[f], [&](int l) { return float(floats * l + f + 1); }));
}

TEST(Simd, RecordsBeyondTwoToTheTwentyEight) {
  check_far_records<8, Records>(1 << 28, load_records,
                                [](float* base, const std::int32_t* index, const Records& r, maskv mask) {
                                  store_records(base, index, r, mask);
                                });
  check_far_records<4, Quads>(1 << 29, load_quads, store_quads);
}

}  // namespace
}  // namespace lockstep
