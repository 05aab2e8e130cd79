// The scaling model (notes/scaling.md): what work would take on more cores than this machine has, beside what it takes here.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>

#include "verify/replay.h"

namespace lockstep::verify {

struct Model {
  Costs costs;
  double clock_cost_ns;
};
Model measure_model();
Model less_disturbed(const Model& a, const Model& b);  // what disturbs only adds
nlohmann::ordered_json describe(const Model& model);

// Work that can be done again after `reset`, and what it must move to and from memory where caches do not hold it.
struct Repeatable {
  std::function<void()> reset, work;
  double bytes;
};

// cores, modelled_ms, the larger of compute_ms and memory_ms, where the cores' time goes (shares of it, replay.h), and, where the machine
// has that many, measured_ms and off_by: modelled over measured, less one. Of the recorded and of the measured runs, three at the least and
// as many as fit .2 s (quick: one), the least disturbed: what else the machine does only adds.
nlohmann::ordered_json scale_row(const Model& model, const Repeatable& what, int cores, bool quick);

}  // namespace lockstep::verify
