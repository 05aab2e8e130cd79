// The rows and benchmarks of matching contacts from step to step: bitwise with the serial twin.
#include "common/rigid/match_contacts.h"

#include "verify/rigid/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::rigid_match_contacts {
namespace {

using namespace rigid;
using namespace rigid_inputs;

struct Matched {
  Array<Impulses<float>> impulses;
};
template <Same<Matched> M, class F>
void for_each_array(M& m, const F& f) {
  f("impulses", m.impulses, m.impulses.size());
}

Case match_case(const std::string& path) {
  const auto in = inputs(path);
  const auto with = [in](MatchContacts<float>* match) {
    return [in, match](Matched& m) { match(in->last.manifolds, in->last.impulses, in->now.manifolds, m.impulses); };
  };
  Matched start{Array<Impulses<float>>(in->now.manifolds.size())};
  poison(start);
  const double n = static_cast<double>(in->now.manifolds.size());
  return make_case<Matched>({
      .start = std::make_shared<const Matched>(std::move(start)),
      .serial = with(serial::match_contacts),
      .best_serial = nullptr,
      .openmp = with(openmp::match_contacts),
      .compare = nullptr,
      .work = {n, "contacts", n * 2 * (bytes_of_manifold + sizeof(Impulses<float>)), 0},
  });
}

const Register match_contacts{
    {.name = "rigid/match_contacts", .place = 13, .forms = {{.make = match_case, .scenes = scenes_of_all(settled)}}}};

}  // namespace
}  // namespace lockstep::verify::rigid_match_contacts
