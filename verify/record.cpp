// How it works: the linker's --wrap sends every call of the kernels to OpenMP's runtime, libgomp, through the functions at the end of this
// file (the Makefile lists them, tests/scale_test.cpp checks that none is missing). They pass it on, unless a record is being made. Static
// loops need nothing: the compiler divides them by omp_get_thread_num() and omp_get_num_threads().
#include "verify/record.h"

#include <omp.h>
#include <sys/mman.h>
#include <ucontext.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <new>
#include <optional>
#include <span>
#include <vector>

extern "C" {
void __real_omp_set_lock(omp_lock_t* lock);
void __real_omp_unset_lock(omp_lock_t* lock);
}

namespace lockstep::verify {
namespace {

// A stack as large as those that OpenMP gives its threads; pages that are never touched cost nothing.
class Stack {
 public:
  Stack() : at_(mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE | MAP_STACK, -1, 0)) {
    if (at_ == MAP_FAILED) throw std::bad_alloc();
  }
  ~Stack() { munmap(at_, size); }
  Stack(const Stack&) = delete;
  Stack& operator=(const Stack&) = delete;
  void* begin() const { return at_; }
  static constexpr std::size_t size = 8 << 20;

 private:
  void* at_;
};

struct Member {
  Stack stack;
  ucontext_t context;
  enum { ready, waiting, done } state;
  double worked;       // ns in this region, or since when the others' work makes it wait
  std::size_t shared;  // how many loops, sections and singles it has met in this region
};

// What is left of a loop, of a list of sections, or of a single, that a team shares out.
struct Shared {
  long next, end, step, chunk;

  bool take(long& first, long& last) {
    if (step > 0 ? next >= end : next <= end) return false;
    first = next;
    last = next = step > 0 ? std::min(end, next + chunk * step) : std::max(end, next + chunk * step);
    return true;
  }
};

// Kept from record to record, as OpenMP keeps its threads: a stack's pages cost most when they are touched for the first time.
std::span<const std::unique_ptr<Member>> team(int cores) {
  static std::vector<std::unique_ptr<Member>> members;
  while (std::ssize(members) < cores) members.push_back(std::make_unique<Member>());
  return std::span(members).first(cores);
}

// A thread of OpenMP's own on which members run, so that each core's caches hold what its own members work on, and what others wrote
// comes from another core, as it would. Only one host runs at a time. The first is the one that makes the record.
class Host {
 public:
  // Runs m until it yields or ends.
  void run(Member& m) {
    turn_.store(&m, std::memory_order_release);
    while (turn_.load(std::memory_order_acquire)) pause();
  }
  // What the thread does until `all_done`. It does not give up its core between turns: the system might have others run there, or move it.
  void serve(const std::atomic<bool>& all_done) {
    while (!all_done.load(std::memory_order_acquire)) {
      if (Member* const m = turn_.load(std::memory_order_acquire)) {
        swapcontext(&scheduler_, &m->context);
        turn_.store(nullptr, std::memory_order_release);
      } else {
        pause();
      }
    }
  }
  ucontext_t* scheduler() { return &scheduler_; }

 private:
  static void pause() {
#if defined(__x86_64__)
    __builtin_ia32_pause();
#endif
  }

  ucontext_t scheduler_;
  std::atomic<Member*> turn_ = nullptr;  // who is to run, until it has
};

class Recorder {
 public:
  Recorder(int cores, double (*clock)(), double clock_ns, Locks locks)
      : clock_(clock), clock_ns_(clock_ns), locks_(locks), members_(team(cores)), hosts_(std::min(cores, omp_get_num_procs())) {
    record_.cores = cores;
  }

  int hosts() const { return static_cast<int>(hosts_.size()); }
  Host& host(int h) { return hosts_[h]; }

  Record make(const std::function<void()>& work) {
    resumed_ = clock_();
    work();
    record_.serial_ns.push_back(stretch());
    return std::move(record_);
  }

  int cores() const { return record_.cores; }
  bool alone() const { return running_ < 0 || nested_ > 0; }
  int thread() const { return alone() ? 0 : running_; }

