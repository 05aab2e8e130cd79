// Reports: the machine, JSON files, and progress on the terminal.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace lockstep::verify {

// cpu, cores, isa, lanes, compiler, flags, commit, date (UTC), omp settings.
nlohmann::ordered_json machine();

// The commit, the instruction set and the compiler, in one line.
std::string version();

// Writes {"machine": ..., "rows": rows}, whole or not at all. Throws InputError if the file cannot be written.
void write_report(const std::string& path, const nlohmann::ordered_json& machine, const nlohmann::ordered_json& rows);

// Seconds since some fixed moment.
double now();

// Prints "fluid/forces ..." on a terminal; the next line overwrites it. Prints nothing into a pipe.
void progress(const std::string& what);

}  // namespace lockstep::verify
