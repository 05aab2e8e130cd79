#include "common/production_face/motion.h"

#include <algorithm>
#include <cmath>

#include "common/convert.h"

namespace lockstep::production_face {

Key key_at(const Motion& motion, double time) {
  const std::vector<Key>& keys = motion.keys;
  const double last = keys.back().time;
  if (motion.repeats && time > last && last > 0) time = std::fmod(time, last);
  const auto after = std::ranges::upper_bound(keys, time, {}, &Key::time);
  if (after == keys.end()) return keys.back();
  const Key &to = *after, &from = *(after - 1);
  const double w = (time - from.time) / (to.time - from.time), share = w * w * (3 - 2 * w);
  const auto between = [&](const Vector3<double>& a, const Vector3<double>& b) { return a + share * (b - a); };
  Key now = from;
  now.time = time;
  for (std::size_t m = 0; m < now.activation.size(); ++m)
    now.activation[m] = static_cast<float>(from.activation[m] + share * (to.activation[m] - from.activation[m]));
  for (std::size_t b = 0; b < now.bones.size(); ++b)
    now.bones[b] = {between(from.bones[b].turn, to.bones[b].turn), between(from.bones[b].shift, to.bones[b].shift)};
  return now;
}

Target<float> target_at(const Body<float>& body, const Motion& motion, double time) {
  const Key key = key_at(motion, time);
  Target<float> target;
  target.activation.assign(key.activation.begin(), key.activation.end());
  std::vector<Matrix3<double>> turned;
  for (const Placement& bone : key.bones) turned.push_back(rotation_by(bone.turn));
  target.held.resize(body.held.size());
  for (std::size_t k = 0; k < body.held.size(); ++k) {
    const int bone = motion.bone_of_held[k];
    const Vector3<double> from_pivot = convert<double>(load(body.rest, body.held[k])) - motion.bones[bone].pivot;
    const Vector3<double> moved = turned[bone] * from_pivot - from_pivot + key.bones[bone].shift;
    store(target.held, k, convert<float>(moved));
  }
  return target;
}

}  // namespace lockstep::production_face