  // Runs a region, which shares out `first` from its beginning, if anything.
  void parallel(void (*region)(void*), void* data, unsigned threads, std::optional<Shared> first) {
    if (running_ >= 0 || threads == 1) {
      const Shared outer = alone_;
      if (first) alone_ = *first;
      ++nested_;
      region(data);
      --nested_;
      alone_ = outer;
      return;
    }
    record_.serial_ns.push_back(stretch());
    record_.regions.emplace_back(cores());
    shared_.clear();
    if (first) shared_.push_back(*first);
    region_ = region;
    data_ = data;
    for (int i = 0; i < cores(); ++i) {
      Member& m = *members_[i];
      m.state = Member::ready, m.worked = 0, m.shared = shared_.size();
      getcontext(&m.context);
      m.context.uc_stack.ss_sp = m.stack.begin();
      m.context.uc_stack.ss_size = Stack::size;
      m.context.uc_link = host_of(i).scheduler();
      makecontext(&m.context, run_member, 0);
    }
    while (const std::optional<int> next = next_member()) {
      running_ = *next;
      Host& host = host_of(running_);
      if (&host == &hosts_.front())
        swapcontext(host.scheduler(), &members_[running_]->context);
      else
        host.run(*members_[running_]);
    }
    running_ = -1;
    resumed_ = clock_();
  }

  void barrier() {
    if (alone()) return;
    end_work();
    add({Event::barrier});
    yield(Member::waiting);
  }

  // The next chunk of the loop or list of sections that the thread is in, once those who have worked less have taken theirs.
  bool next_chunk(long& first, long& last) {
    if (alone()) return alone_.take(first, last);
    const std::size_t which = members_[running_]->shared - 1;
    end_work();
    add({Event::dispatch, 0, reinterpret_cast<const void*>(which)});
    yield(Member::ready);
    return shared_[which].take(first, last);
  }

  bool loop_start(const Shared& loop, long& first, long& last) {
    meet(loop);
    return next_chunk(first, last);
  }

  unsigned next_section() {
    long section, end;
    return next_chunk(section, end) ? section : 0;
  }

  // Whether this thread is the one that runs it.
  bool single() { return meet({}); }

  void set(omp_lock_t* lock) {
    note(Event::lock, lock);
    __real_omp_set_lock(lock);
  }
  void unset(omp_lock_t* lock) {
    __real_omp_unset_lock(lock);
    note(Event::unlock, lock);
  }

 private:
  static void run_member();
  Host& host_of(int member) { return hosts_[member % hosts_.size()]; }

  // Whether this thread is the first to meet the next shared thing, which then is `fresh`.
  bool meet(const Shared& fresh) {
    if (alone()) {
      alone_ = fresh;
      return true;
    }
    const bool first = members_[running_]->shared++ == shared_.size();
    if (first) shared_.push_back(fresh);
    return first;
  }

  double stretch() const { return std::max(0., clock_() - resumed_ - clock_ns_); }
  void add(const Event& event) { record_.regions.back()[running_].push_back(event); }
  void end_work() {
    const double ns = stretch();
    members_[running_]->worked += ns;
    if (ns > 0) add({Event::work, ns});
  }

  void note(Event::Kind kind, const void* which) {
    if (running_ < 0 || locks_ == Locks::left_out) return;
    end_work();
    add({kind, 0, which});
    resumed_ = clock_();
  }

  void yield(decltype(Member::state) state) {
    Member& m = *members_[running_];
    m.state = state;
    swapcontext(&m.context, host_of(running_).scheduler());
    resumed_ = clock_();
  }

  // Whoever has worked least; where all wait at a barrier, they go on together.
  std::optional<int> next_member() {
    const auto least = [&]() -> std::optional<int> {
      std::optional<int> found;
      for (int i = 0; i < cores(); ++i)
        if (members_[i]->state == Member::ready && (!found || members_[i]->worked < members_[*found]->worked)) found = i;
      return found;
    };
    if (const auto found = least()) return found;
    double latest = 0;
    for (const auto& m : members_) latest = std::max(latest, m->worked);
    for (const auto& m : members_)
      if (m->state == Member::waiting) m->state = Member::ready, m->worked = latest;
    return least();
  }

