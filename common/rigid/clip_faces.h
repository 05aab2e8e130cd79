// Two faces clipped against one another: the formulas of convex_clip, which both versions share. For T a number or
// sixteen lanes.
//
// Every edge of the one face (incident) is cut by the planes through the sides of the other (reference), by Cyrus and
// Beck. Where it enters and leaves are candidates, and so are corners of the reference face that have the incident face
// above. Each candidate has a slot of its own; there are no lists. In lanes, slots are the same for all sixteen pairs,
// and masks say which are candidates at all.
#pragma once

#include <array>
#include <limits>

#include "common/rigid/convexes.h"
#include "common/rigid/keep_four.h"
#include "common/rigid/truth.h"

namespace lockstep::rigid {

// Of sixty-four: each edge of the incident face gives two candidates, each corner of the reference one, and the closest
// points one.
inline constexpr int most_candidates = 3 * most_hull_vertices + 1;
// Of two faces as good within 1e-3 (of the cosine), a's is the reference, so that rounding does not choose.
inline constexpr float preference = 1e-3f;
// A reference corner is projected along the normal onto the incident face only where that face is tilted by less than
// 84 degrees.
inline constexpr float least_incident_cosine = .1f;

// Where a point of a contact comes from: entry (even) and exit (odd) of the edges of the incident face, corners of the
// reference face, or the closest points; and of which faces, reference and incident.
inline constexpr int slot_of_corner = 2 * most_hull_vertices, slot_of_closest = slot_of_corner + most_hull_vertices;
template <class I>
inline I feature_of(const I& of_b, const I& reference, const I& incident, const I& slot) {
  return ((of_b * I(128) + reference) * I(128) + incident) * I(256) + slot;
}

// A face that supports the normal: its corners, counterclockwise from outside, in a's frame; a segment or a point is
// its own face.
template <class T>
struct Polygon {
  Integer<T> count;
  int most;       // corners of any lane
  Quad<T> plane;  // outward unit normal, and the distance of the plane from the origin; 0 of a core without faces
  std::array<Vector3<T>, most_hull_vertices> corner;

  Vector3<T> next(int k) const {
    return k + 1 < most ? select(Integer<T>(k + 1) < count, corner[k + 1], corner[0]) : corner[0];
  }
  // The height of a point above the plane, m.
  T height(const Vector3<T>& point) const { return dot(vector_of(plane), point) - plane.w; }
};

// b's plane in a's frame.
template <class T>
inline Quad<T> turned_plane(const Cores<T>& cores, const Quad<T>& plane) {
  const Vector3<T> normal = cores.turn * vector_of(plane);
  return {normal.x, normal.y, normal.z, plane.w + dot(normal, cores.offset)};
}

// A point that both faces have.
template <class T>
struct FacePoint {
  Vector3<T> middle;  // between the cores
  T separation;       // of the cores
  Integer<T> slot;
};
template <class T>
inline void take(const Truth<T>& mask, const FacePoint<T>& from, FacePoint<T>& to) {
  to.middle = select(mask, from.middle, to.middle);
  to.separation = select(mask, from.separation, to.separation), to.slot = select(mask, from.slot, to.slot);
}

template <class T>
struct FacePoints {
  using Point = FacePoint<T>;

  int count = 0;
  std::array<Truth<T>, most_candidates> valid;
  std::array<Vector3<T>, most_candidates> middle;
  std::array<T, most_candidates> separation;
  std::array<int, most_candidates> slot;
  Vector3<T> normal;
  T least_apart;  // points nearer than this are one

  void add(const Truth<T>& is_valid, const Vector3<T>& position, const T& distance, int from) {
    valid[count] = is_valid, middle[count] = position, separation[count] = distance, slot[count++] = from;
  }

