// The linker's --wrap sends every call that a kernel makes to OpenMP's runtime, libgomp, to the __wrap_ functions of
// this file. They pass the call on to libgomp, whose functions are then named __real_, unless a record is being made:
// then the Recorder answers. Regions that are passed on note the size of their team (team.h). The Makefile lists the functions, and tests/scale_test.cpp checks that none is missing.
//
// Static loops need no function here: the compiler divides them by omp_get_thread_num() and omp_get_num_threads().
#include <omp.h>

#include "verify/recorder.h"
#include "verify/team.h"

namespace {

// A region that notes how large its team is, and then does what it has to.
struct Observed {
  void (*region)(void*);
  void* data;
};
void run_observed(void* data) {
  const Observed& observed = *static_cast<const Observed*>(data);
  if (omp_get_level() == 1 && omp_get_thread_num() == 0) lockstep::verify::note_team_size(omp_get_num_threads());
  observed.region(observed.data);
}

}  // namespace

extern "C" {

using lockstep::verify::recorder;
using lockstep::verify::SharedWork;
using Count = unsigned long long;

#define WRAP(result, name, parameters, pass_on, answer) \
  result __real_##name parameters;                      \
  result __wrap_##name parameters {                     \
    if (!recorder) return __real_##name pass_on;        \
    return answer;                                      \
  }

#define WRAP_REGION(name, parameters, pass_on, answer) \
  void __real_##name parameters;                       \
  void __wrap_##name parameters {                      \
    if (recorder) return answer;                       \
    Observed observed = {region, data};                \
    region = run_observed, data = &observed;           \
    __real_##name pass_on;                             \
  }

WRAP_REGION(GOMP_parallel, (void (*region)(void*), void* data, unsigned threads, unsigned flags),
            (region, data, threads, flags), recorder->parallel(region, data, threads, {}))
WRAP_REGION(GOMP_parallel_sections,
            (void (*region)(void*), void* data, unsigned threads, unsigned count, unsigned flags),
            (region, data, threads, count, flags),
            recorder->parallel(region, data, threads, SharedWork{1, count + 1, 1, 1}))
WRAP_REGION(GOMP_parallel_loop_nonmonotonic_dynamic,
            (void (*region)(void*), void* data, unsigned threads, long begin, long end, long step, long chunk,
             unsigned flags),
            (region, data, threads, begin, end, step, chunk, flags),
            recorder->parallel(region, data, threads, SharedWork{begin, end, step, chunk}))
WRAP(void, GOMP_barrier, (), (), recorder->barrier())
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
WRAP(void, GOMP_loop_end, (), (), recorder->barrier())
WRAP(void, GOMP_loop_end_nowait, (), (), void())
WRAP(unsigned, GOMP_sections_next, (), (), recorder->next_section())
WRAP(void, GOMP_sections_end_nowait, (), (), void())
WRAP(bool, GOMP_single_start, (), (), recorder->single())
WRAP(int, omp_get_thread_num, (), (), recorder->thread())
WRAP(int, omp_get_num_threads, (), (), recorder->alone() ? 1 : recorder->cores())
WRAP(int, omp_get_max_threads, (), (), recorder->cores())
WRAP(void, omp_set_lock, (omp_lock_t * lock), (lock), recorder->set(lock))
WRAP(void, omp_unset_lock, (omp_lock_t * lock), (lock), recorder->unset(lock))
}
