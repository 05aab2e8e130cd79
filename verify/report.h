// Reports: the machine and JSON files.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "verify/options.h"
#include "verify/program.h"

namespace lockstep::verify {

// cpu, cores, isa, lanes, compiler, flags, commit, date (UTC), omp settings.
nlohmann::ordered_json machine();

// The version of the reports' layout. It grows when a field changes its meaning or goes.
inline constexpr int schema = 1;

// A report file, options.json: {"schema", "command", "complete", "quick", "machine", "shard", "rows"}. Made before the
// work, it refuses a path that cannot be written at once. It is kept while rows come, so that a run that is cut off
// keeps what it has; it is `complete` once the run finished. Each version is written whole or not at all. Does nothing
// if the path is empty. The functions throw InputError if the file cannot be written.
// quick: whether the rows are rough.
// more: what else of the machine rows depend on; added to `on`.
// resume: whether to go on from the rows of a file that is there. Throws InputError if they were not made by the same
// commit on the same machine with the same settings, or are rough where these are not, or are of another shard.
class Report {
 public:
  explicit Report(const ReportOptions& options, const nlohmann::ordered_json& more = nlohmann::ordered_json::object());
  void keep(const nlohmann::ordered_json& rows);    // writes at most once a second
  void finish(const nlohmann::ordered_json& rows);  // writes

  // The rows to go on from, less those that were taken.
  const nlohmann::ordered_json& earlier() const { return earlier_; }
  // Takes the rows in which these fields have these values.
  nlohmann::ordered_json take_earlier(const nlohmann::ordered_json& fields);

  // Says in a shard's row where its case stands in the whole, so that `merge` can restore the order.
  void put_place(nlohmann::ordered_json& row, std::size_t place) const;

  nlohmann::ordered_json on = machine();  // what is measured of the machine is added to it

 private:
  void read_earlier();
  void write(const nlohmann::ordered_json& rows, bool complete);

  ReportOptions options_;
  double written_ = 0;  // when, as now() says
  nlohmann::ordered_json earlier_ = nlohmann::ordered_json::array();
};

// Writes a report as `Report` does. Throws InputError if it cannot be written.
void write_report(const std::string& path, const nlohmann::ordered_json& report);

}  // namespace lockstep::verify
