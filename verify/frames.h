// A folder of frames for ParaView, as `lockstep run` writes it.
//
// Of each part of a simulation that moves, NAME_00000.vtk, NAME_00001.vtk, ... and NAME.vtk.series with their times; of
// each other part NAME.vtk; and the state to go on from, state.lockstep (verify/run_state.h). Each file is written
// whole or not at all.
#pragma once

#include <string>

#include "verify/simulation.h"

namespace lockstep::verify {

class Frames {
 public:
  // Opens the folder, which is made unless `resume`, and keeps other runs on this machine out of it until destruction
  // or the end of the process. Throws InputError if it cannot be opened, or another run has it. Both arguments must
  // outlive the object.
  Frames(const std::string& folder, const Simulation& simulation, bool resume);
  ~Frames();
  Frames(const Frames&) = delete;

  // The file of the state.
  std::string state_file() const;

  // Throws InputError if the folder holds a file with a name that a run writes; with `replace`, removes all of these
  // instead, and no other file.
  void make_room(bool replace) const;

  // Writes the parts that do not move.
  void write_fixed() const;

  // Removes the files of frames after `frame`.
  void forget_after(int frame) const;

  // Writes the parts that move, and then, at most once a second, the series.
  void write(int frame);

  // Writes the series, of frames 0 .. frame, unless time does not pass.
  void write_series(int frame);

 private:
  const std::string& folder_;
  const Simulation& simulation_;
  int opened_;          // file descriptor of the folder, which holds the lock
  double written_ = 0;  // when the series were, as now() says
};

}  // namespace lockstep::verify
