// Inputs that kernels share: a settled scene, its double truth, a serial run.
//
// One cache for all domains, with one budget. Kernels run one after another on the same few scenes, so the cache drops
// the least recently used inputs when their total exceeds the budget. A shared pointer keeps a dropped input alive for
// its users.
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

// The input of that key; calls `make` if the cache does not hold it.
std::shared_ptr<const void> kept_input(const std::string& key, const std::function<MadeInput()>& make);

// The input of type T for a key, such as a scene's path. Needs a function bytes_of(const T&) beside T; for a state
// whose arrays are listed, common/arrays.h has one.
template <class T>
std::shared_ptr<const T> inputs(const std::string& key, const std::function<T()>& make) {
  const auto input = kept_input(std::string(typeid(T).name()) + ' ' + key, [&] {
    const auto made = std::make_shared<const T>(make());
    return MadeInput{made, bytes_of(*made)};
  });
  return std::static_pointer_cast<const T>(input);
}

}  // namespace lockstep::verify
