// Inputs that kernels share: a scene in the state in which kernels find it, its double truth, a serial run.
//
// One cache for all domains, with one budget. Kernels come one after another on the same few scenes, so what was used last
// is kept, and what has not been used for longest is dropped once all that is kept exceeds the budget. Whoever still uses a
// dropped input keeps it alive.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <typeinfo>

#include "common/arrays.h"

namespace lockstep::verify {

inline constexpr double inputs_budget = 3e9;  // bytes

struct MadeInput {
  std::shared_ptr<const void> input;
  double bytes;
};

// The input of that key, made where it is not kept.
std::shared_ptr<const void> kept_input(const std::string& key, const std::function<MadeInput()>& make);

// An input of type T for the scene at `path`, or for another key that names it. bytes_of(T) must be found beside T: for a
// state whose arrays are listed that is the one of common/arrays.h.
template <class T>
std::shared_ptr<const T> inputs(const std::string& key, const std::function<T()>& make) {
  const auto input = kept_input(std::string(typeid(T).name()) + ' ' + key, [&] {
    const auto made = std::make_shared<const T>(make());
    return MadeInput{made, bytes_of(*made)};
  });
  return std::static_pointer_cast<const T>(input);
}

}  // namespace lockstep::verify
