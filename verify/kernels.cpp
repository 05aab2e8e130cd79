#include "verify/kernel.h"

namespace lockstep::verify {

const char* name_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::bitwise: return "bitwise";
    case Verdict::bounded: return "bounded";
    case Verdict::converged: return "converged";
    case Verdict::physical: return "physical";
  }
  return "";
}

std::vector<Kernel> kernels() {
  std::vector<Kernel> all;
  for (const auto& domain : {fluid_kernels(), cloth_kernels(), levelset_kernels(), rigid_kernels()})
    all.insert(all.end(), domain.begin(), domain.end());
  return all;
}

}  // namespace lockstep::verify
