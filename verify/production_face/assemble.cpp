// Stiffness matrices, as the verifier and the benchmark see them: bitwise with the serial twin.
#include "common/production_face/assemble.h"

#include <limits>

#include "verify/production_face/inputs.h"
#include "verify/twin.h"

namespace lockstep::production_face {

// The matrix as each version holds it, and the room that openmp takes. Rows are compared laid out as slices.
struct Stiffness {
  linear::BlockRows<float> rows;
  linear::SlicedBlockRows sliced;
  Array<float> shares;
};

template <Same<Stiffness> S, class F>
void for_each_array(S& k, const F& f) {
  f("value", k.sliced.value, k.sliced.value.size());
}

}  // namespace lockstep::production_face

namespace lockstep::verify::production_face_assemble {
namespace {

using namespace production_face;
using namespace production_face_inputs;

// A tetrahedron reads 40 numbers, and K is written: nine numbers a block. Six blocks are two products of matrices each,
// which is most of about 750 operations.
Case make(const std::string& path) {
  const auto in = inputs(path);
  const auto state = strained(path);
  const auto pattern = std::make_shared<const Pattern>(make_pattern(in->body));
  Stiffness start = {make_block_rows<float>(*pattern), {}, make_shares(in->body)};
  start.rows.value.assign(start.rows.value.size(), std::numeric_limits<float>::quiet_NaN());
  start.sliced = linear::slice(start.rows);
  const double n = in->body.tetrahedra;
  return make_case<Stiffness>({
      .start = std::make_shared<const Stiffness>(start),
      .serial = [=](Stiffness& k) { serial::assemble(in->body, *state, *pattern, k.rows); },
      .best_serial = nullptr,
      .openmp = [=](Stiffness& k) { openmp::assemble(in->body, *state, *pattern, k.shares, k.sliced); },
      .compare =
          [](const Stiffness& openmp, const Stiffness& serial) {
            return bitwise(openmp, Stiffness{{}, linear::slice(serial.rows), {}});
          },
      .work = {n, "tetrahedra", 4 * (40 * n + 9. * pattern->blocks()), 750 * n, n / in->body.padded_tetrahedra()},
  });
}

const Register assemble{
    {.name = "production_face/assemble", .place = 3, .forms = {{.make = make, .scenes = body_scenes()}}}};

}  // namespace
}  // namespace lockstep::verify::production_face_assemble
