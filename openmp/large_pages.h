// Memory in large pages: with ordinary ones, touching a large array for the first time costs a page fault every 4 KB.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <new>

#include "common/array.h"

namespace lockstep::openmp {

// Room for that many floats, uninitialised, aligned for lanes. Throws std::bad_alloc.
class LargePages {
 public:
  explicit LargePages(std::size_t floats) {
    constexpr std::size_t large_page = 2 << 20;
    const std::size_t bytes = (floats * sizeof(float) + large_page) / large_page * large_page;
    memory_ = std::aligned_alloc(large_page, bytes);
    if (!memory_) throw std::bad_alloc();
    ask_for_large_pages(static_cast<char*>(memory_), bytes);
  }
  ~LargePages() { std::free(memory_); }
  LargePages(const LargePages&) = delete;
  LargePages& operator=(const LargePages&) = delete;
  float* floats() const { return static_cast<float*>(memory_); }

 private:
  void* memory_;
};

}  // namespace lockstep::openmp
