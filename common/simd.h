// Sixteen lanes of float and of int32, and a mask: the one vocabulary in which lane code is written, so that it
// reads like the scalar code beside it.
//
// This file is the contract. Each back end (simd/avx512.h, simd/avx2.h, simd/portable.h) defines what is declared
// here, and the second half of the file builds the rest on it. Unless a line below says otherwise, lane l of a
// result depends on lane l of the arguments only, and has the same bits on every back end, namely those of the
// scalar expression in the comment compiled with -ffp-contract=off. (As in scalar code, which NaN comes out of
// arithmetic on NaNs is open.)
//
// Why a layer of our own and not a library: notes/simd.md.

#ifndef LOCKSTEP_COMMON_SIMD_H
#define LOCKSTEP_COMMON_SIMD_H

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

// A lane operation is one instruction or a few: a call would cost more, and pass sixteen lanes through memory.
#define LOCKSTEP_INLINE [[gnu::always_inline]] inline

namespace lockstep {

inline constexpr int lanes = 16;

struct floatv;   // floatv(float x) is implicit and sets every lane to x; floatv() is uninitialised
struct intv;     // intv(std::int32_t x), likewise
struct maskv;    // one truth value a lane; a lane is active where it is true
struct Records;  // floatv field[8]
struct Quads;    // floatv field[4]
struct recordv;  // one record of eight floats; recordv(float x) sets them all to x
struct Halves;   // floatv first, second

// Memory. Any alignment. Memory of inactive lanes is not touched, it need not even be there.
floatv load(const float* p);  // p[l]
intv load(const std::int32_t* p);
floatv load(const float* p, maskv mask);  // mask ? p[l] : 0
intv load(const std::int32_t* p, maskv mask);
void store(float* p, floatv v);  // p[l] = v
void store(std::int32_t* p, intv v);
void store(float* p, floatv v, maskv mask);  // if (mask) p[l] = v
void store(std::int32_t* p, intv v, maskv mask);
// A store of what is not read soon: past the caches, where the processor can, so that the line is not fetched first.
// p is 64-byte aligned. Other threads may read it after the writer has called finish_streams, and a barrier.
void stream(float* p, floatv v);
void finish_streams();
floatv gather(const float* base, intv index);  // base[index]
intv gather(const std::int32_t* base, intv index);
floatv gather(const float* base, intv index, maskv mask);  // mask ? base[index] : 0
intv gather(const std::int32_t* base, intv index, maskv mask);

// Two neighbours: first = base[index], second = base[index + 1]. One access of eight bytes a lane. index < INT32_MAX.
Halves gather_pairs(const float* base, intv index);
// Four neighbours: field[f] = base[index + f]. One access of sixteen bytes a lane, where a gather takes one a value.
Quads gather_fours(const float* base, intv index);

// Sixteen whole records, one access each: lane l holds the fields of record index[l]. Records may hold integers among
// their floats, see bits_of. Offsets have 64 bits, so every index from 0 to INT32_MAX will do. Active indices of a
// store differ. Records of eight floats, 32-byte aligned.
Records load_records(const float* records, const std::int32_t* index);  // field[f] lane l = records[8 * index[l] + f]
void store_records(float* records, const std::int32_t* index, const Records& r, maskv mask);  // and back where mask
void store_records(float* records, const std::int32_t* index, const Records& r);
// Records of four floats, 16-byte aligned. The store takes 16 moves; on Zen 4 four scatters would take 64.
Quads load_quads(const float* records, const std::int32_t* index);  // field[f] lane l = records[4 * index[l] + f]
void store_quads(float* records, const std::int32_t* index, Quads quads, maskv mask);

// One record, its eight floats at once: for updates that must be made one record after another.
recordv load_record(const float* p);      // p[f], 32-byte aligned
void store_record(float* p, recordv r);   // p[f] = field f, 32-byte aligned
recordv repeat_pair(const float* p);      // p[f % 2]
recordv operator+(recordv a, recordv b);  // each rounds once, to nearest
recordv operator-(recordv a, recordv b);
recordv operator*(recordv a, recordv b);
void store_pairs(float* p, floatv a, floatv b);  // p[2 l] = a, p[2 l + 1] = b

// Arithmetic. Each operation on floatv rounds once, to nearest; intv wraps around.
floatv operator+(floatv a, floatv b);
floatv operator-(floatv a, floatv b);
floatv operator*(floatv a, floatv b);
floatv operator/(floatv a, floatv b);
floatv operator-(floatv a);                // flips the sign, also that of zero and NaN
floatv min(floatv a, floatv b);            // a < b ? a : b, so b when either is NaN or both are zero
floatv max(floatv a, floatv b);            // a > b ? a : b, so b when either is NaN or both are zero
floatv abs(floatv a);                      // clears the sign
floatv sqrt(floatv a);                     // correctly rounded
floatv fma(floatv a, floatv b, floatv c);  // a * b + c rounded once, on every back end
intv operator+(intv a, intv b);
intv operator-(intv a, intv b);
intv operator*(intv a, intv b);  // the low 32 bits of the product
intv operator&(intv a, intv b);
intv operator|(intv a, intv b);
intv operator^(intv a, intv b);
intv operator<<(intv a, intv n);  // 0 <= n < 32
intv operator>>(intv a, intv n);  // 0 <= n < 32, arithmetic: copies of the sign come in
intv min(intv a, intv b);
intv max(intv a, intv b);
intv to_int(floatv a);    // truncated; INT32_MIN where that does not fit, and for NaN
floatv to_float(intv a);  // rounded to nearest
intv bits_of(floatv a);   // the same 32 bits
floatv float_of_bits(intv a);

// Comparison. With a NaN, != is true and all others are false.
maskv operator<(floatv a, floatv b);
maskv operator<=(floatv a, floatv b);
maskv operator>(floatv a, floatv b);
maskv operator>=(floatv a, floatv b);
maskv operator==(floatv a, floatv b);
maskv operator!=(floatv a, floatv b);
maskv operator<(intv a, intv b);
maskv operator<=(intv a, intv b);
maskv operator>(intv a, intv b);
maskv operator>=(intv a, intv b);
maskv operator==(intv a, intv b);
maskv operator!=(intv a, intv b);

// Masks.
maskv operator&(maskv a, maskv b);
maskv operator|(maskv a, maskv b);
maskv operator^(maskv a, maskv b);
maskv operator~(maskv a);
maskv operator!(maskv a);        // the same, under the name that bool has for it
std::uint32_t bits(maskv mask);  // bit l is lane l; bits 16 and up are 0
bool any(maskv mask);
bool all(maskv mask);
bool none(maskv mask);
int count(maskv mask);               // how many lanes are active
intv lane_index();                   // 0, 1, ... 15
maskv lanes_of(std::uint32_t bits);  // the inverse of bits()
maskv first_lanes(int n);            // lane_index() < n: none for n <= 0, all for n >= 16; the mask of a loop's tail
floatv select(maskv mask, floatv a, floatv b);  // mask ? a : b; both are computed
intv select(maskv mask, intv a, intv b);
// where(mask, v) = x   changes the active lanes of v and keeps the others; also += -= *= /= &= |= ^= <<= >>=
// a += b and so on     wherever a + b is declared above

// Across lanes. Reductions run in one fixed tree: lane l with l + 8, then with l + 4, l + 2, l + 1.
float reduce_add(floatv v);             // ((v0 + v8) + (v4 + v12)) + ...; another order than a loop's, so other bits
float reduce_min(floatv v);             // by min(a, b) above: of a NaN, or of zeros, which lane wins follows the tree
float reduce_max(floatv v);             // by max(a, b), likewise
std::int32_t reduce_add(intv v);        // wraps around
floatv compress(maskv mask, floatv v);  // the active lanes, moved to the front in order; the rest 0
intv compress(maskv mask, intv v);
floatv permute(floatv v, intv index);     // v[index & 15]
floatv shift_up(floatv v, float first);   // first, v0, ... v14
floatv shift_down(floatv v, float last);  // v1, ... v15, last
void transpose(floatv (&row)[lanes]);     // row[i] lane j and row[j] lane i change places

// picks_from_vectors, a constant, is for kernels whose sixteen lanes read numbers of a few vectors. If it is true, they
// load these vectors and permute them; else they load each number. Permuting takes less time where it is one
// instruction. The portable lanes permute, too, so that the sanitizers see what AVX-512 runs.

// Partners in a row of 32 floats, a and then b, cut into blocks of 2 G, where G is 1 or 2: `first` gets the first G of
// every block, `second` the last G, partners (G apart in the row) in the same lane. Which block goes to which lanes is
// left to the back end, so that each is one shuffle; join puts all back in order.
template <int G>
Halves split(floatv a, floatv b);
template <int G>
void join(Halves halves, floatv& a, floatv& b);

// Where record i begins. The product needs more than 32 bits from record 2^28 on.
template <int floats, class Float>
LOCKSTEP_INLINE Float* record_at(Float* records, std::int32_t i) {
  return records + std::ptrdiff_t{floats} * i;
}

// Stores a register as an array of numbers, at any alignment. The store of an intrinsic may change objects of all
// types: after each one a loop would load its addresses and strides again.
template <class Number, class Register>
LOCKSTEP_INLINE void store_numbers(Number* p, Register v) {
  typedef Number Numbers __attribute__((vector_size(sizeof(Register)), aligned(alignof(Number))));
  *reinterpret_cast<Numbers*>(p) = reinterpret_cast<Numbers>(v);
}

}  // namespace lockstep

