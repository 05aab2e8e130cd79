// Loops over slices of sixteen vertices, with dot products of vectors that are three arrays.
#pragma once

#include <algorithm>
#include <array>

#include "common/array.h"
#include "common/linear/dot.h"
#include "common/simd_double.h"
#include "common/vector3.h"

namespace lockstep::production_cloth::openmp {

// A dot product of a block. It has the bits of linear/dot of records, of which lane 4 i + c adds up component c of
// vertices i, i + 4, and so on; the fourth component is 0.
struct Products {
  Vector3<Quarter> of = {0., 0., 0.};
  LOCKSTEP_INLINE void add(const Vector3<floatv>& a, const Vector3<floatv>& b) {
    of.x = add_quarters(of.x, to_double(a.x) * to_double(b.x));
    of.y = add_quarters(of.y, to_double(a.y) * to_double(b.y));
    of.z = add_quarters(of.z, to_double(a.z) * to_double(b.z));
  }
  double sum() const { return (reduce_add(of.x) + reduce_add(of.z)) + reduce_add(of.y); }
};

constexpr int slices_of_block = linear::dot_block / (4 * lanes);
static_assert(linear::dot_block % (4 * lanes) == 0);
constexpr std::size_t sums_of_block = 16;  // two cache lines
inline int blocks_of(int slices) { return (slices + slices_of_block - 1) / slices_of_block; }

// Calls f(slice, products) for each slice, and keeps the products of a block as the sums `which`. All loops over
// vectors give a thread the same blocks, so that they stay with its core. A team calls it, and waits at its end.
template <std::size_t count, class F>
void for_each_slice(int slices, Array<double>& sums, const std::array<int, count>& which, const F& f) {
  // A block writes its own elements and sums.
#pragma omp for schedule(static)
  for (int block = 0; block < blocks_of(slices); ++block) {
    std::array<Products, count> products;
    const int begin = block * slices_of_block, end = std::min(begin + slices_of_block, slices);
    for (int slice = begin; slice < end; ++slice) f(slice, products);
    for (std::size_t k = 0; k < count; ++k) sums[block * sums_of_block + which[k]] = products[k].sum();
  }
}

// A sum of all blocks, added up in their order.
inline double total(const Array<double>& sums, int which) {
  double sum = 0;
  for (std::size_t k = which; k < sums.size(); k += sums_of_block) sum += sums[k];
  return sum;
}

}  // namespace lockstep::production_cloth::openmp
