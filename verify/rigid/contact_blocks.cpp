// The rows and benchmarks of contacts in blocks: the same order, groups, blocks and rounds as the serial twin's.
#include "common/rigid/contact_blocks.h"

#include "verify/rigid/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::rigid_contact_blocks {
namespace {

using namespace rigid;
using namespace rigid_inputs;

Case make(const std::string& path) {
  const auto in = inputs(path);
  const auto with = [in](CutIntoBlocks<float>* cut) {
    return [in, cut](ContactBlocks& blocks) { cut(in->now.manifolds, in->body(), in->world.bodies, blocks); };
  };
  const double n = static_cast<double>(in->now.manifolds.size());
  return make_case<ContactBlocks>({
      .start = std::make_shared<const ContactBlocks>(),
      .serial = with(serial::contact_blocks),
      .best_serial = nullptr,
      .openmp = with(openmp::contact_blocks),
      .compare = nullptr,
      .work = {n, "contacts", n * 20, 0},
  });
}

const Register contact_blocks{{.name = "rigid/contact_blocks",
                               .place = 15,
                               .forms = {{.make = make, .scenes = and_more(scenes_of_all(and_castle), "castles_4")}}}};

}  // namespace
}  // namespace lockstep::verify::rigid_contact_blocks
