// Scenes of the production cloth. scenes/README.md has every key of the TOML, scenes/production_cloth/ examples.
#pragma once

#include <string>
#include <vector>

#include "common/production_cloth/bodies.h"
#include "common/production_cloth/cloth.h"

namespace lockstep::production_cloth {

// Vertices that a scene moves.
struct Hold {
  std::vector<std::int32_t> vertices;  // ascending
  Path path;
};

struct Scene {
  std::string name;  // the file's, without folder and extension
  std::string path;
  Topology topology;
  Vectors<double> rest;  // m: the vertices at time 0, without stress; every one is a float
  Material material;
  Contact contact;
  std::vector<Hold> holds;
  std::vector<Body> bodies;
  Vector3<double> gravity;  // m/s^2
  double frame_time;        // s
  int substeps;             // steps of a frame
  double tolerance;         // of the solves
  int iterations;           // of a solve, at most
  int frames;
};

// Reads a TOML scene. Vertices of each sheet, tube and mesh are renumbered along a Morton curve, and triangles by their
// least vertex, so that neighbours stand near each other in memory, and sheets that lie on each other do not mix.
// Throws InputError in one line, `file:line:column: what was expected`, where the file cannot be read, is not what
// scenes/README.md says, or does not fit the machine's memory, asked before the cloth is made; likewise where a mesh is
// refused (common/mesh_file.h, make_topology), a triangle is degenerate, an edge is not longer than the thickness, or
// the cloth intersects or touches itself (common/production_cloth/intersections.h).
Scene load_scene(const std::string& path);

}  // namespace lockstep::production_cloth
