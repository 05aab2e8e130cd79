// Scenes of the game cloth (scenes/cloth/ has examples):
//
//   kind = "cloth"               # required
//   frames = 300                 # how many steps to run unless told otherwise, >= 1
//   time_step = 0.0166666667     # s, of a step, 1e-6 .. 1; exactly 1/60 by default
//   substeps = 1                 # a step, >= 1
//   iterations = 20              # of the relaxation, a substep, >= 0
//   gravity = [0, -9.81, 0]      # m/s^2
//   wind = [0, 0, 0]             # m/s, the velocity of the air
//   drag = 0                     # kg/m^3, air density times drag coefficient, >= 0; 0: no air
//   damping = 0                  # 1/s, >= 0: velocities fall as exp(-damping t)
//   friction = 0                 # of all bodies, >= 0
//   thickness = 0                # m, >= 0: how far the cloth stays off all bodies
//
//   [sheet]                      # this or [mesh]; all required but bending, pins, pull
//   rows = 128                   # >= 1
//   columns = 128                # >= 1, together at least 2 particles
//   origin = [0, 2, 0]           # m, the particle of row 0, column 0
//   width = [1, 0, 0]            # m, from the first to the last column, zero where there is one
//   height = [0, -1, 0]          # m, from the first to the last row, likewise
//   mass = .2                    # kg, of the whole sheet, > 0
//   bending = true               # whether particles two apart are tied, too; false by default
//   pins = ["top"]               # what nothing moves: "top" "bottom" "left" "right" edges, corners "top_left" ...,
//                                #   each once, or particles [row, column]; none by default
//   pull = { edge = "right", by = [.1, 0, 0] }   # m: an edge that is moved at the start, and pinned there; it
//                                                #   stretches its ties
//
//   [mesh]
//   file = "garment.obj"         # required: triangles in Wavefront OBJ, beside the scene; polygons are cut into
//                                #   triangles
//   scale = 1                    # > 0
//   mass = .3                    # kg, required, > 0
//   bending = true               # whether the far corners of two triangles with a common edge are tied, too; false by
//                                #   default
//   pins_above = 1.4             # m: points with y above this are pinned; none by default
//
//   [[plane]]                    # any number of each body; all required but turn
//   normal = [0, 1, 0]           # of any length but zero
//   point = [0, 0, 0]            # m, on its surface
//   [[sphere]]
//   centre = [0, 1, 0]           # m
//   radius = .3                  # m, > 0
//   [[capsule]]
//   from = [0, 0, 0]             # m
//   to = [0, 1, 0]               # m
//   radius = .1                  # m, > 0
//   [[box]]
//   centre = [0, .5, 0]          # m
//   half = [.2, .2, .2]          # m, > 0
//   turn = [0, 30, 0]            # degrees, about x, then y, then z; [0, 0, 0] by default
//
// Values shown at the top level are the defaults. Where a number must be > 0 it must be 1e-9 .. 1e9 (limits.h).
#pragma once

#include <string>

#include "common/cloth/cloth.h"

namespace lockstep::cloth {

struct Scene {
  std::string name;  // the file's, without folder and extension
  std::string path;
  Cloth<double> cloth;    // convert<float>(cloth) is what float kernels take
  Bodies<double> bodies;  // without thickness: no particle ends a step inside one, unless it was pinned
  int frames;
};

// Reads a TOML scene. Throws InputError in one line, `file:line:column: what was expected`, where the file cannot be
// read, is not what is written above (an unknown key, a wrong type, a number out of range or not finite, a pin that is
// not on the sheet), or does not fit the machine's memory, asked before the cloth is made; likewise where an OBJ is
// refused (common/obj.h), or tied particles are at one place. Open meshes, and edges of more than two triangles, are
// taken.
Scene load_scene(const std::string& path);

}  // namespace lockstep::cloth
