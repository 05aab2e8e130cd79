// The program itself: its version, its clock, its progress on the terminal. Defined in report.cpp. Unlike report.h,
// this includes no JSON library.
#pragma once

#include <string>

namespace lockstep::verify {

// The commit, the instruction set and the compiler, in one line.
std::string version();

// Seconds since some fixed moment.
double now();

// Prints "fluid/forces ..." on a terminal; the next line overwrites it. Prints nothing into a pipe.
void progress(const std::string& what);

}  // namespace lockstep::verify
