// A simulation of a scene of any kind, as `lockstep run` sees it.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/input_error.h"
#include "verify/options.h"
#include "verify/run_state.h"

namespace lockstep::verify {

// What ParaView shows of a simulation. A part that moves is a file a frame, NAME_00000.vtk and so on, others are one
// file, NAME.vtk, or with another extension. Every name is known to verify/frames.cpp.
struct Part {
  std::string name;
  bool moves;
  std::function<void(const std::string& path)> write;
  std::string extension = ".vtk";
};

struct Simulation {
  std::string name;  // of the scene
  std::string form;  // the form of the step
  int elements;
  std::string unit;  // name of the elements: particles, points
  int frames;        // as the scene says
  std::function<void()> step;
  double time_step;                                          // s, of a frame; 0 if time does not pass
  std::vector<Part> parts;                                   // a folder of frames has
  std::function<void(const std::string& path)> write_state;  // writes the final state as one file
  std::vector<std::string> state_formats;  // allowed extensions of that file; empty if no such format exists
  std::vector<Kept> state;                 // arrays that the next step needs; empty if there is one step only
  std::function<std::string()> fault;      // the first element that is not finite or out of bounds; "" if none
  std::function<std::string()> summary;    // one or more lines on the run, for users; may be absent
};

// The simulation of the scene's domain. Its functions share one state. Throws InputError if the scene cannot be read,
// the form is unknown, or the domain has no simulation.
Simulation make_simulation(const RunOptions& options);

// --- Helpers of the domains' simulations

// The form asked for among those that fit, or the first that fits. Throws InputError if there is none.
template <class Forms, class Fits>
const auto& find_form(const Forms& forms, const std::string& asked, Fits fits) {
  std::string known;
  for (const auto& form : forms) {
    if (!fits(form)) continue;
    if (asked.empty() || asked == form.name) return form;
    known += (known.empty() ? "" : ", ") + form.name;
  }
  throw InputError("--form " + asked + ": expected one of: " + known);
}

// A message about the first of n elements that does not fit, "" if all fit.
template <class Fits>
std::string first_fault(const char* what, int n, const char* fault, Fits fits) {
  for (int i = 0; i < n; ++i)
    if (!fits(i)) return what + std::to_string(i) + fault;
  return "";
}

}  // namespace lockstep::verify
