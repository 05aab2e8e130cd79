// Scenes of the level set (scenes/levelset/ has examples):
//
//   kind = "levelset"           # required
//   points = [256, 256, 256]    # required, >= 2 each
//   spacing = 0.00390625        # m, from point to point, 1e-6 .. 1e6; 1 / points.x by default
//   origin = [0, 0, 0]          # m: point (i, j, k) stands at origin + (i + .5, j + .5, k + .5) spacing
//   band = 5                    # in spacings, > 0: how far from the interface distances are wanted; all points by
//                               #   default
//   rounds = 1                  # of fast sweeping, at most, >= 1
//   distort = 0                 # 0 .. .9: phi is the distance times 1 + distort sin 9x cos 7y sin(8z + 1), x, y, z in
//                               #   m: it no longer is a distance, but has the same zero
//
//   [[sphere]]                  # any number of each shape, or [mesh]; all required
//   centre = [.5, .5, .5]       # m
//   radius = .3                 # m, > 0
//   [[box]]                     # with sides along the axes
//   centre = [.5, .5, .5]       # m
//   half = [.2, .1, .1]         # m, > 0
//   [[torus]]                   # about the line along z through its centre
//   centre = [.5, .5, .5]       # m
//   ring = .3                   # m: the radius of the circle that the tube is bent around
//   tube = .1                   # m, > 0 and < ring: the radius of the tube
//
//   [mesh]
//   file = "knot.obj"           # required: a closed mesh in Wavefront OBJ, beside the scene
//   scale = 1                   # > 0
//
// Values shown at the top level are the defaults, but for points and band. Where a number must be > 0 it must be 1e-9
// .. 1e9.
#pragma once

#include <string>
#include <vector>

#include "common/levelset/field.h"
#include "common/levelset/grid.h"
#include "common/levelset/shapes.h"

namespace lockstep::levelset {

struct Scene {
  std::string name;  // the file's, without folder and extension
  std::string path;
  Grid grid;
  Field<float> phi;           // < 0 inside, else outside; its zero is the interface, and there is one
  double band;                // m; infinite where all points are wanted
  int rounds;                 // >= 1
  std::vector<Shape> shapes;  // whose union the inside is: signed_distance(shapes, p) is exact; none of a mesh
};

// Reads a TOML scene. Throws InputError in one line, `file:line:column: what was expected`, where the file cannot be
// read, is not what is written above (an unknown key, a wrong type, a number out of range or not finite, a band wider
// than the grid), does not fit the machine's memory, asked before the field is made, or no interface comes between
// points of the grid; likewise where an OBJ is refused (common/obj.h), or a mesh is not closed (common/mesh.h).
Scene load_scene(const std::string& path);

}  // namespace lockstep::levelset
