// Pair lists in the forces: one particle's numbers in one place, so that a pair takes a few whole accesses. No serial
// twin: a serial loop takes each number from its array.
//
// A pair has two steps. What is arithmetic on numbers alone, its two factors, runs in full vectors over the pairs of a
// row. Then, pair by pair, all components of its term are computed at once, in a record of eight floats, and go to both
// particles.
#pragma once

#include <cstddef>
#include <cstdint>

#include "common/fluid/grid.h"
#include "common/fluid/pair.h"
#include "common/fluid/particles.h"
#include "common/simd.h"

namespace lockstep::fluid::openmp {

// What the forces need of a particle, in one cache line: position and velocity, x of both first, then y, then z; and in
// the same places what its pairs have added up to so far, by pressure and by viscosity.
struct alignas(64) Body {
  float state[8], sum[8];
};

// From the state or sum of one body, those of the next fifteen: records of eight floats, every second of which is of
// the other sort.
alignas(array_alignment) inline constexpr std::int32_t body_records[lanes] = {0,  2,  4,  6,  8,  10, 12, 14,
                                                                              16, 18, 20, 22, 24, 26, 28, 30};

// Bodies at rest so far, of the particles in `run`; body is indexed as particles are. Sixteen at once, and so up to
// fifteen more.
inline void make_bodies(const Run run, const Particles<float>& particles, Body* body) {
  const Vectors<float>&p = particles.position, &v = particles.velocity;
  for (int i = run.begin; i < run.end; i += lanes) {
    const Records state = {
        {load(&p.x[i]), load(&v.x[i]), load(&p.y[i]), load(&v.y[i]), load(&p.z[i]), load(&v.z[i]), 0.f, 0.f}};
    store_records(body[i].state, body_records, state);
    for (int l = 0; l < lanes; ++l) store_record(body[i + l].sum, 0.f);
  }
}

// Of the pairs of the particles `own`, the densities of the particles in whose lists they stand. The first pair is
// number k.
inline void repeat_densities(const Run own, int k, const std::int32_t* end, const float* density, float* density_i) {
  for (int i = own.begin; i < own.end; ++i) {
    const int end_i = end[i];
    const floatv rho = density[i];
    // What is written beyond the list, the next one overwrites.
    for (; k < end_i; k += lanes) store(density_i + k, rho);
    k = end_i;
  }
}

// Of pairs k < n: the factors of the differences p_i - p_j and v_i - v_j, side by side.
inline void find_factors(const Model<float> model, const float* density, const std::int32_t* list,
                         const float* density_i, const float* distance_2, int n, float* factors) {
  for (std::ptrdiff_t k = 0; k < n; k += lanes) {
    const auto [pressure, viscosity] =
        pair_factors(model, load(density_i + k), gather(density, load(list + k)), load(distance_2 + k));
    store_pairs(factors + 2 * k, pressure, -viscosity);
  }
}

// Adds the terms of the pairs of the particles `own` to both particles' bodies. The first pair is number k.
inline void add_pairs(const Run own, std::ptrdiff_t k, const std::int32_t* end, const std::int32_t* list,
                      const float* factors, Body* body) {
  for (int i = own.begin; i < own.end; ++i) {
    const recordv state_i = load_record(body[i].state);
    recordv sum = 0.f;
    for (const std::ptrdiff_t end_i = end[i]; k < end_i; ++k) {
      Body& other = body[list[k]];
      const recordv term = (state_i - load_record(other.state)) * repeat_pair(factors + 2 * k);
      sum = sum + term;
      store_record(other.sum, load_record(other.sum) - term);
    }
    store_record(body[i].sum, load_record(body[i].sum) + sum);
  }
}

// The accelerations that have added up, of the particles in `run`.
inline void write_sums(const Run run, const Body* body, float* x, float* y, float* z) {
  for (int i = run.begin; i < run.end; i += lanes) {
    const maskv inside = first_lanes(run.end - i);
    const auto [px, vx, py, vy, pz, vz, unused, unused_too] = load_records(body[i].sum, body_records).field;
    store(x + i, px + vx, inside), store(y + i, py + vy, inside), store(z + i, pz + vz, inside);
  }
}

}  // namespace lockstep::fluid::openmp
