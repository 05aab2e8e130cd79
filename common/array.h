// Arrays that lanes touch: 64-byte aligned and padded, so that sixteen lanes may be loaded from any element on.
#pragma once

#include <cstddef>
#include <new>
#include <vector>

namespace lockstep {

inline constexpr std::size_t array_alignment = 64;  // one cache line, one AVX-512 vector

template <class T>
struct AlignedAllocator {
  using value_type = T;
  AlignedAllocator() = default;
  template <class U>
  AlignedAllocator(const AlignedAllocator<U>&) {}
  T* allocate(std::size_t n) { return static_cast<T*>(::operator new(n * sizeof(T), std::align_val_t{array_alignment})); }
  void deallocate(T* p, std::size_t) { ::operator delete(p, std::align_val_t{array_alignment}); }
  bool operator==(const AlignedAllocator&) const = default;
};

template <class T>
using Array = std::vector<T, AlignedAllocator<T>>;

// Elements to allocate for n: whole vectors of sixteen, and one vector more, so that an unaligned load of sixteen that
// starts at any of the n elements stays inside. Lanes beyond n are read but never change a result: kernels mask them.
constexpr std::size_t padded(std::size_t n) { return (n + 15) / 16 * 16 + 16; }

}  // namespace lockstep
