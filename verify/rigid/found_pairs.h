// What the broad phases have in common: they find pairs of colliders in one step's bounds, bitwise with the serial
// twin.
#pragma once

#include <functional>
#include <memory>

#include "verify/rigid/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::rigid_inputs {

struct FoundPairs {
  rigid::Pairs pairs;
};
template <Same<FoundPairs> S, class F>
void for_each_array(S& s, const F& f) {
  f("pairs", s.pairs, s.pairs.size());
}

using FindPairs = std::function<void(rigid::Pairs& pairs)>;

inline Case pairs_case(const Inputs& in, FindPairs serial, FindPairs openmp) {
  const auto with = [](FindPairs find) { return [find](FoundPairs& s) { find(s.pairs); }; };
  const double n = in.now.bounds.count, found = static_cast<double>(in.now.bounded.size());
  return make_case<FoundPairs>({
      .start = std::make_shared<const FoundPairs>(FoundPairs{{{0, 0}}}),  // which must be emptied first
      .serial = with(std::move(serial)),
      .best_serial = nullptr,
      .openmp = with(std::move(openmp)),
      .compare = nullptr,
      .work = {n, "boxes", n * bytes_of_box + found * sizeof(rigid::Pair), found * 6},
  });
}

}  // namespace lockstep::verify::rigid_inputs
