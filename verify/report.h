// What runs report: the machine they ran on, tables on the terminal, JSON in files.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace lockstep::verify {

// cpu, cores, isa, lanes, compiler, flags, commit, date (UTC), omp settings.
nlohmann::ordered_json machine();

// Writes {"machine": ..., "rows": rows} whole or not at all. Throws InputError where it cannot be written.
void write_report(const std::string& path, const nlohmann::ordered_json& machine, const nlohmann::ordered_json& rows);

// Seconds since some fixed moment.
double now();

// "fluid/forces ..." on a terminal while it runs, overwritten by the next line; nothing in a pipe.
void progress(const std::string& what);

}  // namespace lockstep::verify