  // What keep_four asks for.
  template <class Action>
  void each(const Action& action) const {
    for (int k = 0; k < count; ++k)
      if (any(valid[k])) action(Point{middle[k], separation[k], Integer<T>(slot[k])}, valid[k]);
  }
  T deeper_by() const { return T(0); }
  T distance_2(const Point& point, const Point& deepest) const {
    const Vector3<T> away = point.middle - deepest.middle;
    return dot(away, away);
  }
  T least_distance_2() const { return least_apart * least_apart; }
  auto side(const Point& deepest, const Point& farthest) const {
    const Vector3<T> across = cross(normal, farthest.middle - deepest.middle), origin = deepest.middle;
    return [=](const Point& point) { return dot(across, point.middle - origin); };
  }
  T least_side(const T& distance_2) const { return least_apart * sqrt(distance_2); }
};

// The incident face against the reference face, where the mask is true. `out` points from the reference face towards
// the incident one.
template <class T>
inline void clip_faces(const Truth<T>& mask, const Polygon<T>& reference, const Polygon<T>& incident,
                       const Vector3<T>& out, const T& slack, FacePoints<T>& points) {
  using I = Integer<T>;
  // Sides stand on the edges of the reference face, along `out`. What is beyond one by no more than rounding is within.
  std::array<Vector3<T>, most_hull_vertices> side;
  std::array<T, most_hull_vertices> border;
  for (int k = 0; k < reference.most; ++k) {
    const Vector3<T>&from = reference.corner[k], to = reference.next(k);
    side[k] = cross(to - from, out);
    border[k] = dot(side[k], from) + slack * taxicab(side[k]);
  }

  const T per_cosine = T(1) / dot(vector_of(reference.plane), out);
  const I edges = select(incident.count == I(2), I(1), incident.count);
  for (int j = 0; j < incident.most; ++j) {
    const Vector3<T>&from = incident.corner[j], along = incident.next(j) - from;
    T enter = 0, leave = 1;
    Truth<T> within = mask & (I(j) < edges);
    for (int k = 0; k < reference.most; ++k) {
      const Truth<T> is_side = I(k) < reference.count;
      const T beyond = dot(side[k], from) - border[k], slope = dot(side[k], along);
      const T crossing = -beyond / select(slope == T(0), T(1), slope);
      enter = select(is_side & (slope < T(0)), max(crossing, enter), enter);
      leave = select(is_side & (slope > T(0)), min(crossing, leave), leave);
      within = within & !(is_side & (slope == T(0)) & (beyond > T(0)));
    }
    within = within & (enter <= leave);
    const auto add = [&](const Truth<T>& valid, const T& where, int slot) {
      const Vector3<T> point = from + where * along;
      const T separation = reference.height(point) * per_cosine;
      points.add(valid, point - (T(.5f) * separation) * out, separation, slot);
    };
    // Where it leaves at its end, the next edge enters, unless this is a segment.
    add(within, enter, 2 * j);
    add(within & ((leave < T(1)) | (incident.count == I(2))), leave, 2 * j + 1);
  }

  if (incident.most < 3) return;
  const T cosine = -dot(vector_of(incident.plane), out),
          per_incident_cosine = T(1) / max(cosine, T(least_incident_cosine));
  for (int k = 0; k < reference.most; ++k) {
    const Vector3<T>& corner = reference.corner[k];
    Truth<T> within = mask & (I(k) < reference.count) & (incident.count >= I(3)) & (cosine > T(least_incident_cosine));
    for (int j = 0; j < incident.most; ++j) {
      const Vector3<T>&from = incident.corner[j], out_of_edge = cross(out, incident.next(j) - from);
      within = within & ((I(j) >= incident.count) | (dot(out_of_edge, corner - from) < -slack * taxicab(out_of_edge)));
    }
    const T separation = incident.height(corner) * per_incident_cosine;
    points.add(within, corner + (T(.5f) * separation) * out, separation, slot_of_corner + k);
  }
}

// Of the points of faces, those within margin; and where the faces do not hold the deepest points, those are one more.
template <class T>
inline void finish_points(const Vector3<T>& middle, const T& separation, const T& radii, const T& margin,
                          const T& slack, FacePoints<T>& points) {
  T deepest = std::numeric_limits<float>::infinity();
  for (int k = 0; k < points.count; ++k) {
    deepest = select(points.valid[k], min(points.separation[k], deepest), deepest);
    points.valid[k] = points.valid[k] & (points.separation[k] - radii <= margin);
  }
  const Truth<T> near = separation - radii <= margin, deeper = deepest > separation + T(4) * slack;
  points.add(near & deeper, middle, separation, slot_of_closest);
}

}  // namespace lockstep::rigid