#if defined(LOCKSTEP_ISA_AVX512)
#include "simd/avx512.h"
#elif defined(LOCKSTEP_ISA_AVX2)
#include "simd/avx2.h"
#elif defined(LOCKSTEP_ISA_PORTABLE)
#include "simd/portable.h"
#else
#error "define LOCKSTEP_ISA_AVX512, LOCKSTEP_ISA_AVX2 or LOCKSTEP_ISA_PORTABLE (make ISA=... does)"
#endif

namespace lockstep {

LOCKSTEP_INLINE maskv operator>(floatv a, floatv b) { return b < a; }
LOCKSTEP_INLINE maskv operator>=(floatv a, floatv b) { return b <= a; }
LOCKSTEP_INLINE maskv operator>(intv a, intv b) { return b < a; }
LOCKSTEP_INLINE maskv operator>=(intv a, intv b) { return b <= a; }

LOCKSTEP_INLINE maskv operator!(maskv a) { return ~a; }

LOCKSTEP_INLINE bool any(maskv mask) { return bits(mask) != 0; }
LOCKSTEP_INLINE bool all(maskv mask) { return bits(mask) == 0xffff; }
LOCKSTEP_INLINE bool none(maskv mask) { return bits(mask) == 0; }
LOCKSTEP_INLINE int count(maskv mask) { return std::popcount(bits(mask)); }
LOCKSTEP_INLINE maskv first_lanes(int n) { return lane_index() < n; }

LOCKSTEP_INLINE void store_records(float* records, const std::int32_t* index, const Records& r) {
  store_records(records, index, r, lanes_of(0xffff));
}

template <class V>
concept Lanes = std::same_as<V, floatv> || std::same_as<V, intv> || std::same_as<V, maskv>;

// The right-hand side does not take part in deduction, so that `v += 1.0f` broadcasts.
template <Lanes V>
LOCKSTEP_INLINE V& operator+=(V& a, std::type_identity_t<V> b) {
  return a = a + b;
}
template <Lanes V>
LOCKSTEP_INLINE V& operator-=(V& a, std::type_identity_t<V> b) {
  return a = a - b;
}
template <Lanes V>
LOCKSTEP_INLINE V& operator*=(V& a, std::type_identity_t<V> b) {
  return a = a * b;
}
template <Lanes V>
LOCKSTEP_INLINE V& operator/=(V& a, std::type_identity_t<V> b) {
  return a = a / b;
}
template <Lanes V>
LOCKSTEP_INLINE V& operator&=(V& a, std::type_identity_t<V> b) {
  return a = a & b;
}
template <Lanes V>
LOCKSTEP_INLINE V& operator|=(V& a, std::type_identity_t<V> b) {
  return a = a | b;
}
template <Lanes V>
LOCKSTEP_INLINE V& operator^=(V& a, std::type_identity_t<V> b) {
  return a = a ^ b;
}
template <Lanes V>
LOCKSTEP_INLINE V& operator<<=(V& a, std::type_identity_t<V> b) {
  return a = a << b;
}
template <Lanes V>
LOCKSTEP_INLINE V& operator>>=(V& a, std::type_identity_t<V> b) {
  return a = a >> b;
}

// The active lanes of a variable, as something to assign to.
template <class V>
struct Where {
  maskv mask;
  V& variable;

