// A scene being run, as `lockstep run` sees it, whatever its kind.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "verify/options.h"

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
  std::function<std::string()> summary;                      // of the run, for people; may be absent
};

// The functions share the state. Throw InputError where the scene or the form is not to be had.
Simulation fluid_simulation(const RunOptions& options);
Simulation cloth_simulation(const RunOptions& options);
Simulation levelset_simulation(const RunOptions& options);
Simulation rigid_simulation(const RunOptions& options);

}  // namespace lockstep::verify
