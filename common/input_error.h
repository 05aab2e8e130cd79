// What is wrong with what the user gave: an argument, a scene, a file, a place to write to.
#pragma once

#include <stdexcept>

namespace lockstep {

// what() is one line for the user, without a full stop: where, then what was expected or what went wrong. The program
// prints it and exits with code 2.
struct InputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace lockstep
