// The types that go with a number, for formulas that are written once for a number or for sixteen lanes.
#pragma once

#include "common/math.h"

namespace lockstep::rigid {

template <class T>
using Truth = decltype(T(0) < T(0));  // bool of a number, maskv of floatv
template <class T>
using Integer = decltype(to_int(T(0)));  // std::int32_t of a number, intv of floatv

// True or false in all lanes.
template <class T>
inline Truth<T> all_true() {
  return T(0) <= T(0);
}
template <class T>
inline Truth<T> all_false() {
  return T(0) < T(0);
}

}  // namespace lockstep::rigid
