// Scenes of boxes and planes, settled by ours, handed to another engine, and stepped by both in turn.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "common/rigid/scene.h"
#include "notes/peers/peer.h"

namespace lockstep::peers {

// A box of the settled scene, in the world. Static if its mass is 0.
struct BoxBody {
  rigid::Pose<float> pose;
  rigid::Motion<float> motion;
  Vector3<float> half;  // m
  float mass;           // kg
};

// What is below `normal . x = offset` is solid.
struct Ground {
  Vector3<float> normal;
  float offset;
};

struct Boxes {
  std::vector<BoxBody> boxes;
  std::vector<Ground> grounds;
  float friction, restitution;  // of all
  Vector3<double> gravity;      // m/s^2
  double time_step;             // s
  int iterations;               // of the solver, a step
};

// Another engine with these bodies in it.
class Engine {
 public:
  virtual ~Engine() = default;
  virtual void step() = 0;
  virtual BoxBody box(std::size_t k) const = 0;  // where box k is now, and how it moves
};
using MakeEngine = std::function<std::unique_ptr<Engine>(const Boxes& boxes, int threads)>;

// A row for each scene and number of threads. The scene is settled by ours; the other engine then makes `warm_steps`
// of its own, untimed, and so do we, from the same state. Afterwards both take turns, `steps_of_a_turn` each. Quality
// is measured on what both have in the end, after as many steps, with one yardstick: our narrow phase.
void compare_engines(Json& rows, const Asked& asked, const MakeEngine& make, const std::string& not_the_same);

}  // namespace lockstep::peers
