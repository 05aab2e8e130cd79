// A team of any size on the machine's cores, one member at a time: the Recorder answers the kernels' calls to OpenMP's
// runtime (record_wraps.cpp) and notes what each member did between the calls.
#pragma once

#include <omp.h>
#include <sys/mman.h>
#include <ucontext.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <memory>
#include <new>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "common/flags.h"
#include "common/waiting.h"
#include "verify/record.h"

extern "C" {
void __real_omp_set_lock(omp_lock_t* lock);
void __real_omp_unset_lock(omp_lock_t* lock);
void __real_lockstep_post(lockstep::Flag* flag, int value);
}

namespace lockstep::verify {

// A stack as large as those that OpenMP gives its threads. Pages that are never touched cost nothing.
class Stack {
 public:
  Stack() {
    const int flags = MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE | MAP_STACK;
    at_ = mmap(nullptr, size, PROT_READ | PROT_WRITE, flags, -1, 0);
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
  enum { ready, waiting, awaiting, done } state;  // waiting at a barrier, awaiting a flag
  double worked;       // ns of work in this region; after a barrier, the largest of all members
  std::size_t shared;  // number of loops, sections and singles met in this region
  bool in_chunk;       // whether it works on a chunk of the last of them, and on which
  std::size_t chunk;
  const Flag* flag;  // if it waits for a flag: which, and for which value
  int value;
};

// The iterations left of a loop, a list of sections or a single that a team shares out.
struct SharedWork {
  long next, end, step, chunk;

