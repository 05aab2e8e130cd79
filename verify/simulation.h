// A scene being run, as `lockstep run` sees it, whatever its kind.
#pragma once

#include <functional>
#include <string>
#include <vector>

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
  std::function<std::string()> fault;                        // the first element that is no number or has got out; "" if there is none
  std::function<std::string()> summary;                      // of the run, for people; may be absent
};

Simulation make_simulation(const RunOptions& options);

// The functions share the state of the simulation. Throw InputError where the scene or the form is not to be had.
Simulation fluid_simulation(const RunOptions& options);
Simulation cloth_simulation(const RunOptions& options);
Simulation levelset_simulation(const RunOptions& options);
Simulation rigid_simulation(const RunOptions& options);

}  // namespace lockstep::verify
