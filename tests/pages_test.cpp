// Pages of large arrays are given when a team writes them, before anything else does.
#include "verify/pages.h"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "common/array.h"

namespace lockstep::verify {
namespace {

// For each whole page within the block: whether it is in memory.
std::vector<unsigned char> pages_there(char* from, std::size_t bytes) {
  const std::uintptr_t page = sysconf(_SC_PAGESIZE),
                       begin = (reinterpret_cast<std::uintptr_t>(from) + page - 1) / page * page,
                       end = (reinterpret_cast<std::uintptr_t>(from) + bytes) / page * page;
  std::vector<unsigned char> there((end - begin) / page);
  EXPECT_EQ(mincore(reinterpret_cast<void*>(begin), end - begin, there.data()), 0);
  return there;
}

std::ptrdiff_t in_memory(const std::vector<unsigned char>& pages) {
  return std::ranges::count_if(pages, [](unsigned char page) { return page & 1; });
}

TEST(Pages, OfLargeBlocksAreWrittenByATeam) {
  constexpr std::size_t n = 64 << 20;  // beyond what the allocator keeps for itself
  AlignedAllocator<char> allocator;
  const auto in_memory_after_allocation = [&] {
    char* const block = allocator.allocate(n);
    const auto pages = pages_there(block, n);
    allocator.deallocate(block, n);
    return std::pair(in_memory(pages), std::ssize(pages));
  };
  // The system may give large pages, so that what the allocator writes at the beginning is more than one page.
  const auto [untouched, all] = in_memory_after_allocation();
  EXPECT_LT(untouched, all / 8);
  {
    const PagesOfTeam near(3);
    const auto [touched, of] = in_memory_after_allocation();
    EXPECT_EQ(touched, of);
  }
  EXPECT_LT(in_memory_after_allocation().first, all / 8);
}

}  // namespace
}  // namespace lockstep::verify
