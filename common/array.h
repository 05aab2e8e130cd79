// Arrays that lanes touch: 64-byte aligned and padded, so that sixteen lanes may be loaded from any element on.
#pragma once

#include <sys/mman.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <new>
#include <vector>

namespace lockstep {

inline constexpr std::size_t array_alignment = 64;  // one cache line, one AVX-512 vector

// If set, it is called with each new block of at least `large_block` bytes before anything is written there. The thread
// that first writes to a page decides on which node of a machine's memory the page is (verify/pages.h). It may change
// only while no other thread allocates.
inline constexpr std::size_t large_block = 1 << 20;
inline void (*on_large_block)(char* block, std::size_t bytes) = nullptr;

// A loop through a large array waits for an address at each page of 4 KB. So the system is asked for pages of 2 MB
// where large blocks are. If it has none, or is set to give none (transparent_hugepage/enabled: never), pages are
// ordinary ones. Blocks are not aligned to such pages: the heap would not find room for them in what others left.
inline void ask_for_large_pages(const char* block, std::size_t bytes) {
  constexpr std::uintptr_t page = 2 << 20;
  const auto address = reinterpret_cast<std::uintptr_t>(block);
  const std::uintptr_t begin = address / page * page, end = (address + bytes + page - 1) / page * page;
  madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE);  // advice: a failure changes nothing
}

// The system places large blocks at page boundaries. If twenty arrays of particles all began there, their elements of
// one index would compete for the same few sets of the first-level cache (rebuild_grid took 28 % of a frame of 100K
// particles; it takes 6 %). So each block begins some cache lines further into its page than the block before.
template <class T>
struct AlignedAllocator {
  using value_type = T;
  AlignedAllocator() = default;
  template <class U>
  AlignedAllocator(const AlignedAllocator<U>&) {}

  T* allocate(std::size_t n) {
    static std::atomic<std::size_t> blocks = 0;
    const std::size_t lines_in = 1 + 3 * blocks++ % 61;
    // As in the standard library's allocator; half of it, since the lines in front must fit, too.
    if (n > std::numeric_limits<std::ptrdiff_t>::max() / sizeof(T) / 2) throw std::bad_array_new_length();
    const std::size_t bytes = lines_in * array_alignment + n * sizeof(T);
    char* block = static_cast<char*>(::operator new (bytes, std::align_val_t{array_alignment}));
    if (bytes >= large_block) {
      ask_for_large_pages(block, bytes);
      if (on_large_block) on_large_block(block, bytes);
    }
    void** array = reinterpret_cast<void**>(block + lines_in * array_alignment);
    array[-1] = block;  // for deallocate
    return reinterpret_cast<T*>(array);
  }
  void deallocate(T* array, std::size_t) {
    ::operator delete (reinterpret_cast<void**>(array)[-1], std::align_val_t{array_alignment});
  }
  bool operator==(const AlignedAllocator&) const = default;
};

template <class T>
using Array = std::vector<T, AlignedAllocator<T>>;

// Elements to allocate for n: whole vectors of sixteen, and one vector more, so that an unaligned load of sixteen that
// starts at any of the n elements stays inside. Lanes beyond n are read but never change a result: kernels mask them.
constexpr std::size_t padded(std::size_t n) { return (n + 15) / 16 * 16 + 16; }

}  // namespace lockstep
