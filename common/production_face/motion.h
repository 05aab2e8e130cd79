// How bones and muscles move, as a scene says: bones turn and shift, muscles are activated.
#pragma once

#include <string>
#include <vector>

#include "common/placement.h"
#include "common/production_face/body.h"
#include "common/vector3.h"

namespace lockstep::production_face {

inline constexpr double frame_time = 1 / 24.;  // s

struct Bone {
  std::string name;
  Vector3<double> pivot;  // m
};

// What a scene wants at a time.
struct Key {
  double time;                    // s
  std::vector<float> activation;  // of the muscles
  std::vector<Placement> bones;
};

struct Motion {
  std::vector<Bone> bones;
  Array<std::int32_t> bone_of_held;  // [k]: the bone of node body.held[k]
  std::vector<Key> keys;             // at least one; times ascend, the first is 0
  bool repeats = false;              // after the last key; else it is held
};

// What a frame is to bring about.
template <class Real>
struct Target {
  Array<Real> activation;  // 0 to 1, of the muscles
  Vectors<Real> held;      // m, displacements of body.held
};

// What the scene wants at `time`, s. Between two keys all that moves follows 3 w^2 - 2 w^3, w from 0 to 1.
Key key_at(const Motion& motion, double time);

// The same, with bones' placements as displacements of held nodes.
Target<float> target_at(const Body<float>& body, const Motion& motion, double time);

}  // namespace lockstep::production_face
