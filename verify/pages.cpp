#include "verify/pages.h"

#include <malloc.h>
#include <omp.h>
#include <unistd.h>

#include <cstddef>

#include "common/array.h"

namespace lockstep::verify {
namespace {

int team = 1;

void write_first(char* block, std::size_t bytes) {
  const std::size_t page = sysconf(_SC_PAGESIZE);
  // An iteration writes to its own page. No value is there yet.
#pragma omp parallel for schedule(static) num_threads(team)
  for (std::size_t at = 0; at < bytes; at += page) block[at] = 0;
}

}  // namespace

PagesOfTeam::PagesOfTeam(int threads) {
  malloc_trim(0);  // pages that are free have been given to a node already: they go back to the system
  team = threads;
  on_large_block = write_first;
}

PagesOfTeam::~PagesOfTeam() { on_large_block = nullptr; }

}  // namespace lockstep::verify
