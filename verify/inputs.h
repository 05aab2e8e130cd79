// Inputs that kernels share: a settled scene, its double truth, a serial run.
//
// One cache for all domains, with one budget. When a new input would exceed it, the cache drops those that took the
// least time to make for their size. So scenes that settle for seconds stay from one report of `figures` to the next,
// and large grids go. A shared pointer keeps a dropped input alive for its users.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <typeinfo>

#include "common/arrays.h"

namespace lockstep::verify {

inline constexpr double inputs_budget = 3e9;  // bytes

// Whether scenes settle by openmp steps, where these have the serial bits. Openmp steps take far less time, so `bench`,
// `scale` and `figures` set this. `verify` settles by serial steps: a faulty kernel that loses contacts would settle
// into a state without contacts, in which no comparison shows the fault.
inline bool settles_by_openmp = false;

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