  bool take(long& first, long& last) {
    if (step > 0 ? next >= end : next <= end) return false;
    first = next;
    last = next = step > 0 ? std::min(end, next + chunk * step) : std::max(end, next + chunk * step);
    return true;
  }
};

// The first `cores` members. They are kept from record to record, as OpenMP keeps its threads: the first touch of a
// stack's pages is expensive.
inline std::span<const std::unique_ptr<Member>> team(int cores) {
  static std::vector<std::unique_ptr<Member>> members;
  while (std::ssize(members) < cores) members.push_back(std::make_unique<Member>());
  return std::span(members).first(cores);
}

// An OpenMP thread that members run on. Each core's caches then hold the data of its own members, and data that other
// members wrote comes from another core, as in a real run. Only one host runs at a time. The first host makes the
// record.
class Host {
 public:
  // Runs m until it yields or ends.
  void run(Member& m) {
    turn_.store(&m, std::memory_order_release);
    while (turn_.load(std::memory_order_acquire)) pause();
  }
  // Runs members when it is this thread's turn, until `all_done`. The thread spins between turns: if it slept, the
  // system might run something else on its core, or move the thread.
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
  ucontext_t scheduler_;
  std::atomic<Member*> turn_ = nullptr;  // the member to run; null when it has run
};

class Recorder {
 public:
  Recorder(int cores, double (*clock)(), double clock_ns, Waits waits)
      : clock_(clock),
        clock_ns_(clock_ns),
        waits_(waits),
        members_(team(cores)),
        hosts_(std::min(cores, omp_get_num_procs())) {
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

  // Runs a region. `first` is the work that the region shares out from its beginning, if any.
  void parallel(void (*region)(void*), void* data, unsigned threads, std::optional<SharedWork> first) {
    if (running_ >= 0 || threads == 1) {
      const SharedWork outer = alone_;
      if (first) alone_ = *first;
      ++nested_;
      region(data);
      --nested_;
      alone_ = outer;
      return;
    }
    record_.serial_ns.push_back(stretch());
    record_.regions.push_back({std::vector<Events>(cores()), {}});
    shared_.clear();
    if (first) share(*first);
    region_ = region;
    data_ = data;
    for (int i = 0; i < cores(); ++i) {
      Member& m = *members_[i];
      m.state = Member::ready, m.worked = 0, m.shared = shared_.size(), m.in_chunk = false;
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

  // The next chunk of the thread's current loop or list of sections. Members that have worked less take their chunks
  // first.
  bool next_chunk(long& first, long& last) {
    if (alone()) return alone_.take(first, last);
    Member& m = *members_[running_];
    const std::size_t which = m.shared - 1;
    end_work();
    if (!m.in_chunk) add({Event::dispatch, 0, nullptr, static_cast<int>(which)});
    yield(Member::ready);
    m.in_chunk = shared_[which].take(first, last);
    if (!m.in_chunk) return false;
    std::vector<Events>& chunks = record_.regions.back().chunks[which];
    m.chunk = chunks.size();
    chunks.emplace_back();
    return true;
  }

  bool loop_start(const SharedWork& loop, long& first, long& last) {
    meet(loop);
    return next_chunk(first, last);
  }

  unsigned next_section() {
    long section, end;
    return next_chunk(section, end) ? section : 0;
  }

  // Whether this thread is the one that executes the single.
  bool single() {
    const bool executes = meet({});
    if (!alone()) add({Event::single, 0, nullptr, executes});
    return executes;
  }

  // Members that await the value go on, no earlier than the one that posts it.
  void post(Flag* flag, int value) {
    __real_lockstep_post(flag, value);
    if (alone()) return;
    if (waits_ == Waits::noted) {
      end_work();
      add({Event::post, 0, flag, value});
    }
    for (const auto& m : members_)
      if (m->state == Member::awaiting && m->flag == flag && m->value <= value)
        m->state = Member::ready, m->worked = std::max(m->worked, members_[running_]->worked);
    if (waits_ == Waits::noted) resumed_ = clock_();
  }
  // If it is noted, gives the turn away in any case: members that have worked less may post first what this one then
  // finds.
  void await(const Flag* flag, int value) {
    if (alone()) return;
    const bool is_there = flag->value.load(std::memory_order_acquire) >= value;
    if (is_there && waits_ == Waits::left_out) return;
    end_work();
    if (waits_ == Waits::noted) add({Event::await, 0, flag, value});
    Member& m = *members_[running_];
    m.flag = flag, m.value = value;
    yield(is_there ? Member::ready : Member::awaiting);
  }

  void set(omp_lock_t* lock) {
    note(Event::lock, lock);
    __real_omp_set_lock(lock);
  }
  void unset(omp_lock_t* lock) {
    __real_omp_unset_lock(lock);
    note(Event::unlock, lock);
  }

 private:
  // What each member runs on its own stack: the region, to its end.
  static void run_member();
  Host& host_of(int member) { return hosts_[member % hosts_.size()]; }

  // Enters the next shared construct. Returns whether this thread is the first to do so; the construct then starts as
  // `fresh`.
  bool meet(const SharedWork& fresh) {
    if (alone()) {
      alone_ = fresh;
      return true;
    }
    const bool first = members_[running_]->shared++ == shared_.size();
    if (first) share(fresh);
    return first;
  }
  void share(const SharedWork& work) {
    shared_.push_back(work);
    record_.regions.back().chunks.emplace_back();
  }

  double stretch() const { return std::max(0., clock_() - resumed_ - clock_ns_); }
  void add(const Event& event) {
    Region& region = record_.regions.back();
    const Member& m = *members_[running_];
    (m.in_chunk ? region.chunks[m.shared - 1][m.chunk] : region.members[running_]).push_back(event);
  }
  void end_work() {
    const double ns = stretch();
    members_[running_]->worked += ns;
    add({Event::work, ns});
  }

  void note(Event::Kind kind, const void* which) {
    if (running_ < 0) return;
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

  // The ready member that has worked least. If all wait at a barrier, the barrier opens first. None when all are done.
  std::optional<int> next_member() {
    const auto least = [&]() -> std::optional<int> {
      std::optional<int> found;
      for (int i = 0; i < cores(); ++i)
        if (members_[i]->state == Member::ready && (!found || members_[i]->worked < members_[*found]->worked))
          found = i;
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
  Waits waits_;
  Record record_;
  std::span<const std::unique_ptr<Member>> members_;
  std::vector<SharedWork> shared_;
  SharedWork alone_ = {};  // the current shared work outside regions and in regions of one thread
  int running_ = -1;       // index of the running member; -1 outside regions
  int nested_ = 0;         // depth of regions of one thread
  void (*region_)(void*) = nullptr;
  void* data_ = nullptr;
  std::vector<Host> hosts_;
};

// The one in use while a record is being made, and the same if locks are noted. Locks that are left out take the way
// that they take when no record is made: at a million of them, a call to the recorder each would count.
inline Recorder *recorder = nullptr, *recorder_of_locks = nullptr;

inline void Recorder::run_member() {
  Recorder& r = *recorder;
  r.resumed_ = r.clock_();
  r.region_(r.data_);
  r.end_work();
  r.members_[r.running_]->state = Member::done;
}

}  // namespace lockstep::verify
