// Pairs sorted by formula, so that sixteen pairs go through the same formula at once.
#pragma once

#include <span>

#include "common/rigid/pairs.h"
#include "openmp/rigid/lanes.h"

namespace lockstep::rigid::openmp {

inline constexpr int block = 512;  // pairs that are sorted at a time, at most

// Pairs of one kind within a block: their shapes in the order in which the formula has them, and which pair each is.
struct Bin {
  int count = 0;
  Indices first[block / lanes], second[block / lanes], pair[block / lanes];

  // Lanes beyond the last pair repeat the first of theirs: what they write, it has written.
  void fill_up() {
    for (int k = count; k % lanes != 0; ++k)
      for (Indices* of : {first, second, pair}) of[k / lanes].index[k % lanes] = of[k / lanes].index[0];
  }
};

// The bin of a pair, and its shapes in the order of the formula.
struct Place {
  int bin, first, second;
};

// Sorts pairs begin .. end - 1. The count of the bin met last stays in a register: pairs of one kind often follow one
// another.
template <class PlaceOf>
void sort_block(std::span<const Pair> pairs, int begin, int end, Bin* bins, PlaceOf place_of) {
  Bin* bin = bins;
  int n = 0;
  for (int k = begin; k < end; ++k) {
    const Place place = place_of(pairs[k]);
    if (Bin* const own = bins + place.bin; own != bin) bin->count = n, bin = own, n = bin->count;
    bin->first[n / lanes].index[n % lanes] = place.first;
    bin->second[n / lanes].index[n % lanes] = place.second;
    bin->pair[n / lanes].index[n % lanes] = k;
    ++n;
  }
  bin->count = n;
}

// All lanes of m, as store_manifolds puts them, where none has more than two points; or no more than one, that has
// feature 0. Among equal indices, lanes are equal.
template <int points>
LOCKSTEP_INLINE void store_short_manifolds(std::span<Manifold<float>> manifolds, const Indices& indices,
                                           const ManifoldLanes& m) {
  float* const records = &manifolds.data()->normal.x;
  const auto put = [&](int part, const Records& record) {
    const Indices to = indices_of(load(indices.index) * 4 + part);
    store_records(records, to.index, record, lanes_of(0xffff));
  };
  const Vector3<floatv>&p = m.position[0], &q = m.position[1];
  put(0,
      {{m.normal.x, m.normal.y, m.normal.z, float_of_bits(m.count), float_of_bits(m.a), float_of_bits(m.b), 0.f, 0.f}});
  put(1, {{p.x, p.y, p.z, m.separation[0], q.x, q.y, q.z, m.separation[1]}});
  for (const std::int32_t to : indices.index) store_record(record_at<32>(records, to) + 16, 0.f);
  if constexpr (points == 2)
    put(3, {{float_of_bits(m.feature[0]), float_of_bits(m.feature[1]), 0.f, 0.f, 0.f, 0.f, 0.f, 0.f}});
  else
    for (const std::int32_t to : indices.index) store_record(record_at<32>(records, to) + 24, 0.f);
}

}  // namespace lockstep::rigid::openmp
