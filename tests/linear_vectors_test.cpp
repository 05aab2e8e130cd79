// Lanes of double, dot products and vector updates: sums in the order that the contract states, within their bounds,
// with the serial bits at every number of threads.
#include <algorithm>
#include <cmath>
#include <limits>

#include "common/linear/dot.h"
#include "common/linear/update.h"
#include "common/simd_double.h"
#include "tests/linear_matrices.h"

namespace lockstep::linear {
namespace {

constexpr std::size_t lengths[] = {0, 1, 15, 16, 17, 1023, 1024, 1025, 1040, 5000, 40'001};

// --- Lanes of double

TEST(SimdDouble, DoesWhatDoublesDo) {
  float a[lanes], b[lanes];
  for (int l = 0; l < lanes; ++l)
    a[l] = 1.f + static_cast<float>(l) * 0x1p-23f, b[l] = -3.f / static_cast<float>(l + 1);
  const doublev x = to_double(load(a)), y = to_double(load(b));
  double sum[lanes], difference[lanes], product[lanes];
  store(sum, x + y), store(difference, x - y), store(product, x * y);
  for (int l = 0; l < lanes; ++l) {
    EXPECT_EQ(sum[l], static_cast<double>(a[l]) + b[l]);
    EXPECT_EQ(difference[l], static_cast<double>(a[l]) - b[l]);
    EXPECT_EQ(product[l], static_cast<double>(a[l]) * b[l]);
  }
  store(sum, doublev(.1));
  for (const double s : sum) EXPECT_EQ(s, .1);
}

// Zeros, infinities, NaN and numbers of many sizes, each with each.
TEST(SimdDouble, ComparesAndSelectsAsDoublesDo) {
  constexpr double inf = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
  constexpr double of[] = {0., -0., 1., -1.5, 0x1p-1074, -0x1p-540, 0x1.fp1000, inf, -inf, nan, 2., 3., -7., .1, 1e-9};
  double a[lanes], b[lanes], c[lanes];
  for (int shift = 0; shift < 15; ++shift) {
    for (int l = 0; l < lanes; ++l) a[l] = of[l % 15], b[l] = of[(l + shift) % 15];
    const doublev x = load(a), y = load(b);
    const auto expect_same = [&](doublev v, const auto& expected) {
      store(c, v);
      for (int l = 0; l < lanes; ++l) {
        const double e = expected(a[l], b[l]);
        if (std::isnan(e))
          EXPECT_TRUE(std::isnan(c[l])) << a[l] << " " << b[l];
        else
          EXPECT_EQ(std::bit_cast<std::uint64_t>(c[l]), std::bit_cast<std::uint64_t>(e)) << a[l] << " " << b[l];
      }
    };
    expect_same(x / y, [](double p, double q) { return p / q; });
    expect_same(-x, [](double p, double) { return -p; });
    expect_same(abs(x), [](double p, double) { return std::abs(p); });
    expect_same(sqrt(x), [](double p, double) { return std::sqrt(p); });
    expect_same(cbrt(x), [](double p, double) { return std::cbrt(p); });
    expect_same(min(x, y), [](double p, double q) { return p < q ? p : q; });
    expect_same(max(x, y), [](double p, double q) { return p > q ? p : q; });
    expect_same(select(x < y, x, y), [](double p, double q) { return p < q ? p : q; });
    const auto expect_mask = [&](maskv mask, const auto& expected) {
      for (int l = 0; l < lanes; ++l) EXPECT_EQ(bits(mask) >> l & 1, expected(a[l], b[l])) << a[l] << " " << b[l];
    };
    expect_mask(x < y, [](double p, double q) { return p < q; });
    expect_mask(x <= y, [](double p, double q) { return p <= q; });
    expect_mask(x > y, [](double p, double q) { return p > q; });
    expect_mask(x >= y, [](double p, double q) { return p >= q; });
    expect_mask(x == y, [](double p, double q) { return p == q; });
  }
}

TEST(SimdDouble, AddsInTheTree) {
  float a[lanes];
  double v[lanes];
  for (int l = 0; l < lanes; ++l) a[l] = static_cast<float>(std::pow(-7., l)), v[l] = a[l] * .1;
  const auto pair = [&](int l) { return (v[l] + v[l + 8]) + (v[l + 4] + v[l + 12]); };
  EXPECT_EQ(reduce_add(to_double(load(a)) * doublev(.1)), (pair(0) + pair(2)) + (pair(1) + pair(3)));
}

TEST(SimdDouble, AddsQuartersFromTheLeft) {
  float a[lanes];
  double sum[4] = {.3, .3, .3, .3};
  for (int l = 0; l < lanes; ++l) a[l] = static_cast<float>(std::pow(-7., l)), sum[l % 4] += a[l] * .1;
  const Quarter q = add_quarters(Quarter(.3), to_double(load(a)) * doublev(.1));
  EXPECT_EQ(reduce_add(q), (sum[0] + sum[2]) + (sum[1] + sum[3]));
}

// --- Dot products

// The contract's order, written another way: the sum of a lane, the tree as a recursion.
double in_the_stated_order(std::span<const float> x, std::span<const float> y) {
  double sum = 0;
  for (std::size_t begin = 0; begin < x.size(); begin += 1024) {
    const auto lane = [&](std::size_t l) {
      double s = 0;
      for (std::size_t i = begin + l; i < std::min(begin + 1024, x.size()); i += 16)
        s += static_cast<double>(x[i]) * y[i];
      return s;
    };
    const auto tree = [&](auto self, int l, int stride) -> double {
      return stride == 16 ? lane(l) : self(self, l, 2 * stride) + self(self, l + stride, 2 * stride);
    };
    sum += tree(tree, 0, 1);
  }
  return sum;
}

TEST(LinearDot, AddsInTheStatedOrder) {
  for (const std::size_t n : lengths) {
    Array<float> x = random_vector<float>(n, 1), y = random_vector<float>(n, 2);
    for (std::size_t i = 0; i < n; ++i) x[i] *= std::ldexp(1.f, static_cast<int>(i % 60));  // so that order shows
    const double expected = in_the_stated_order(x, y);
    EXPECT_EQ(serial::dot(view(x), view(y)), expected) << n;
    at_each_thread_count([&] { EXPECT_EQ(openmp::dot(x, y), expected) << n; });
  }
}

TEST(LinearDot, IsWithinItsBound) {
  for (const std::size_t n : lengths) {
    const Array<float> x = random_vector<float>(n, 3), y = random_vector<float>(n, 4);
    long double sum = 0, sizes = 0;  // of products of 48 bits: exact to 2^-64 of the sizes
    for (std::size_t i = 0; i < n; ++i)
      sum += static_cast<long double>(x[i]) * y[i], sizes += std::abs(static_cast<long double>(x[i]) * y[i]);
    const double additions = 64. + 4. + static_cast<double>(n) / 1024 + 1;
    EXPECT_LE(std::abs(serial::dot(view(x), view(y)) - sum), additions * 0x1p-53 * sizes) << n;
  }
}

TEST(LinearDot, HasNoTroubleWithCancellation) {
  // In float the sum would be 0.
  const Array<float> x = {0x1p12f, 1, -0x1p12f}, y = {0x1p12f, 1, 0x1p12f};
  EXPECT_EQ(serial::dot(view(x), view(y)), 1);
  EXPECT_EQ(openmp::dot(x, y), 1);
}

TEST(LinearDot, PassesOnWhatIsNotFinite) {
  Array<float> x(3000, 1), y(3000, 1);
  x[2999] = std::numeric_limits<float>::infinity();
  EXPECT_EQ(openmp::dot(x, y), std::numeric_limits<double>::infinity());
  y[2999] = 0;
  EXPECT_TRUE(std::isnan(openmp::dot(x, y)));
}

// --- Updates

// Three elements before and after a vector must stay.
struct Guarded {
  explicit Guarded(const Array<float>& x) : all(x.size() + 6, 77) { std::copy(x.begin(), x.end(), all.begin() + 3); }
  ~Guarded() {
    for (int i = 0; i < 3; ++i) {
      EXPECT_EQ(all[i], 77);
      EXPECT_EQ(all[all.size() - 1 - i], 77);
    }
  }
  std::span<float> span() { return {all.data() + 3, all.size() - 6}; }
  Array<float> all;
};

TEST(LinearUpdate, AddsAndScales) {
  const Array<float> x = {1, 2, 3}, before = {10, 20, 30};
  Guarded y(before), p(before);
  serial::axpy(.5f, x, y.span());
  EXPECT_TRUE(same_bits(y.span(), Array<float>{10.5, 21, 31.5}));
  Guarded at(x), r(before);
  serial::advance(2.f, view(x), .5f, at.span(), p.span());
  EXPECT_TRUE(same_bits(at.span(), Array<float>{21, 42, 63}));
  EXPECT_TRUE(same_bits(p.span(), Array<float>{6, 12, 18}));
  EXPECT_EQ(serial::descend(2.f, view(before), r.span()), 100 + 400 + 900);
  EXPECT_TRUE(same_bits(r.span(), Array<float>{-10, -20, -30}));
}

TEST(LinearUpdate, HasTheSerialBits) {
  for (const std::size_t n : lengths) {
    const Array<float> p = random_vector<float>(n, 1), q = random_vector<float>(n, 2), x = random_vector<float>(n, 3),
                       r = random_vector<float>(n, 4);
    Guarded sx(x), sr(r), sy(x), sp(p);
    const double squares = serial::descend(.3f, view(q), sr.span());
    serial::axpy(.7f, p, sy.span());
    serial::advance(.3f, view(q), -.9f, sx.span(), sp.span());
    at_each_thread_count([&] {
      Guarded ox(x), oR(r), oy(x), op(p);
      EXPECT_EQ(openmp::descend(.3f, q, oR.span()), squares) << n;
      openmp::axpy(.7f, p, oy.span());
      openmp::advance(.3f, q, -.9f, ox.span(), op.span());
      EXPECT_TRUE(same_bits(ox.span(), sx.span()));
      EXPECT_TRUE(same_bits(oR.span(), sr.span()));
      EXPECT_TRUE(same_bits(oy.span(), sy.span()));
      EXPECT_TRUE(same_bits(op.span(), sp.span()));
    });
  }
}

}  // namespace
}  // namespace lockstep::linear
