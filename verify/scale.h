// The scaling model (notes/scaling.md): the time of work on more cores than this machine has, beside measured times.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>

#include "verify/replay.h"

namespace lockstep::verify {

struct Model {
  Costs costs;
  double clock_cost_ns;
  double turns_per_ns;  // of one whole core (costs.h)
};
Model measure_model();
Model less_disturbed(const Model& a, const Model& b);  // the better of each: disturbance only adds time
nlohmann::ordered_json describe(const Model& model);

// Work that can be repeated after `reset`. `bytes` is its memory traffic if caches do not hold the data.
struct Repeatable {
  std::function<void()> reset, work;
  double bytes;
};

// A row: cores; modelled_ms, which is the larger of compute_ms and memory_ms; the shares of the cores' time (replay.h);
// and, if the machine has that many cores, measured_ms, off_by, which is modelled / measured - 1, and whole_cores, which
// says whether enough of the measured runs had the cores that they asked for (samples.h). The row keeps the least
// disturbed of the recorded and of the measured runs, because other work on the machine only adds time. There are at
// least three of each, and as many as fit .2 s (quick: one).
nlohmann::ordered_json scale_row(const Model& model, const Repeatable& what, int cores, bool quick);

}  // namespace lockstep::verify
