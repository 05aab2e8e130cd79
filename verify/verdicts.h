// Rows of `verify`, and the counts of `verify` and `endure`, on the terminal.
#pragma once

#include <nlohmann/json.hpp>

namespace lockstep::verify {

void print_head();
void print_verdict(const nlohmann::ordered_json& row);

// What ends the rows of `verify`: a line for each kernel (only_failed: with a row that failed), and the counts. Returns
// the exit code: 1 if a row failed.
int sum_up(const nlohmann::ordered_json& rows, bool only_failed);
int sum_up_endured(const nlohmann::ordered_json& rows);  // the same of `endure`: the counts

}  // namespace lockstep::verify
