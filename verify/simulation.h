// A scene being run, as `lockstep run` sees it, whatever its kind.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/input_error.h"
#include "verify/options.h"
#include "verify/run_state.h"

namespace lockstep::verify {

struct Simulation {
  std::string name;  // the scene's
  std::string form;  // which form of the step
  int elements;
  std::string unit;  // what the elements are: particles, points
  int frames;        // how many the scene asks for
  std::function<void()> step;
  std::function<void(const std::string& path)> write_frame;  // for ParaView
  std::function<void(const std::string& path)> write_state;  // as one file
  std::vector<std::string> state_formats;                    // how the name of that file may end; none if there is no such format
  std::vector<Kept> state;                                   // what the next step needs of the last; none if there is but one step
  std::function<std::string()> fault;                        // the first element that is not finite or out of bounds; "" if none is
  std::function<std::string()> summary;                      // of the run, for people; may be absent
};

// The simulation of the scene's domain. The functions share its state. Throws InputError where the scene or the form is not to be
// had, or the domain has nothing to simulate.
Simulation make_simulation(const RunOptions& options);

// --- What the domains' simulations share

// The first form that fits, or the one asked for.
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

// The first of n elements that is not as it should be, "" if all are.
template <class Fits>
std::string first_fault(const char* what, int n, const char* fault, Fits fits) {
  for (int i = 0; i < n; ++i)
    if (!fits(i)) return what + std::to_string(i) + fault;
  return "";
}

}  // namespace lockstep::verify