  LOCKSTEP_INLINE void operator=(V v) const { variable = select(mask, v, variable); }
  LOCKSTEP_INLINE void operator+=(V v) const { *this = variable + v; }
  LOCKSTEP_INLINE void operator-=(V v) const { *this = variable - v; }
  LOCKSTEP_INLINE void operator*=(V v) const { *this = variable * v; }
  LOCKSTEP_INLINE void operator/=(V v) const { *this = variable / v; }
  LOCKSTEP_INLINE void operator&=(V v) const { *this = variable & v; }
  LOCKSTEP_INLINE void operator|=(V v) const { *this = variable | v; }
  LOCKSTEP_INLINE void operator^=(V v) const { *this = variable ^ v; }
  LOCKSTEP_INLINE void operator<<=(V v) const { *this = variable << v; }
  LOCKSTEP_INLINE void operator>>=(V v) const { *this = variable >> v; }
};

template <class V>
LOCKSTEP_INLINE Where<V> where(maskv mask, V& variable) {
  return {mask, variable};
}

// A back end runs the tree in registers that shrink with it, hence `auto`.
LOCKSTEP_INLINE float reduce_add(floatv v) {
  return reduce_lanes(v, [](auto a, auto b) { return a + b; });
}
LOCKSTEP_INLINE float reduce_min(floatv v) {
  return reduce_lanes(v, [](auto a, auto b) { return min(a, b); });
}
LOCKSTEP_INLINE float reduce_max(floatv v) {
  return reduce_lanes(v, [](auto a, auto b) { return max(a, b); });
}

}  // namespace lockstep

#endif
