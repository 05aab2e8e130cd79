// Sparse matrix times vector, sixteen rows at once: a lane adds up its row in the order of the row, so the bits are the
// serial ones.
//
// The time of a product is that of reading the matrix. So values stand in the order in which lanes take them, and rows
// of numbers store columns and values once a slot where they can (common/linear/sliced.h).
//
// The contract stands in common/linear/multiply.h.
#include "common/linear/multiply.h"

#include <cstddef>

#include "openmp/linear/block_sums.h"
#include "openmp/linear/slots.h"
#include "openmp/whole_vectors.h"

namespace lockstep::linear::openmp {
namespace {

using lockstep::openmp::with_first_lanes;

// Blocks are prefetched so many slots before their turn. A slot is 576 bytes, and the processor's own prefetching stops
// at the end of each page of 4096.
constexpr int ahead = 16;

// The products of x and the rows of slice s, one a lane; 0 in lanes beyond the last row.
LOCKSTEP_INLINE floatv times(const SlicedRows& a, std::size_t s, const float* x) {
  floatv sum = 0.f;
  for (int k = a.first_slot[s]; k < a.first_slot[s + 1]; ++k) {
    const auto [active, value, at] = entries(a, a.slots[k], x, X::constant);
    where(active, sum) += value * at;
  }
  return sum;
}

// Component c of the rows of slice s, to their places in y.
LOCKSTEP_INLINE void store_rows(const SlicedBlockRows& a, int s, const floatv (&component)[3], float* y) {
  float of_lane[3][lanes];
  for (int c = 0; c < 3; ++c) store(of_lane[c], component[c]);
  for (int l = 0; l < lanes; ++l)
    if (const std::ptrdiff_t i = a.row[s * lanes + l]; i >= 0)
      for (int c = 0; c < 3; ++c) y[3 * i + c] = of_lane[c][l];
}

}  // namespace

void multiply(const SlicedRows& a, std::span<const float> x, std::span<float> y) {
  const int slices = a.slices();
  // A slice writes its own rows of y alone.
#pragma omp parallel for schedule(static)
  for (int s = 0; s < slices; ++s)
    store(&y[a.first_row[s]], times(a, s, x.data()), first_lanes(a.first_row[s + 1] - a.first_row[s]));
}

// A slice is sixteen rows, so a block of the dot product is 64 slices, and the lane of a row is its lane in dot.
double multiply_and_dot(const SlicedRows& a, std::span<const float> x, std::span<float> y) {
  return sum_of_blocks(y.size(), [&](std::size_t begin, std::size_t end) {
    doublev sum = 0.;
    for (std::size_t i = begin; i < end; i += lanes) {
      const floatv product = times(a, i / lanes, x.data());
      with_first_lanes(end - i, [&](auto rows) {
        store(&y[i], product, rows);
        sum = add_products(sum, load(&x[i], rows), product);
      });
    }
    return reduce_add(sum);
  });
}

void multiply(const SlicedBlockRows& a, std::span<const float> x, std::span<float> y) {
  const int slices = a.slices();
  // A slice writes its own rows of y alone.
#pragma omp parallel for schedule(static)
  for (int s = 0; s < slices; ++s) {
    floatv sum[3] = {0.f, 0.f, 0.f};
    const intv length = load(&a.length[s * lanes]);
    for (int k = a.first_slot[s]; k < a.first_slot[s + 1]; ++k) {
      const maskv active = length > intv(k - a.first_slot[s]);
      const float* const block = &a.value[9 * lanes * static_cast<std::size_t>(k)];
      for (int e = 0; e < 9; ++e) __builtin_prefetch(block + (9 * ahead + e) * lanes);
      const intv column = load(&a.column[lanes * static_cast<std::size_t>(k)]) * intv(3);
      const floatv at[3] = {gather(x.data(), column, active), gather(x.data() + 1, column, active),
                            gather(x.data() + 2, column, active)};
      const auto entry = [&](int r, int c) { return load(block + (3 * r + c) * lanes); };
      for (int r = 0; r < 3; ++r)
        where(active, sum[r]) += entry(r, 0) * at[0] + entry(r, 1) * at[1] + entry(r, 2) * at[2];
    }
    store_rows(a, s, sum, y.data());
  }
}

void residual(const SlicedBlockRows& a, std::span<const float> b, std::span<const double> x, std::span<float> r) {
  const int slices = a.slices();
  // A slice writes its own rows of r alone.
#pragma omp parallel for schedule(static)
  for (int s = 0; s < slices; ++s) {
    const intv row = load(&a.row[s * lanes]), length = load(&a.length[s * lanes]);
    doublev rest[3];
    for (int c = 0; c < 3; ++c) rest[c] = to_double(gather(b.data() + c, row * intv(3), row >= intv(0)));
    for (int k = a.first_slot[s]; k < a.first_slot[s + 1]; ++k) {
      // Inactive lanes subtract 0 times 0.
      const maskv active = intv(k - a.first_slot[s]) < length;
      const float* const block = &a.value[9 * lanes * static_cast<std::size_t>(k)];
      for (int e = 0; e < 9; ++e) __builtin_prefetch(block + (9 * ahead + e) * lanes);
      double of_lane[3][lanes] = {};
      for (int l = 0; l < lanes; ++l)
        if (k - a.first_slot[s] < a.length[s * lanes + l]) {
          const double* const at = &x[3 * static_cast<std::size_t>(a.column[lanes * static_cast<std::size_t>(k) + l])];
          for (int c = 0; c < 3; ++c) of_lane[c][l] = at[c];
        }
      const doublev at[3] = {load(of_lane[0]), load(of_lane[1]), load(of_lane[2])};
      const auto entry = [&](int j, int c) { return to_double(load(block + (3 * j + c) * lanes, active)); };
      for (int j = 0; j < 3; ++j)
        for (int c = 0; c < 3; ++c) rest[j] = rest[j] - entry(j, c) * at[c];
    }
    floatv rounded[3];
    for (int c = 0; c < 3; ++c) rounded[c] = to_float(rest[c]);
    store_rows(a, s, rounded, r.data());
  }
}

}  // namespace lockstep::linear::openmp
