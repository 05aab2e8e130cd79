// A kernel as the verifier and the benchmark see it, and how a kernel registers.
//
// verify/DOMAIN/KERNEL.cpp mirrors serial/DOMAIN/KERNEL.cpp. It makes a Case of the kernel on a scene (verify/twin.h),
// and registers the kernel's forms and their scenes. No other file knows them. The verifier runs each Case at the given
// thread counts, the benchmark times it, and the model records it. None of them knows what is computed. notes/adding.md
// explains the steps.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "common/simd.h"

namespace lockstep::verify {

// What a row asserts of the openmp result, strongest first (notes/verification.md).
enum class Verdict {
  bitwise,    // the same bits, or the same set, as the serial form of the same algorithm
  bounded,    // the error against the double run is at most twice the serial error plus the sums' rounding bound
  converged,  // another algorithm for the same answer; it reaches the serial algorithm's residual
  physical,   // a chaotic run: physical invariants hold, and it diverges no faster than after one ulp of input
};
const char* name_of(Verdict verdict);

// How far a run is from the serial run in one quantity, and how far it may be, frame by frame.
struct Course {
  std::string what, unit;
  int from = 0;                                // the scene's frame in which both begin with the same state
  std::vector<double> found = {}, bound = {};  // in frames from + 1, from + 2, ...
};

// The result of a comparison: the worst element, by error relative to its own bound.
struct Judgement {
  Verdict verdict;
  bool passed = true;
  double error = 0, bound = 0;       // of the worst element; bitwise: the number of differences, and 0
  std::string worst_at;              // its name and both values
  std::vector<Course> courses = {};  // where frames of whole runs are compared
};

// The least work of one run of a kernel: for items/s, GB/s and GFLOP/s.
struct Work {
  double items;
  std::string unit;     // name of an item, such as pairs
  double bytes;         // read from or written to memory, if caches hold nothing from one iteration to the next
  double flops;         // of the serial form
  double lane_use = 0;  // openmp: the share of lanes in use; 0 if unknown
  double data = 0;      // bytes of all arrays, once each, where a run or an iteration comes to them again; 0: bytes
};

// The share of lanes in use if runs of these lengths each start in a new vector.
template <class Lengths>
double lanes_in_use(const Lengths& lengths) {
  double used = 0, there = 0;
  for (const double n : lengths) used += n, there += std::ceil(n / lanes) * lanes;
  return there > 0 ? used / there : 0;
}

// One kernel in one form on one scene, with its inputs. The functions share their state.
struct Case {
  std::function<void()> reset;          // restores the inputs; not timed
  std::function<void()> serial;         // the serial form of the same algorithm: the reference of the comparison
  std::function<void()> best_serial;    // the best serial algorithm, if it is another one: the reference of speed-ups
  std::function<void()> openmp;         // on omp_get_max_threads() threads
  std::function<Judgement()> judge;     // compares the result of the last openmp run with the serial form
  std::function<std::uint64_t()> hash;  // of the result of the last openmp run, in a fixed order
  Work work;
};

// One kernel in one of its openmp forms, as the verifier, the benchmark and the model select it.
struct Kernel {
  std::string name;                 // its path below serial/
  std::string form;                 // which of its openmp forms; "" if it has one form only
  bool order_dependent;             // whether rounding depends on the order of threads; if not, hashes must agree
  std::vector<std::string> scenes;  // paths, for `make verify`; more_scenes are added by FULL=1
  std::vector<std::string> more_scenes;
  std::vector<std::string> bench_scenes;
  std::function<bool(const std::string& scene_path)> takes;  // whether it accepts the scene, such as a user's own
  std::function<Case(const std::string& scene_path)> make;
  std::vector<std::string> tsan_scenes = {};
  std::string covered_by = "";  // the form whose code this one runs, tested by tsan and mutants instead; "" if none
  std::vector<std::string> serial_forms = {""};  // of the kernel
};

// All kernels: domain by domain, in the order of a step.
std::vector<Kernel> kernels();

// --- A kernel registers by one constant at the end of verify/DOMAIN/KERNEL.cpp:
//
//   const Register advance{{.name = "fluid/advance",
//                           .place = 5,
//                           .forms = {{.make = make_advance, .scenes = all_scenes}}}};

// Names of scenes: scenes/DOMAIN/NAME.toml.
struct Scenes {
  std::vector<std::string> verify;  // for `make verify`
  std::vector<std::string> more;    // added by FULL=1
  std::vector<std::string> bench;
  std::vector<std::string> tsan;  // larger than one chunk of each loop, or a race stays hidden; QUICK=1 uses the first
};

struct Form {
  std::string name = "";
  std::function<Case(const std::string& scene_path)> make;
  Scenes scenes;
  bool order_dependent = false;
  std::string covered_by = "";                                    // such a form needs no scenes for tsan
  std::function<bool(const std::string& scene_path)> takes = {};  // for some of the domain's scenes only; all if absent
};

struct Registered {
  std::string name;  // DOMAIN/KERNEL
  int place;         // position in the domain's list of kernels, from 1, in the order of a step
  std::vector<std::string> serial_forms = {""};  // as README lists them
  std::vector<Form> forms;
};

struct Register {
  explicit Register(Registered kernel);
};

}  // namespace lockstep::verify
