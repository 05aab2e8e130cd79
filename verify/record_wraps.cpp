// The linker's --wrap sends every call that a kernel makes to OpenMP's runtime, libgomp, or to flags
// (common/flags.h) to the __wrap_ functions of this file. While a record is being made, the Recorder answers them.
// While a team is held, the Crew answers those with which threads fork, join and wait. All others are passed on; the
// functions that they were meant for are then named __real_. Regions note the size of their team (team.h). The Makefile
// lists the functions, and tests/scale_test.cpp checks that none is missing.
//
// Static loops need no function here: the compiler divides them by omp_get_thread_num() and omp_get_num_threads().
#include <omp.h>

#include "verify/crew.h"
#include "verify/recorder.h"
#include "verify/team.h"

namespace {

using lockstep::verify::Crew;
using lockstep::verify::crew;

// A region, and what is done in its team before it begins.
struct Region {
  void (*region)(void*);
  void* data;
};

// Notes how large the team is.
void run_observed(void* data) {
  const Region& observed = *static_cast<const Region*>(data);
  if (omp_get_level() == 1 && omp_get_thread_num() == 0) lockstep::verify::note_team_size(omp_get_num_threads());
  observed.region(observed.data);
}

// Whether the crew runs a region that asks for `threads` threads (0: no number is asked for).
bool crew_runs(unsigned threads) {
  return crew && !crew->resting() && !Crew::in_region() &&
         (threads == 0 || threads == static_cast<unsigned>(crew->size()));
}

// Whether libgomp runs a region on one thread, since it is inside another or the crew rests.
bool runs_alone() { return Crew::in_region() || (crew && crew->resting()); }

}  // namespace

extern "C" {

using lockstep::verify::recorder;
using lockstep::verify::recorder_of_locks;
using lockstep::verify::SharedWork;
using Count = unsigned long long;

#define WRAP(result, name, parameters, pass_on, answer) \
  result __real_##name parameters;                      \
  result __wrap_##name parameters {                     \
    if (!recorder) return __real_##name pass_on;        \
    return answer;                                      \
  }

// A region that begins with a loop or a list of sections which the team shares out.
struct SharingRegion {
  Region region;
  SharedWork work;
};
// Of libgomp's interface to gcc. Without `first`, it begins a loop and takes no chunk of it.
bool GOMP_loop_start(long begin, long end, long step, long schedule, long chunk, long* first, long* last,
                     std::uintptr_t* reductions, void** memory);
static void run_sharing(void* data) {
  constexpr long dynamic = 2;
  const auto& [region, work] = *static_cast<const SharingRegion*>(data);
  GOMP_loop_start(work.next, work.end, work.step, dynamic, work.chunk, nullptr, nullptr, nullptr, nullptr);
  region.region(region.data);
}

#define WRAP_REGION(name, parameters, pass_on, answer, run)               \
  void __real_##name parameters;                                          \
  void __wrap_##name parameters {                                         \
    if (recorder) return answer;                                          \
    if (crew_runs(threads)) return run;                                   \
    if (runs_alone()) return Crew::alone([&] { __real_##name pass_on; }); \
    Region observed = {region, data};                                     \
    region = run_observed, data = &observed;                              \
    __real_##name pass_on;                                                \
  }

static void run_in_crew(void (*region)(void*), void* data, const SharedWork& work) {
  SharingRegion sharing = {{region, data}, work};
  crew->parallel(run_sharing, &sharing);
}

WRAP_REGION(GOMP_parallel, (void (*region)(void*), void* data, unsigned threads, unsigned flags),
            (region, data, threads, flags), recorder->parallel(region, data, threads, {}), crew->parallel(region, data))
WRAP_REGION(GOMP_parallel_sections,
            (void (*region)(void*), void* data, unsigned threads, unsigned count, unsigned flags),
            (region, data, threads, count, flags),
            recorder->parallel(region, data, threads, SharedWork{1, count + 1, 1, 1}),
            run_in_crew(region, data, {1, count + 1, 1, 1}))
WRAP_REGION(GOMP_parallel_loop_nonmonotonic_dynamic,
            (void (*region)(void*), void* data, unsigned threads, long begin, long end, long step, long chunk,
             unsigned flags),
            (region, data, threads, begin, end, step, chunk, flags),
            recorder->parallel(region, data, threads, SharedWork{begin, end, step, chunk}),
            run_in_crew(region, data, {begin, end, step, chunk}))
void __real_GOMP_barrier();
void __wrap_GOMP_barrier() {
  if (recorder) return recorder->barrier();
  if (Crew::in_region()) return crew->barrier();
  __real_GOMP_barrier();
}
WRAP(bool, GOMP_loop_nonmonotonic_dynamic_start, (long begin, long end, long step, long chunk, long* first, long* last),
     (begin, end, step, chunk, first, last), recorder->loop_start({begin, end, step, chunk}, *first, *last))
WRAP(bool, GOMP_loop_nonmonotonic_dynamic_next, (long* first, long* last), (first, last),
     recorder->next_chunk(*first, *last))
WRAP(bool, GOMP_loop_ull_nonmonotonic_dynamic_start,
     (bool up, Count begin, Count end, Count step, Count chunk, Count* first, Count* last),
     (up, begin, end, step, chunk, first, last),
     recorder->loop_start({long(begin), long(end), long(step), long(chunk)}, *reinterpret_cast<long*>(first),
                          *reinterpret_cast<long*>(last)))
WRAP(bool, GOMP_loop_ull_nonmonotonic_dynamic_next, (Count * first, Count* last), (first, last),
     recorder->next_chunk(*reinterpret_cast<long*>(first), *reinterpret_cast<long*>(last)))
WRAP(void, GOMP_loop_end_nowait, (), (), void())
void __real_GOMP_loop_end();
void __wrap_GOMP_loop_end() {
  if (recorder) return recorder->barrier();
  if (!Crew::in_region()) return __real_GOMP_loop_end();
  __real_GOMP_loop_end_nowait();
  crew->barrier();
}
WRAP(unsigned, GOMP_sections_next, (), (), recorder->next_section())
WRAP(void, GOMP_sections_end_nowait, (), (), void())
WRAP(bool, GOMP_single_start, (), (), recorder->single())
WRAP(int, omp_get_thread_num, (), (), recorder->thread())
WRAP(int, omp_get_num_threads, (), (), recorder->alone() ? 1 : recorder->cores())
WRAP(int, omp_get_max_threads, (), (), recorder->cores())
#define WRAP_LOCK(name, answer)                         \
  void __wrap_##name(omp_lock_t* lock) {                \
    if (!recorder_of_locks) return __real_##name(lock); \
    recorder_of_locks->answer(lock);                    \
  }
WRAP_LOCK(omp_set_lock, set)
WRAP_LOCK(omp_unset_lock, unset)
WRAP(void, lockstep_post, (lockstep::Flag * flag, int value), (flag, value), recorder->post(flag, value))
WRAP(void, lockstep_await, (const lockstep::Flag* flag, int value), (flag, value), recorder->await(flag, value))
}
