// The builder of cases: an openmp form and the serial form of the same algorithm, which both change a state.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "verify/arrays.h"
#include "verify/kernel.h"

namespace lockstep::verify {

// State holds the data that the kernel changes; the functions capture the data that it only reads.
// for_each_array(state, f) stands beside State (common/arrays.h). Results that the kernel must write are poisoned in
// `start`.
template <class State>
struct Twin {
  std::shared_ptr<const State> start;       // the state at the start of every run
  std::function<void(State&)> serial;       // the serial form of the same algorithm: the reference of the comparison
  std::function<void(State&)> best_serial;  // the best serial algorithm, if another: the reference of speed-ups
  std::function<void(State&)> openmp;
  std::function<Judgement(const State& openmp, const State& serial)> compare;  // bitwise if absent
  Work work;
  std::function<void(State& now, const State& start)> restore = {};  // undoes a run; copies the whole state if absent
  std::function<std::uint64_t(const State&)> hash = {};              // hash_of if absent
};

// The functions of the case share the twin and one state, which a reset restores: so every version starts with the same
// arrays, as warm in the caches. For the comparison, the serial form runs once, at the first judgement, on a state of
// its own.
template <class State>
Case make_case(Twin<State> twin) {
  struct Run {
    Twin<State> twin;
    State now;
    std::optional<State> expected;
  };
  if (!twin.compare) twin.compare = [](const State& openmp, const State& serial) { return bitwise(openmp, serial); };
  if (!twin.restore) twin.restore = [](State& now, const State& start) { now = start; };
  if (!twin.hash) twin.hash = [](const State& state) { return hash_of(state); };
  const State& start = *twin.start;
  const auto run = std::make_shared<Run>(Run{std::move(twin), start, {}});
  const Work work = run->twin.work;
  return {
      .reset = [run] { run->twin.restore(run->now, *run->twin.start); },
      .serial = [run] { run->twin.serial(run->now); },
      .best_serial =
          run->twin.best_serial ? std::function<void()>([run] { run->twin.best_serial(run->now); }) : nullptr,
      .openmp = [run] { run->twin.openmp(run->now); },
      .judge =
          [run] {
            if (!run->expected) {
              run->expected = *run->twin.start;
              run->twin.serial(*run->expected);
            }
            return run->twin.compare(run->now, *run->expected);
          },
      .hash = [run] { return run->twin.hash(run->now); },
      .work = work,
  };
}

}  // namespace lockstep::verify
