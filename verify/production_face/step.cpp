// A frame of the face, as the verifier and the benchmark see it: bitwise with the serial twin, in the pose and in what
// Newton's method took. The step goes from the scene's start to its target after two frames. With keys half a second
// apart, bones then move by six tenths of the way of their fastest frame.
#include "common/production_face/step.h"

#include <cmath>
#include <cstdio>
#include <limits>

#include "verify/production_face/forms.h"
#include "verify/production_face/inputs.h"
#include "verify/twin.h"

namespace lockstep::production_face {

// A pose, the room of both versions, and what the frame took: steps, iterations, halvings, |f| at first and at last.
struct Posed {
  Pose<float> pose;
  SerialMemory rows;
  OpenmpMemory slices;
  Array<double> took;
};

template <Same<Posed> P, class F>
void for_each_array(P& posed, const F& f) {
  f("displacement", posed.pose.displacement, posed.pose.displacement.x.size());
  f("what the frame took", posed.took, posed.took.size());
}

}  // namespace lockstep::production_face

namespace lockstep::verify::production_face_step {
namespace {

using namespace production_face;
using namespace production_face_inputs;

template <class StepForm, class Memory>
void take(const Scene& scene, const Face<float>& face, StepForm* step, Posed& posed, Memory& memory) {
  step(face, target_at(scene.body, scene.motion, 2 * frame_time), scene.tolerance, posed.pose, memory);
  const Frame& f = memory.frame;
  posed.took = {double(f.steps), double(f.iterations), double(f.halvings), f.first, f.last};
}

// Bits, and that Newton's method has come to its end.
Judgement judge(const Posed& openmp, const Posed& serial, const Face<float>& face, double tolerance, bool must_end) {
  Judgement judgement = bitwise(openmp, serial);
  if (!judgement.passed) return judgement;
  const Array<double>& took = openmp.took;
  char text[120];
  std::snprintf(text, sizeof text, "%.0f steps, %.0f iterations, |f| %.2e of %.2e N", took[0], took[1], took[4],
                took[3]);
  judgement.worst_at = text;
  judgement.passed = !must_end || took[4] <= std::max(tolerance * took[3], force_of_rounding(face));
  return judgement;
}

Case make(const std::string& path, const FaceForm& form) {
  const auto in = inputs(path);
  const auto face = std::make_shared<const Face<float>>(make_face(in->body, in->flesh));
  Posed start;
  start.pose = in->pose;
  start.took.assign(5, std::numeric_limits<double>::quiet_NaN());
  start.rows = serial::make_memory(*face), start.slices = openmp::make_memory(*face);
  const bool must_end = form.name != "facesim";
  const double n = in->body.tetrahedra;
  return make_case<Posed>({
      .start = std::make_shared<const Posed>(std::move(start)),
      .serial = [=](Posed& p) { take(*in, *face, form.serial, p, p.rows); },
      .best_serial = nullptr,
      .openmp = [=](Posed& p) { take(*in, *face, form.openmp, p, p.slices); },
      .compare = [=](const Posed& openmp,
                     const Posed& serial) { return judge(openmp, serial, *face, in->tolerance, must_end); },
      // Displacements, read and written. Steps and iterations decide on the rest.
      .work = {n, "tetrahedra", 24. * in->body.nodes, 0},
      .restore =
          [](Posed& now, const Posed& start) {
            if (now.took.empty()) now = start;
            now.pose = start.pose, now.took = start.took;
          },
  });
}

std::vector<Form> forms() {
  std::vector<Form> all;
  for (const FaceForm& form : face_forms)
    all.push_back({.name = form.name,
                   .make = [form](const std::string& path) { return make(path, form); },
                   .scenes = moving_scenes()});
  return all;
}

const Register step{
    {.name = "production_face/step", .place = 6, .serial_forms = {"newton", "facesim"}, .forms = forms()}};

}  // namespace
}  // namespace lockstep::verify::production_face_step
