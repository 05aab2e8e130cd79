// Collisions with solid bodies, as the verifier and the benchmark see them: bitwise with the serial twin.
#include "common/production_cloth/collide_bodies.h"

#include <random>

#include "verify/production_cloth/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::production_cloth_collide_bodies {
namespace {

using namespace production_cloth;
using namespace production_cloth_inputs;

// The cloth has fallen by a few centimetres in one step, and has been shaken, so that some vertices are inside bodies.
Motion<float> fallen(const Scene& scene, float time_step) {
  Motion<float> motion = {rest_positions(scene), {}};
  motion.velocity.resize(scene.topology.vertices);
  std::mt19937 random;  // whose numbers the standard fixes
  const auto shake = [&] { return .02f * (static_cast<float>(random() >> 8) / (1 << 24) - .5f); };
  for (int i = 0; i < scene.topology.vertices; ++i) {
    const float x = shake(), y = shake(), z = shake();
    const Vector3<float> moved = {x, y - .03f, z};
    store(motion.velocity, i, (1 / time_step) * moved);
    store(motion.position, i, load(motion.position, i) + moved);
  }
  return motion;
}

// A vertex reads ten numbers and writes six; a body takes about 40 operations.
Case make(const std::string& path) {
  const auto in = inputs(path);
  const auto time_step = static_cast<float>(in->frame_time / in->substeps);
  const int vertices = in->topology.vertices;
  const auto bodies =
      std::make_shared<const MovedBodies<float>>(move_bodies(in->bodies, 0, time_step, in->contact.thickness));
  const auto rest = std::make_shared<const Vectors<float>>(rest_positions(*in));
  const auto inverse_mass = std::make_shared<const Array<float>>(inverse_masses(*in));
  return make_case<Motion<float>>({
      .start = std::make_shared<const Motion<float>>(fallen(*in, time_step)),
      .serial =
          [=](Motion<float>& m) {
            production_cloth::serial::collide_bodies(*bodies, vertices, time_step, *inverse_mass, *rest, m.position,
                                                     m.velocity);
          },
      .best_serial = nullptr,
      .openmp =
          [=](Motion<float>& m) {
            production_cloth::openmp::collide_bodies(*bodies, vertices, time_step, *inverse_mass, *rest, m.position,
                                                     m.velocity);
          },
      .compare = nullptr,
      .work = {double(vertices), "vertices", 4. * 16 * vertices, 40. * vertices * in->bodies.size()},
  });
}

const Register collide_bodies{
    {.name = "production_cloth/collide_bodies", .place = 9, .forms = {{.make = make, .scenes = all_scenes()}}}};

}  // namespace
}  // namespace lockstep::verify::production_cloth_collide_bodies
