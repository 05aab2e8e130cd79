#include "verify/held_team.h"

#include <omp.h>

#include <chrono>
#include <cstdlib>
#include <exception>

#include "verify/crew.h"

namespace lockstep::verify {
namespace {

// clang's OpenMP runtime does not call the functions that record_wraps.cpp wraps.
#ifdef __clang__
constexpr bool libgomp = false;
#else
constexpr bool libgomp = true;
#endif

bool holds_teams() { return libgomp && !std::getenv("OMP_WAIT_POLICY") && !std::getenv("GOMP_SPINCOUNT"); }

}  // namespace

const char* way_to_wait() { return holds_teams() ? "held team" : "OpenMP's runtime"; }

double cores_shared_for() { return crew ? std::chrono::duration<double>(lockstep::cores_shared_for()).count() : 0; }

void rest_team(const std::function<void()>& work) {
  if (!crew) return work();
  struct Rest {
    Rest() { crew->set_resting(true); }
    ~Rest() { crew->set_resting(false); }
  } rest;
  work();
}

void hold_team(int threads, const std::function<void()>& work) {
  omp_set_num_threads(threads);
  if (threads == 1 || !holds_teams()) return work();
  Crew mine;
  std::exception_ptr thrown;
  // Thread 0 does the work, and the others serve its regions. `crew` is set after the barrier, when no thread calls
  // OpenMP for itself any more.
#pragma omp parallel num_threads(threads)
  {
    const int thread = omp_get_thread_num();
    if (thread == 0) mine.set_size(omp_get_num_threads(), threads);
#pragma omp barrier
    if (thread > 0) {
      mine.serve();
    } else {
      crew = &mine;
      try {
        work();
      } catch (...) {
        thrown = std::current_exception();
      }
      crew = nullptr;
      mine.dismiss();
    }
  }
  if (thrown) std::rethrow_exception(thrown);
}

}  // namespace lockstep::verify
