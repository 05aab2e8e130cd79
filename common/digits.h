// Numbers in text for people and in files that are text.
#pragma once

#include <cstdio>
#include <string>

namespace lockstep {

// x with at most so many significant digits, and none that say nothing: 0.5, 1073741824, 1e+18.
inline std::string digits_of(double x, int significant = 10) {
  char text[32];
  std::snprintf(text, sizeof text, "%.*g", significant, x);
  return text;
}

}  // namespace lockstep
