// What the verifier and the benchmark know of a kernel, and how a kernel joins them.
//
// verify/DOMAIN/KERNEL.cpp mirrors serial/DOMAIN/KERNEL.cpp. It makes a Case of the kernel on a scene (verify/twin.h), and registers
// the kernel's forms and their scenes: no other file knows them. The verifier runs each Case at every thread count asked for, the
// benchmark times it, the model records it; none of them knows what is computed. notes/adding.md walks through it.
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

// One kernel in one of its openmp forms, as the verifier, the benchmark and the model select it.
struct Kernel {
  std::string name;                 // its path below serial/
  std::string form;                 // which of its openmp forms; "" where there is one
  bool order_dependent;             // whether rounding depends on which thread came first; else hashes must agree
  std::vector<std::string> scenes;  // paths: for `make verify`, and what FULL=1 adds
  std::vector<std::string> more_scenes;
  std::vector<std::string> bench_scenes;
  std::function<bool(const std::string& scene_path)> takes;  // whether it is for this scene, such as a user's own
  std::function<Case(const std::string& scene_path)> make;
  std::vector<std::string> tsan_scenes = {};
  std::string covered_by = "";  // another form that runs the same code, which tsan and mutants look at instead; "" if none does
  std::vector<std::string> serial_forms = {""};  // of the kernel
};

// All kernels: domain by domain, in the order of a step.
std::vector<Kernel> kernels();

// --- How a kernel joins: by one constant at the end of verify/DOMAIN/KERNEL.cpp,
//
//   const Register advance{{.name = "fluid/advance", .place = 5, .forms = {{.make = make_advance, .scenes = all_scenes}}}};

// Names of scenes: scenes/DOMAIN/NAME.toml.
struct Scenes {
  std::vector<std::string> verify;  // for `make verify`
  std::vector<std::string> more;    // what FULL=1 adds
  std::vector<std::string> bench;
  std::vector<std::string> tsan;  // larger than one chunk of the loop that is shared out, or a race hides; the first with QUICK=1
};

struct Form {
  std::string name = "";
  std::function<Case(const std::string& scene_path)> make;
  Scenes scenes;
  bool order_dependent = false;
  std::string covered_by = "";                                    // no scenes for tsan then
  std::function<bool(const std::string& scene_path)> takes = {};  // of the domain's scenes; all if absent
};

struct Registered {
  std::string name;                              // DOMAIN/KERNEL
  int place;                                     // among the domain's kernels, in the order of a step, from 1
  std::vector<std::string> serial_forms = {""};  // as README lists them
  std::vector<Form> forms;
};

struct Register {
  explicit Register(Registered kernel);
};

}  // namespace lockstep::verify