  double (*clock_)();
  double clock_ns_, resumed_;
  Locks locks_;
  Record record_;
  std::span<const std::unique_ptr<Member>> members_;
  std::vector<Shared> shared_;
  Shared alone_ = {};  // where only one thread runs
  int running_ = -1;   // which member; none outside regions
  int nested_ = 0;     // regions of one thread that it is in
  void (*region_)(void*) = nullptr;
  void* data_ = nullptr;
  std::vector<Host> hosts_;
};

Recorder* recorder = nullptr;  // while a record is being made

void Recorder::run_member() {
  Recorder& r = *recorder;
  r.resumed_ = r.clock_();
  r.region_(r.data_);
  r.end_work();
  r.members_[r.running_]->state = Member::done;
}

}  // namespace

Record record(int cores, const std::function<void()>& work, double (*clock)(), double clock_ns, Locks locks) {
  Recorder mine(cores, clock, clock_ns, locks);
  std::atomic<bool> all_done = false;
  Record made;
  // One thread makes the record, the others serve it. None calls OpenMP for itself from the barrier on, so that `recorder` may then be set.
#pragma omp parallel num_threads(mine.hosts())
  {
    const int thread = omp_get_thread_num();
#pragma omp barrier
    if (thread == 0) {
      recorder = &mine;
      made = mine.make(work);
      recorder = nullptr;
      all_done.store(true, std::memory_order_release);
    } else {
      mine.host(thread).serve(all_done);
    }
  }
  return made;
}

bool has_locks(const Record& record) {
  for (const Region& region : record.regions)
    for (const std::vector<Event>& events : region)
      if (std::ranges::find(events, Event::lock, &Event::kind) != events.end()) return true;
  return false;
}

namespace {

double work_in(const Region& region) {
  double ns = 0;
  for (const std::vector<Event>& events : region)
    for (const Event& event : events) ns += event.ns;
  return ns;
}

}  // namespace

void fit(Record& noted, const Record& whole) {
  for (std::size_t r = 0; r < noted.regions.size(); ++r) {
    const double had = work_in(noted.regions[r]), has = work_in(whole.regions[r]);
    if (had == 0) continue;
    for (std::vector<Event>& events : noted.regions[r])
      for (Event& event : events) event.ns *= has / had;
  }
}

}  // namespace lockstep::verify

// What the kernels call in place of libgomp, whose own functions are those named __real_.
extern "C" {

using lockstep::verify::Event;
using lockstep::verify::recorder;
using lockstep::verify::Shared;
using Count = unsigned long long;

#define WRAP(result, name, parameters, pass_on, answer) \
  result __real_##name parameters;                      \
  result __wrap_##name parameters {                     \
    if (!recorder) return __real_##name pass_on;        \
    return answer;                                      \
  }

WRAP(void, GOMP_parallel, (void (*region)(void*), void* data, unsigned threads, unsigned flags), (region, data, threads, flags),
     recorder->parallel(region, data, threads, {}))
WRAP(void, GOMP_parallel_sections, (void (*region)(void*), void* data, unsigned threads, unsigned count, unsigned flags),
     (region, data, threads, count, flags), recorder->parallel(region, data, threads, Shared{1, count + 1, 1, 1}))
WRAP(void, GOMP_parallel_loop_nonmonotonic_dynamic,
     (void (*region)(void*), void* data, unsigned threads, long begin, long end, long step, long chunk, unsigned flags),
     (region, data, threads, begin, end, step, chunk, flags), recorder->parallel(region, data, threads, Shared{begin, end, step, chunk}))
WRAP(void, GOMP_barrier, (), (), recorder->barrier())
WRAP(bool, GOMP_loop_nonmonotonic_dynamic_start, (long begin, long end, long step, long chunk, long* first, long* last),
     (begin, end, step, chunk, first, last), recorder->loop_start({begin, end, step, chunk}, *first, *last))
WRAP(bool, GOMP_loop_nonmonotonic_dynamic_next, (long* first, long* last), (first, last), recorder->next_chunk(*first, *last))
WRAP(bool, GOMP_loop_ull_nonmonotonic_dynamic_start, (bool up, Count begin, Count end, Count step, Count chunk, Count* first, Count* last),
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
