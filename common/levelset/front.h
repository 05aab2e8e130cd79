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
      : distance_(distance), place_(distance.value.size(), untried) {}

  bool empty() const { return heap_.empty(); }
  bool has_accepted(std::size_t index) const { return place_[index] == accepted; }
  bool has_accepted(const Point& p) const { return has_accepted(index_of(p)); }
  void accept(const Point& p) { place_[index_of(p)] = accepted; }

  // Sets the distance of a point: lowers that of a trial point, or makes an untried point a trial point.
  void lower(const Point& p, Real distance) {
    distance_.value[index_of(p)] = distance;
    std::int32_t& place = place_[index_of(p)];
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

  std::size_t index_of(const Point& p) const { return distance_.index(p.x, p.y, p.z); }

  void put(int place, const Entry& entry) {
    heap_[place] = entry;
    place_[index_of(entry.point)] = place;
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
  Array<std::int32_t> place_;  // [index of the point in the field of distances]
  std::vector<Entry> heap_;
};

}  // namespace lockstep::levelset
