// Scenes of rigid bodies (scenes/rigid/ has examples):
//
//   kind = "rigid"               # required
//   frames = 300                 # how many steps to run unless told otherwise, >= 1
//   settle = 0                   # how many steps `verify` and `bench` run before they look at a kernel, >= 0
//   time_step = 0.0166666667     # s, 1e-6 .. 1; exactly 1/60 by default
//   iterations = 10              # of the contact solver, a step, >= 1
//   gravity = [0, -9.81, 0]      # m/s^2
//   friction = .5                # of all bodies that say nothing else, 0 .. 100; of a contact sqrt(of one times of the
//                                #   other)
//   restitution = 0              # likewise, 0 .. 1; of a contact the larger
//
//   [[hull]]                     # any number: shapes that bodies may have
//   name = "gem"                 # required
//   points = [[0, 0, 1], ...]    # m: this, at least 4, or file; the shape is their convex hull
//   file = "gem.obj"             # whose points these are: Wavefront OBJ, beside the scene
//
//   [[body]]                     # any number; one of these shapes:
//   sphere = .5                  #   its radius, m
//   capsule = { half = .4, radius = .2 }   # m; half of the segment, which is along y
//   box = [.5, .5, .5]           #   half its sides, m
//   hull = "gem"                 #   the name of a [[hull]]
//   plane = [0, 1, 0]            #   its outward normal, of any length but zero; solid on the other side; never moves
//   mesh = "hare.obj"            #   a closed mesh in Wavefront OBJ, beside the scene; never moves
//   position = [0, 1, 0]         # m; [0, 0, 0] by default, as the velocities
//   orientation = [0, 0, 0, 1]   # unit quaternion x y z w; its square is 1 to within .001
//   velocity = [0, 0, 0]         # m/s
//   angular_velocity = [0, 0, 0] # rad/s
//   mass = 1                     # kg, or density, kg/m^3; a body that has neither never moves, and has no velocity
//   friction = .5
//   restitution = 0
//   [[body.part]]                # instead of a shape: a body of several, each with a shape, position and orientation
//                                #   in the body
//
//   [[pyramid]]                  # common/rigid/generators.h says what these are
//   layers = 24                  # required
//   [[stack]]                    # all required
//   count = 10
//   box = [.5, .5, .5]           # m
//   [[wall]]                     # all required
//   courses = 20
//   bricks = 50
//   [[castle]]
//   courses = 16                 # of the walls; 16 by default
//   bricks = 42                  # of a wall, >= 15; 42 by default
//   [[dominoes]]
//   count = 1000                 # required
//   [[pit]]
//   of = "boxes"                 # required: "boxes", "rounds", "hulls" or "mixed"
//   count = 4000                 # required
//   across = 11                  # bodies along each side of a layer; 11 by default
//   from = 1.2                   # m: the height of the lowest layer; 1.2 by default
//   seed = 1                     # >= 0; 1 by default
//   [[soup]]
//   of = "mixed"                 # required
//   count = 10000                # required
//   overlapping = .1             # required: the share of bodies that overlap another, 1e-6 .. .999
//   seed = 1                     # as above
//
// Each of these, too, may have a position (the middle of the ground it stands on; of a soup its own middle) and a mass
// (kg, of each body; of a castle of a whole brick), [0, 0, 0] and 1 by default. Values shown at the top level are the
// defaults, but for frames. There must be a body.
//
// Lengths are 1e-4 .. 1e5, masses 1e-6 .. 1e9, densities 1e-3 .. 1e6, coordinates and velocities at most 1e6. Bodies
// are in the order of this list: [[body]] in the order of the file, then all pyramids, and so on.
#pragma once

#include <string>

#include "common/rigid/world.h"

namespace lockstep::rigid {

struct Scene {
  std::string name;  // the file's, without folder and extension
  std::string path;
  World<float> world;
  double time_step;         // s
  Vector3<double> gravity;  // m/s^2
  int iterations, frames, settle;
};

// Bytes to make so many bodies of one collider, or triangles, in double and keep them in float, too.
double making_bytes(double bodies, double triangles);

// Reads a TOML scene. Throws InputError in one line, `file:line:column: what was expected`, where the file cannot be
// read, is not what is written above (an unknown key, a wrong type, a number out of range or not finite, points that
// have no hull), or does not fit the machine's memory, asked before bodies are made; likewise where an OBJ is refused
// (common/obj.h), or a mesh is not closed (common/mesh.h).
Scene load_scene(const std::string& path);

}  // namespace lockstep::rigid
