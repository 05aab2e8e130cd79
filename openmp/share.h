// Helpers for OpenMP beyond its pragmas: a thread's share of a loop, and locks.
#pragma once

#include <omp.h>

#include <vector>

namespace lockstep::openmp {

// Elements begin .. end - 1 of n are the share of part `part` of `parts`. Shares are contiguous and as equal as whole
// vectors of sixteen allow. No two parts write to one cache line of an Array.
struct Share {
  int begin, end;
};

inline Share share(int n, int part, int parts) {
  const auto cut = [&](long long k) { return k == parts ? n : static_cast<int>(n / 16 * k / parts * 16); };
  return {cut(part), cut(part + 1)};
}

// The calling thread's share of n within a parallel region.
inline Share my_share(int n) { return share(n, omp_get_thread_num(), omp_get_num_threads()); }

// n locks, free to begin with. Not copied: a lock has an address.
class Locks {
 public:
  explicit Locks(int n) : locks_(n) {
    for (omp_lock_t& lock : locks_) omp_init_lock(&lock);
  }
  ~Locks() {
    for (omp_lock_t& lock : locks_) omp_destroy_lock(&lock);
  }
  Locks(const Locks&) = delete;
  Locks& operator=(const Locks&) = delete;

  void acquire(int i) { omp_set_lock(&locks_[i]); }
  void release(int i) { omp_unset_lock(&locks_[i]); }

 private:
  std::vector<omp_lock_t> locks_;
};

// Holds lock i of `locks` while it lives; none where i < 0.
class Guard {
 public:
  Guard(Locks& locks, int i) : locks_(locks), i_(i) {
    if (i_ >= 0) locks_.acquire(i_);
  }
  ~Guard() {
    if (i_ >= 0) locks_.release(i_);
  }
  Guard(const Guard&) = delete;
  Guard& operator=(const Guard&) = delete;

 private:
  Locks& locks_;
  int i_;
};

}  // namespace lockstep::openmp
