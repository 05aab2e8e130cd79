// What the verifier and the benchmark know of a kernel, and how a kernel joins them.
//
// A kernel joins by one Kernel for each of its forms: a name, and a function that makes a Case on a scene. verify/fluid.cpp
// shows it; kernels() in verify/kernels.cpp lists them all. The verifier runs each Case at every thread count asked for, the
// benchmark times it; neither knows what is computed.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "common/simd.h"

namespace lockstep::verify {

// The strongest claim that holds of the openmp result, strongest first (notes/verification.md).
enum class Verdict {
  bitwise,    // the same bits, or the same set, as the serial form of the same algorithm
  bounded,    // the error against the double run within twice the serial error plus the rounding bound of the sums
  converged,  // another algorithm for the same answer, which reaches the serial algorithm's residual
  physical,   // a chaotic run: what physics conserves, and no faster divergence than one ulp of input causes
};
const char* name_of(Verdict verdict);

// What a comparison found: the worst element, by error relative to its own bound.
struct Judgement {
  Verdict verdict;
  bool passed = true;
  double error = 0, bound = 0;  // of the worst element; for bitwise the number of elements that differ, and 0
  std::string worst_at;         // where it is, and both values
};

// What one run of a kernel does at the least: for items/s, GB/s and GFLOP/s.
struct Work {
  double items;
  std::string unit;     // of an item
  double bytes;         // that must come from and go to memory once
  double flops;         // of the serial form
  double lane_use = 0;  // openmp: the share of its vectors' lanes that hold something; 0 where only the kernel could tell
};

// The share of lanes in use where runs of so many elements each begin in a vector of their own.
template <class Lengths>
double lanes_in_use(const Lengths& lengths) {
  double used = 0, there = 0;
  for (const double n : lengths) used += n, there += std::ceil(n / lanes) * lanes;
  return there > 0 ? used / there : 0;
}

// One kernel in one form on one scene: inputs made, truth known. The functions share their state.
struct Case {
  std::function<void()> reset;          // makes the inputs what they were; not timed
  std::function<void()> serial;         // the serial form of the same algorithm: what openmp must agree with
  std::function<void()> best_serial;    // the best serial algorithm, where that is another: what openmp must beat
  std::function<void()> openmp;         // with as many threads as omp_set_num_threads said
  std::function<Judgement()> judge;     // compares what the last openmp run left with the serial form
  std::function<std::uint64_t()> hash;  // of what the last openmp run left, in an order that does not depend on the run
  Work work;
};

struct Kernel {
  std::string name;                 // its path below serial/
  std::string form;                 // which of its openmp forms
  bool order_dependent;             // whether rounding depends on which thread came first; else hashes must agree
  std::vector<std::string> scenes;  // for `make verify`, and what FULL=1 adds
  std::vector<std::string> more_scenes;
  std::vector<std::string> bench_scenes;
  std::function<bool(const std::string& scene_path)> takes;  // whether it is for scenes of this kind, such as a user's own
  std::function<Case(const std::string& scene_path)> make;
};

// All kernels, domain by domain, in the order of a step.
std::vector<Kernel> kernels();
std::vector<Kernel> fluid_kernels();
std::vector<Kernel> cloth_kernels();
std::vector<Kernel> levelset_kernels();
std::vector<Kernel> rigid_kernels();

}  // namespace lockstep::verify
