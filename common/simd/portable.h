// The back end in plain C++: an array and a loop. It runs anywhere, and the thread sanitizer sees its accesses, while
// it does not see those of registers wider than 128 bits. For that, -fno-builtin keeps the compiler from turning loops
// into calls of memcpy. Contract: ../simd.h.
//
// One file, because every back end keeps the order of ../simd.h, so that back ends are read side by side.

#ifndef LOCKSTEP_COMMON_SIMD_PORTABLE_H
#define LOCKSTEP_COMMON_SIMD_PORTABLE_H

#include <cmath>

namespace lockstep {

inline constexpr const char* isa_name = "portable";
inline constexpr bool picks_from_vectors = true;

struct floatv {
  float lane[lanes];
  floatv() = default;
  LOCKSTEP_INLINE floatv(float x) {
    for (float& y : lane) y = x;
  }
};

struct intv {
  std::int32_t lane[lanes];
  intv() = default;
  LOCKSTEP_INLINE intv(std::int32_t x) {
    for (std::int32_t& y : lane) y = x;
  }
};

// A lane is -1 or 0, as wide as what it selects, so that compilers turn a loop of selects into vector code.
struct maskv {
  std::int32_t lane[lanes];
};

// Without the pragma, g++ 12 unrolls the loop before it looks for vectors, and then finds none; clang++ needs no
// telling, and warns of each loop it leaves scalar once told.
template <class V, class F>
LOCKSTEP_INLINE V make_lanes(F f) {
  V v;
#ifndef __clang__
#pragma omp simd
#endif
  for (int l = 0; l < lanes; ++l) v.lane[l] = f(l);
  return v;
}
template <class F>
LOCKSTEP_INLINE floatv float_lanes(F f) {
  return make_lanes<floatv>(f);
}
template <class F>
LOCKSTEP_INLINE intv int_lanes(F f) {
  return make_lanes<intv>(f);
}
template <class F>
LOCKSTEP_INLINE maskv mask_lanes(F f) {
  return make_lanes<maskv>([&](int l) { return f(l) ? -1 : 0; });
}

LOCKSTEP_INLINE floatv load(const float* p) {
  return float_lanes([&](int l) { return p[l]; });
}
LOCKSTEP_INLINE intv load(const std::int32_t* p) {
  return int_lanes([&](int l) { return p[l]; });
}
LOCKSTEP_INLINE floatv load(const float* p, maskv mask) {
  return float_lanes([&](int l) { return mask.lane[l] ? p[l] : 0; });
}
LOCKSTEP_INLINE intv load(const std::int32_t* p, maskv mask) {
  return int_lanes([&](int l) { return mask.lane[l] ? p[l] : 0; });
}
LOCKSTEP_INLINE void store(float* p, floatv v) {
  for (int l = 0; l < lanes; ++l) p[l] = v.lane[l];
}
LOCKSTEP_INLINE void store(std::int32_t* p, intv v) {
  for (int l = 0; l < lanes; ++l) p[l] = v.lane[l];
}
LOCKSTEP_INLINE void store(float* p, floatv v, maskv mask) {
  for (int l = 0; l < lanes; ++l)
    if (mask.lane[l]) p[l] = v.lane[l];
}
LOCKSTEP_INLINE void store(std::int32_t* p, intv v, maskv mask) {
  for (int l = 0; l < lanes; ++l)
    if (mask.lane[l]) p[l] = v.lane[l];
}
LOCKSTEP_INLINE void stream(float* p, floatv v) { store(p, v); }
LOCKSTEP_INLINE void finish_streams() {}

struct Records {
  floatv field[8];
};

// A record may hold integers among its floats. To read those through a plain float* would break the aliasing rule, and
// memcpy is what the thread sanitizer must be kept from, see above.
using any_float [[gnu::may_alias]] = float;

template <int floats>
LOCKSTEP_INLINE void load_fields(const float* records, const std::int32_t* index, floatv (&field)[floats]) {
  for (int l = 0; l < lanes; ++l) {
    const any_float* record = record_at<floats>(records, index[l]);
    for (int f = 0; f < floats; ++f) field[f].lane[l] = record[f];
  }
}
template <int floats>
LOCKSTEP_INLINE void store_fields(float* records, const std::int32_t* index, const floatv (&field)[floats],
                                  maskv mask) {
  for (int l = 0; l < lanes; ++l) {
    if (!mask.lane[l]) continue;
    any_float* record = record_at<floats>(records, index[l]);
    for (int f = 0; f < floats; ++f) record[f] = field[f].lane[l];
  }
}

LOCKSTEP_INLINE Records load_records(const float* records, const std::int32_t* index) {
  Records r;
  load_fields(records, index, r.field);
  return r;
}
LOCKSTEP_INLINE void store_records(float* records, const std::int32_t* index, const Records& r, maskv mask) {
  store_fields(records, index, r.field, mask);
}

struct recordv {
  float field[8];
  recordv() = default;
  LOCKSTEP_INLINE recordv(float x) {
    for (float& y : field) y = x;
  }
};
template <class F>
LOCKSTEP_INLINE recordv make_record(F f) {
  recordv r;
  for (int k = 0; k < 8; ++k) r.field[k] = f(k);
  return r;
}
LOCKSTEP_INLINE recordv load_record(const float* p) {
  const any_float* record = p;
  return make_record([&](int f) { return record[f]; });
}
LOCKSTEP_INLINE void store_record(float* p, recordv r) {
  any_float* record = p;
  for (int f = 0; f < 8; ++f) record[f] = r.field[f];
}
LOCKSTEP_INLINE recordv repeat_pair(const float* p) {
  return make_record([&](int f) { return p[f % 2]; });
}
LOCKSTEP_INLINE recordv operator+(recordv a, recordv b) {
  return make_record([&](int f) { return a.field[f] + b.field[f]; });
}
LOCKSTEP_INLINE recordv operator-(recordv a, recordv b) {
  return make_record([&](int f) { return a.field[f] - b.field[f]; });
}
LOCKSTEP_INLINE recordv operator*(recordv a, recordv b) {
  return make_record([&](int f) { return a.field[f] * b.field[f]; });
}
LOCKSTEP_INLINE void store_pairs(float* p, floatv a, floatv b) {
  for (int l = 0; l < lanes; ++l) p[2 * l] = a.lane[l], p[2 * l + 1] = b.lane[l];
}

struct Quads {
  floatv field[4];
};

LOCKSTEP_INLINE Quads load_quads(const float* records, const std::int32_t* index) {
  Quads r;
  load_fields(records, index, r.field);
  return r;
}
LOCKSTEP_INLINE void store_quads(float* records, const std::int32_t* index, Quads quads, maskv mask) {
  store_fields(records, index, quads.field, mask);
}

LOCKSTEP_INLINE floatv gather(const float* base, intv index) {
  return float_lanes([&](int l) { return base[index.lane[l]]; });
}
LOCKSTEP_INLINE intv gather(const std::int32_t* base, intv index) {
  return int_lanes([&](int l) { return base[index.lane[l]]; });
}
LOCKSTEP_INLINE floatv gather(const float* base, intv index, maskv mask) {
  return float_lanes([&](int l) { return mask.lane[l] ? base[index.lane[l]] : 0; });
}
LOCKSTEP_INLINE intv gather(const std::int32_t* base, intv index, maskv mask) {
  return int_lanes([&](int l) { return mask.lane[l] ? base[index.lane[l]] : 0; });
}

struct Halves {
  floatv first, second;
};

LOCKSTEP_INLINE Halves gather_pairs(const float* base, intv index) {
  return {gather(base, index), gather(base + 1, index)};
}

LOCKSTEP_INLINE Quads gather_fours(const float* base, intv index) {
  return {{gather(base, index), gather(base + 1, index), gather(base + 2, index), gather(base + 3, index)}};
}

LOCKSTEP_INLINE floatv operator+(floatv a, floatv b) {
  return float_lanes([&](int l) { return a.lane[l] + b.lane[l]; });
}
LOCKSTEP_INLINE floatv operator-(floatv a, floatv b) {
  return float_lanes([&](int l) { return a.lane[l] - b.lane[l]; });
}
LOCKSTEP_INLINE floatv operator*(floatv a, floatv b) {
  return float_lanes([&](int l) { return a.lane[l] * b.lane[l]; });
}
LOCKSTEP_INLINE floatv operator/(floatv a, floatv b) {
  return float_lanes([&](int l) { return a.lane[l] / b.lane[l]; });
}
LOCKSTEP_INLINE floatv operator-(floatv a) {
  return float_lanes([&](int l) { return -a.lane[l]; });
}
LOCKSTEP_INLINE floatv min(floatv a, floatv b) {
  return float_lanes([&](int l) { return a.lane[l] < b.lane[l] ? a.lane[l] : b.lane[l]; });
}
LOCKSTEP_INLINE floatv max(floatv a, floatv b) {
  return float_lanes([&](int l) { return a.lane[l] > b.lane[l] ? a.lane[l] : b.lane[l]; });
}
LOCKSTEP_INLINE floatv abs(floatv a) {
  return float_lanes([&](int l) { return std::fabs(a.lane[l]); });
}
LOCKSTEP_INLINE floatv sqrt(floatv a) {
  return float_lanes([&](int l) { return std::sqrt(a.lane[l]); });
}
LOCKSTEP_INLINE floatv fma(floatv a, floatv b, floatv c) {
  return float_lanes([&](int l) { return std::fma(a.lane[l], b.lane[l], c.lane[l]); });
}

// Through unsigned, where wrapping around is defined.
LOCKSTEP_INLINE std::uint32_t modular(std::int32_t x) { return static_cast<std::uint32_t>(x); }
LOCKSTEP_INLINE intv operator+(intv a, intv b) {
  return int_lanes([&](int l) { return modular(a.lane[l]) + modular(b.lane[l]); });
}
LOCKSTEP_INLINE intv operator-(intv a, intv b) {
  return int_lanes([&](int l) { return modular(a.lane[l]) - modular(b.lane[l]); });
}
LOCKSTEP_INLINE intv operator*(intv a, intv b) {
  return int_lanes([&](int l) { return modular(a.lane[l]) * modular(b.lane[l]); });
}
LOCKSTEP_INLINE intv operator&(intv a, intv b) {
  return int_lanes([&](int l) { return a.lane[l] & b.lane[l]; });
}
LOCKSTEP_INLINE intv operator|(intv a, intv b) {
  return int_lanes([&](int l) { return a.lane[l] | b.lane[l]; });
}
LOCKSTEP_INLINE intv operator^(intv a, intv b) {
  return int_lanes([&](int l) { return a.lane[l] ^ b.lane[l]; });
}
LOCKSTEP_INLINE intv operator<<(intv a, intv n) {
  return int_lanes([&](int l) { return a.lane[l] << n.lane[l]; });
}
LOCKSTEP_INLINE intv operator>>(intv a, intv n) {
  return int_lanes([&](int l) { return a.lane[l] >> n.lane[l]; });
}
LOCKSTEP_INLINE intv min(intv a, intv b) {
  return int_lanes([&](int l) { return a.lane[l] < b.lane[l] ? a.lane[l] : b.lane[l]; });
}
LOCKSTEP_INLINE intv max(intv a, intv b) {
  return int_lanes([&](int l) { return a.lane[l] > b.lane[l] ? a.lane[l] : b.lane[l]; });
}
LOCKSTEP_INLINE intv to_int(floatv a) {
  return int_lanes([&](int l) {
    const bool fits = a.lane[l] >= -0x1p31f && a.lane[l] < 0x1p31f;
    return fits ? static_cast<std::int32_t>(a.lane[l]) : INT32_MIN;
  });
}
LOCKSTEP_INLINE floatv to_float(intv a) {
  return float_lanes([&](int l) { return static_cast<float>(a.lane[l]); });
}
LOCKSTEP_INLINE intv bits_of(floatv a) {
  return int_lanes([&](int l) { return std::bit_cast<std::int32_t>(a.lane[l]); });
}
LOCKSTEP_INLINE floatv float_of_bits(intv a) {
  return float_lanes([&](int l) { return std::bit_cast<float>(a.lane[l]); });
}

LOCKSTEP_INLINE maskv operator<(floatv a, floatv b) {
  return mask_lanes([&](int l) { return a.lane[l] < b.lane[l]; });
}
LOCKSTEP_INLINE maskv operator<=(floatv a, floatv b) {
  return mask_lanes([&](int l) { return a.lane[l] <= b.lane[l]; });
}
LOCKSTEP_INLINE maskv operator==(floatv a, floatv b) {
  return mask_lanes([&](int l) { return a.lane[l] == b.lane[l]; });
}
LOCKSTEP_INLINE maskv operator!=(floatv a, floatv b) {
  return mask_lanes([&](int l) { return a.lane[l] != b.lane[l]; });
}
LOCKSTEP_INLINE maskv operator<(intv a, intv b) {
  return mask_lanes([&](int l) { return a.lane[l] < b.lane[l]; });
}
LOCKSTEP_INLINE maskv operator<=(intv a, intv b) {
  return mask_lanes([&](int l) { return a.lane[l] <= b.lane[l]; });
}
LOCKSTEP_INLINE maskv operator==(intv a, intv b) {
  return mask_lanes([&](int l) { return a.lane[l] == b.lane[l]; });
}
LOCKSTEP_INLINE maskv operator!=(intv a, intv b) {
  return mask_lanes([&](int l) { return a.lane[l] != b.lane[l]; });
}

LOCKSTEP_INLINE maskv operator&(maskv a, maskv b) {
  return make_lanes<maskv>([&](int l) { return a.lane[l] & b.lane[l]; });
}
LOCKSTEP_INLINE maskv operator|(maskv a, maskv b) {
  return make_lanes<maskv>([&](int l) { return a.lane[l] | b.lane[l]; });
}
LOCKSTEP_INLINE maskv operator^(maskv a, maskv b) {
  return make_lanes<maskv>([&](int l) { return a.lane[l] ^ b.lane[l]; });
}
LOCKSTEP_INLINE maskv operator~(maskv a) {
  return make_lanes<maskv>([&](int l) { return ~a.lane[l]; });
}
LOCKSTEP_INLINE std::uint32_t bits(maskv mask) {
  std::uint32_t b = 0;
  for (int l = 0; l < lanes; ++l) b |= static_cast<std::uint32_t>(mask.lane[l]) & 1u << l;
  return b;
}
LOCKSTEP_INLINE maskv lanes_of(std::uint32_t bits) {
  return mask_lanes([&](int l) { return bits >> l & 1; });
}
LOCKSTEP_INLINE intv lane_index() {
  return int_lanes([](int l) { return l; });
}
LOCKSTEP_INLINE floatv select(maskv mask, floatv a, floatv b) {
  return float_lanes([&](int l) { return mask.lane[l] ? a.lane[l] : b.lane[l]; });
}
LOCKSTEP_INLINE intv select(maskv mask, intv a, intv b) {
  return int_lanes([&](int l) { return mask.lane[l] ? a.lane[l] : b.lane[l]; });
}

template <class V>
LOCKSTEP_INLINE V compress_lanes(maskv mask, V v) {
  V front = 0;
  int n = 0;
  for (int l = 0; l < lanes; ++l)
    if (mask.lane[l]) front.lane[n++] = v.lane[l];
  return front;
}
LOCKSTEP_INLINE floatv compress(maskv mask, floatv v) { return compress_lanes(mask, v); }
LOCKSTEP_INLINE intv compress(maskv mask, intv v) { return compress_lanes(mask, v); }

LOCKSTEP_INLINE floatv permute(floatv v, intv index) {
  return float_lanes([&](int l) { return v.lane[index.lane[l] & 15]; });
}

LOCKSTEP_INLINE floatv shift_up(floatv v, float first) {
  return float_lanes([&](int l) { return l > 0 ? v.lane[l - 1] : first; });
}
LOCKSTEP_INLINE floatv shift_down(floatv v, float last) {
  return float_lanes([&](int l) { return l + 1 < lanes ? v.lane[l + 1] : last; });
}

LOCKSTEP_INLINE void transpose(floatv (&row)[lanes]) {
  for (int i = 0; i < lanes; ++i)
    for (int j = 0; j < i; ++j) {
      const float x = row[i].lane[j];
      row[i].lane[j] = row[j].lane[i];
      row[j].lane[i] = x;
    }
}

// Where in the row of 32 lane l of `first` stands.
template <int G>
LOCKSTEP_INLINE int place_in_row(int l) {
  return l / G * 2 * G + l % G;
}

template <int G>
LOCKSTEP_INLINE Halves split(floatv a, floatv b) {
  const auto row = [&](int k) { return k < lanes ? a.lane[k] : b.lane[k - lanes]; };
  return {float_lanes([&](int l) { return row(place_in_row<G>(l)); }),
          float_lanes([&](int l) { return row(place_in_row<G>(l) + G); })};
}

template <int G>
LOCKSTEP_INLINE void join(Halves halves, floatv& a, floatv& b) {
  float row[2 * lanes];
  for (int l = 0; l < lanes; ++l) {
    row[place_in_row<G>(l)] = halves.first.lane[l];
    row[place_in_row<G>(l) + G] = halves.second.lane[l];
  }
  a = load(row);
  b = load(row + lanes);
}

template <class V, class Combine>
LOCKSTEP_INLINE auto reduce_lanes(V v, Combine combine) {
  for (int half = lanes / 2; half > 0; half /= 2)
    v = combine(v, make_lanes<V>([&](int l) { return v.lane[(l + half) % lanes]; }));
  return v.lane[0];
}
LOCKSTEP_INLINE std::int32_t reduce_add(intv v) {
  return reduce_lanes(v, [](intv a, intv b) { return a + b; });
}

}  // namespace lockstep

#endif
