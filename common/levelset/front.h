// The front of the Fast Marching Method: which points it has accepted, and a binary heap of the trial points beside it,
// the nearest first. Each trial point knows its place in the heap, so that it rises when its distance falls.
//
// Source: Sethian, A fast marching level set method for monotonically advancing fronts, PNAS 93 (1996).
#pragma once

#include <cstdint>
#include <vector>

#include "common/levelset/field.h"

namespace lockstep::levelset {

template <class Real>
class Front {
 public:
  // `distance` stays the caller's; lower() writes to it.
  explicit Front(Field<Real>& distance)
      : distance_(distance), place_(make_field<std::int32_t>(distance.nx, distance.ny, distance.nz, 0, untried)) {}

  bool empty() const { return heap_.empty(); }
  bool has_accepted(const Point& p) const { return place_(p.x, p.y, p.z) == accepted; }
  void accept(const Point& p) { place_(p.x, p.y, p.z) = accepted; }

  // Sets the distance of a point: lowers that of a trial point, or makes an untried point a trial point.
  void lower(const Point& p, Real distance) {
    distance_(p.x, p.y, p.z) = distance;
    int& place = place_(p.x, p.y, p.z);
    if (place == untried) {
      place = static_cast<int>(heap_.size());
      heap_.push_back({distance, p});
    }
    heap_[place].distance = distance;
    rise(place);
  }

  // Accepts and returns the nearest trial point. The front must not be empty().
  Point accept_nearest() {
    const Point nearest = heap_[0].point;
    accept(nearest);
    const Entry last = heap_.back();
    heap_.pop_back();
    if (!heap_.empty()) {
      put(0, last);
      sink(0);
    }
    return nearest;
  }

 private:
  static constexpr int untried = -1, accepted = -2;  // values of place_; else the place in the heap

  struct Entry {
    Real distance;
    Point point;
    bool operator<(const Entry& other) const { return distance < other.distance; }
  };

  void put(int place, const Entry& entry) {
    heap_[place] = entry;
    place_(entry.point.x, entry.point.y, entry.point.z) = place;
  }

  void rise(int place) {
    const Entry entry = heap_[place];
    for (int above = (place - 1) / 2; place > 0 && entry < heap_[above]; place = above, above = (place - 1) / 2)
      put(place, heap_[above]);
    put(place, entry);
  }

  void sink(int place) {
    const Entry entry = heap_[place];
    const int size = static_cast<int>(heap_.size());
    for (int below = 2 * place + 1; below < size; below = 2 * place + 1) {
      if (below + 1 < size && heap_[below + 1] < heap_[below]) ++below;
      if (!(heap_[below] < entry)) break;
      put(place, heap_[below]);
      place = below;
    }
    put(place, entry);
  }

  Field<Real>& distance_;
  Field<std::int32_t> place_;
  std::vector<Entry> heap_;
};

}  // namespace lockstep::levelset
