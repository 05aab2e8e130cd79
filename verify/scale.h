// The scaling model (notes/scaling.md): the time of work on more cores than this machine has, beside measured times.
#pragma once

#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "verify/options.h"
#include "verify/replay.h"

namespace lockstep::verify {

struct Model {
  Costs costs;
  double last_level_cache_bytes;
  double clock_cost_ns;
  double turns_per_ns;      // of one whole core (costs.h)
  bool of_another = false;  // whether any of these is another machine's: then nothing is timed beside the model
};
Model measure_model();
Model less_disturbed(const Model& a, const Model& b);  // the better of each: disturbance only adds time
nlohmann::ordered_json describe(const Model& model);   // the costs by name

// The model with these costs, by their names in describe(), of another machine.
Model with_given(Model model, const std::map<std::string, double>& given);

// Work that can be repeated after `reset`; `bytes` and `data` are those of Work (kernel.h).
struct Repeatable {
  std::function<void()> reset, work;
  double bytes;
  double data = 0;
};

// The work on `cores`, recorded once.
Record record_once(const Repeatable& what, int cores, const Model& model);

// The record replayed by the model.
Replayed replay(const Record& record, const Repeatable& what, const Model& model);

// Takes the place of `least`, which starts with an infinite total, if it is shorter.
void keep_shorter(Replayed& least, const Replayed& replayed);

// The fields of a row that come from the model: modelled_ms, compute_ms, memory_ms and the shares of the cores' time.
nlohmann::ordered_json fields_of(const Replayed& replayed, const Repeatable& what, int cores, const Model& model);

// How often to record and, on numbers of cores that the machine has, to time: at least so often, and as often as fits
// the seconds. `passes`: how many times all that is timed is gone through, with minutes between, because other work on
// the machine disturbs it for longer than a row takes.
struct Effort {
  int least;   // of the records of a row, and of its timed runs
  int fewest;  // of a row that takes long: `least` would take more than five times `seconds_here`
  double seconds_here, seconds_beyond;
  int passes;
};
Effort effort_of(const ReportOptions& options);

// A row: cores; modelled_ms, which is the larger of compute_ms and memory_ms; the shares of the cores' time (replay.h);
// undisturbed_ms, likewise of the least of each stretch of all records (Records);
// and, if the machine has that many cores and the model is its own, measured_ms, off_by, which is
// modelled / measured - 1, and whole_cores, which says whether enough of the measured runs had the cores that they
// asked for (samples.h). The row keeps the least disturbed of the recorded and of the measured runs, because other work
// on the machine only adds time.
nlohmann::ordered_json scale_row(const Model& model, const Repeatable& what, int cores, const Effort& effort);

}  // namespace lockstep::verify
