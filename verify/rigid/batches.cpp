// The rows and benchmarks of contacts in batches: the same batches as the serial twin's, number by number.
#include "common/rigid/batches.h"

#include "verify/rigid/inputs.h"
#include "verify/twin.h"

namespace lockstep {

template <Same<Batches> B, class F>
void for_each_array(B& b, const F& f) {
  f("order", b.order, b.order.size()), f("begin", b.begin, b.begin.size());
}

namespace verify::rigid_batches {
namespace {

using namespace rigid;
using namespace rigid_inputs;

Case batches_case(const std::string& path, ReorderContacts<float>* serial, ReorderContacts<float>* openmp) {
  const auto in = inputs(path);
  const auto with = [in](ReorderContacts<float>* reorder) {
    return [in, reorder](Batches& batches) { batches = reorder(in->now.manifolds, in->body(), in->world.bodies); };
  };
  const double n = static_cast<double>(in->now.manifolds.size());
  return make_case<Batches>({
      .start = std::make_shared<const Batches>(),
      .serial = with(serial),
      .best_serial = nullptr,
      .openmp = with(openmp),
      .compare = nullptr,
      .work = {n, "contacts", n * 20, 0},
  });
}

Form form(const char* name, ReorderContacts<float>* serial, ReorderContacts<float>* openmp) {
  return {.name = name,
          .make = [=](const std::string& path) { return batches_case(path, serial, openmp); },
          .scenes = scenes_of_all(settled)};
}

const Register batches{
    {.name = "rigid/batches",
     .place = 14,
     .serial_forms = {"", "folded"},
     .forms = {form("", rigid::serial::batches, rigid::openmp::batches),
               form("folded", rigid::serial::batches_folded, rigid::openmp::batches_folded),
               form("parallel", rigid::serial::batches, rigid::openmp::batches_parallel)}}};

}  // namespace
}  // namespace verify::rigid_batches
}  // namespace lockstep
