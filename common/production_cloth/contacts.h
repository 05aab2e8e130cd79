// Contacts of a cloth with itself: where pairs of elements are near each other, or meet within a step.
//
// A contact acts on four vertices. The relative velocity of its two points is the sum of weight_i v_i: the weights of
// the point, or of the first edge, sum to 1, those of the triangle, or of the second edge, to -1. The normal n has
// length 1 and points to the side on which the point, or the first edge, is at the start of the step: elements approach
// where n . (sum of weight_i v_i) < 0. An impulse J along n changes v_i by J weight_i n / m_i.
#pragma once

#include <cstdint>

#include "common/arrays.h"

namespace lockstep::production_cloth {

// Four numbers a contact, side by side. Padded for sixteen contacts at a time (resize).
template <class Real>
struct Contacts {
  std::size_t count = 0;
  Array<std::int32_t> corner;  // [4 k + i]: vertices, all different
  Array<Real> weight;          // [4 k + i]
  Array<Real> normal;          // [4 k + c], c < 3: the normal; [4 k + 3]: near elements: their distance, m; impacts:
                               // when they meet, as a share of the step from 0 to 1

  void resize(std::size_t n) {
    count = n;
    corner.resize(4 * padded(n)), weight.resize(4 * padded(n)), normal.resize(4 * padded(n));
  }
};

template <Is<Contacts> C, class F>
void for_each_array(C& contacts, const F& f) {
  f("corner", contacts.corner, 4 * contacts.count);
  f("weight", contacts.weight, 4 * contacts.count);
  f("normal", contacts.normal, 4 * contacts.count);
}

}  // namespace lockstep::production_cloth
