// Box against box: separating axes, then contact points.
//
// Two boxes are apart if and only if they are apart along one of fifteen axes: the three that the faces of either are across, and the nine
// that are across an edge of each. Most pairs that are apart show it along the first few, so every test may be the last ([LRB08] Figure
// 10a). Where they overlap, the axis of least overlap is the way to push them apart.
//
// If a face gave the axis, the face of the other box that looks towards it most, the incident face, is clipped against it. Both are seen
// along the normal, from the reference face: a rectangle, and in its plane a parallelogram whose points have a separation each. The corners
// of what they have in common are candidates, each in a slot of its own: two for each edge of the parallelogram, where it enters the
// rectangle (or begins in it) and where it leaves; one for each corner of the rectangle within the parallelogram. Fixed slots instead of
// the usual list that grows and shrinks, plane by plane: sixteen pairs fill the same slots at once. Of the candidates four are kept, the
// deepest first, then those that support the most area.
//
// If two edges gave the axis they touch in one point; but where they belong to faces nearly flush, as in a stack, those are clipped as
// above along the edges' normal, so that contacts do not come and go as one axis or the other wins by a hair.
//
// Source: [LRB08] "Collision Detection", Figure 10; Gottschalk, Lin and Manocha, SIGGRAPH 1996 (axes); Ericson, Real-Time Collision
//         Detection (2005), 4.4.1 and 5.1.9; Liang and Barsky, ACM Trans. Graphics 3 (1984) (clipping). The contract stands in
//         common/rigid/narrow_phase.h, bounds in common/rigid/box_pair.h.
#include <limits>
#include <utility>

#include "common/real.h"
#include "common/rigid/box_pair.h"
#include "common/rigid/narrow_phase.h"

namespace lockstep::rigid::serial {
namespace {

constexpr Real infinity = std::numeric_limits<Real>::infinity();

// Axes are numbered: a's faces 0 .. 2, b's 3 .. 5, then a's axis i x b's axis j, 6 + 3 i + j.
struct Axis {
  int number;
  Real separation;
};

constexpr int separated = -1;

// Of the faces' axes the one of greatest separation, a's preferred to b's; none if one separates by more than margin.
Axis best_face(const BoxPair<Real>& boxes, Real margin) {
  Axis best = {0, -infinity}, best_b = best;
  for (int i = 0; i < 3; ++i) {
    const Real separation = face_separation_a(boxes, i);
    if (separation > margin) return {separated, separation};
    if (separation > best.separation) best = {i, separation};
  }
  for (int j = 0; j < 3; ++j) {
    const Real separation = face_separation_b(boxes, j);
    if (separation > margin) return {separated, separation};
    if (separation > best_b.separation) best_b = {3 + j, separation};
  }
  return best_b.separation > best.separation + axis_preference * largest_half(boxes) ? best_b : best;
}

// Of the edges' axes and that of a face, likewise; the face's preferred.
Axis best_axis(const BoxPair<Real>& boxes, Real margin, const Axis& face) {
  Axis best = {0, -infinity};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const Real sine_2 = edge_sine_2(boxes, i, j);
      if (sine_2 <= parallel_sine_2) continue;
      const Real separation = edge_separation(boxes, i, j, sine_2);
      if (separation > margin) return {separated, separation};
      if (separation > best.separation) best = {6 + 3 * i + j, separation};
    }
  return best.separation > face.separation + axis_preference * largest_half(boxes) ? best : face;
}

// a's axis i x b's axis j, of length 1, from a to b, along a's axes.
Three<Real> edge_normal(const BoxPair<Real>& boxes, int i, int j) {
  const auto& [half_a, half_b, t, r] = boxes;
  Three<Real> n = {0, 0, 0};
  n[(i + 1) % 3] = -r[(i + 2) % 3][j], n[(i + 2) % 3] = r[(i + 1) % 3][j];
  const Real length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  const Real scale = (t[0] * n[0] + t[1] * n[1] + t[2] * n[2] < 0 ? Real(-1) : Real(1)) / length;
  return {scale * n[0], scale * n[1], scale * n[2]};
}

// Which of three is the longest, the first of equals.
int longest(const Three<Real>& v) {
  const int i = abs(v[1]) > abs(v[0]) ? 1 : 0;
  return abs(v[2]) > max(abs(v[0]), abs(v[1])) ? 2 : i;
}

// Two faces, seen along the normal. The origin is the middle of the reference face, x and y run along it and z out of it.
struct Faces {
  Real half_x, half_y;            // of the reference face
  Vector3<Real> normal;           // z > 0
  Vector3<Real> middle, p, q;     // incident face: its middle and its half sides, as x, y and separation
  Real lowest;                    // separation of the incident face's deepest corner, rounded as the axis's is
  Real size;                      // the largest half side
  Vector3<Real> origin, x, y, z;  // in the world
  std::int32_t feature;           // of slot 0
};

Faces see_faces(const BoxPair<Real>& boxes, const Pose<Real>& pose, bool on_b, int axis, const Three<Real>& normal) {
  const BoxPair<Real> from_reference = on_b ? swapped(boxes) : boxes;
  const auto& [half_a, half_b, t, r] = from_reference;
  const int x = (axis + 1) % 3, y = (axis + 2) % 3;
  const Real up = normal[axis] < 0 ? Real(-1) : Real(1);
  const Three<Real> row_x = r[x], row_y = r[y], row_z = {up * r[axis][0], up * r[axis][1], up * r[axis][2]};
  const int incident = longest(row_z), p = (incident + 1) % 3, q = (incident + 2) % 3;
  const Real facing = row_z[incident] < 0 ? Real(1) : Real(-1), out = facing * half_b[incident];

  Faces faces;
  faces.half_x = half_a[x], faces.half_y = half_a[y];
  faces.normal = {normal[x], normal[y], up * normal[axis]};
  // Along the normal, one unit of height is this much separation.
  const Real per_height = 1 / faces.normal.z;
  faces.lowest = (up * t[axis] - (half_a[axis] + reach_of_b(from_reference, axis))) * per_height;
  const auto seen = [&](Real x, Real y, Real separation) {
    return Vector3<Real>{x - faces.normal.x * separation, y - faces.normal.y * separation, separation};
  };
  faces.p = seen(half_b[p] * row_x[p], half_b[p] * row_y[p], half_b[p] * row_z[p] * per_height);
  faces.q = seen(half_b[q] * row_x[q], half_b[q] * row_y[q], half_b[q] * row_z[q] * per_height);
  faces.middle = seen(t[x] + out * row_x[incident], t[y] + out * row_y[incident], faces.lowest + abs(faces.p.z) + abs(faces.q.z));
  faces.size = largest_half(boxes);

  const Matrix3<Real> m = matrix_of(pose.orientation);
  const Three<Vector3<Real>> column = {m.x, m.y, m.z};
  faces.x = column[x], faces.y = column[y], faces.z = up * column[axis];
  faces.origin = pose.position + half_a[axis] * faces.z;
  faces.feature = (((on_b ? 6 : 0) + 2 * axis + (up > 0 ? 1 : 0)) * 6 + 2 * incident + (facing > 0 ? 1 : 0)) * slots;
  return faces;
}

// A point that both faces have, seen along the normal.
struct Candidate {
  Real x, y, separation;
};

// Signs of p and q at corner k, counterclockwise; and of x and y.
constexpr Real sign_p[] = {1, -1, -1, 1}, sign_q[] = {1, 1, -1, -1};

Candidate corner(const Faces& faces, Real p, Real q) {
  const Vector3<Real>& middle = faces.middle;
  return {middle.x + p * faces.p.x + q * faces.q.x, middle.y + p * faces.p.y + q * faces.q.y,
          faces.lowest + ((abs(faces.p.z) + p * faces.p.z) + (abs(faces.q.z) + q * faces.q.z))};
}

// The part of a line that is within |x| <= half: from start on, t from near to far of a step, whose inverse length is given.
struct Span {
  Real near, far;
};
Span span_within(Real start, Real step, Real per_step, Real half) {
  const Real towards = step < 0 ? -start : start;
  return {(-half - towards) * per_step, (half - towards) * per_step};
}
Real inverse_length(Real step) { return 1 / max(abs(step), Real(1e-30f)); }

// All candidates: which slots are valid. There is at least one.
void find_candidates(const Faces& faces, Real separation, Candidate (&candidate)[slots], bool (&valid)[slots]) {
  const Vector3<Real>&middle = faces.middle, &p = faces.p, &q = faces.q;
  const Real widening = face_widening * faces.size, half_x = faces.half_x + widening, half_y = faces.half_y + widening;
  bool found = false;

  // Edge k leads from corner k to the next: along -p, -q, p and q.
  const Real per_p_x = inverse_length(2 * p.x), per_p_y = inverse_length(2 * p.y);
  const Real per_q_x = inverse_length(2 * q.x), per_q_y = inverse_length(2 * q.y);
  for (int k = 0; k < 4; ++k) {
    const bool along_p = k % 2 == 0;
    const Real way = k < 2 ? -2 : 2;
    const Vector3<Real> step = way * (along_p ? p : q);
    const Candidate start = corner(faces, sign_p[k], sign_q[k]);
    const Span x = span_within(start.x, step.x, along_p ? per_p_x : per_q_x, half_x);
    const Span y = span_within(start.y, step.y, along_p ? per_p_y : per_q_y, half_y);
    const Real enter = max(max(x.near, y.near), Real(0)), exit = min(min(x.far, y.far), Real(1));
    const auto at = [&](Real t) { return Candidate{start.x + t * step.x, start.y + t * step.y, start.separation + t * step.z}; };
    candidate[2 * k] = at(enter), candidate[2 * k + 1] = at(exit);
    valid[2 * k] = enter <= exit;
    valid[2 * k + 1] = enter <= exit && exit < 1;
    found = found || valid[2 * k];
  }

  // A corner of the reference face is middle + s p + t q; within the incident face if |s|, |t| < 1, by a little more than
  // those are within that an edge above finds.
  const Real area = p.x * q.y - p.y * q.x, per_area = 1 / area, inside = Real(.5) * widening;
  const Real most_s = abs(area) - inside * max(abs(q.x), abs(q.y)), most_t = abs(area) - inside * max(abs(p.x), abs(p.y));
  for (int k = 0; k < 4; ++k) {
    const Real x = sign_p[k] * faces.half_x, y = sign_q[k] * faces.half_y;
    const Real from_x = x - middle.x, from_y = y - middle.y;
    const Real s = from_x * q.y - from_y * q.x, t = p.x * from_y - p.y * from_x;
    candidate[8 + k] = {x, y, middle.z + (s * p.z + t * q.z) * per_area};
    valid[8 + k] = abs(s) < most_s && abs(t) < most_t;
    found = found || valid[8 + k];
  }

  // Boxes apart may be so diagonally: no part of one over the other. Then the deepest corner stands for them.
  candidate[12] = corner(faces, p.z < 0 ? Real(1) : Real(-1), q.z < 0 ? Real(1) : Real(-1));
  candidate[12].separation = separation;
  valid[12] = !found;
}

// Of the candidates at most four: the deepest, then of those within margin the farthest from it, and the farthest from the line through
// both on either side. Of equals the one in the first slot; and no point that is nearer than same_point to the first, or to the line. True
// where kept. The axis says that the boxes are within margin: if the deepest is not, by rounding, or as boxes that are apart may be so
// diagonally, it takes the axis's separation.
void keep_four(Candidate (&candidate)[slots], Real size, Real margin, Real separation, bool (&valid)[slots]) {
  const Real preference = axis_preference * size, same = same_point * size;
  int first = 0, second = -1, left = -1, right = -1;
  Real least = infinity;
  for (int k = 0; k < slots; ++k)
    if (valid[k] && candidate[k].separation < least - preference) least = candidate[k].separation, first = k;
  for (int k = 0; k < slots; ++k) valid[k] = valid[k] && candidate[k].separation <= margin;
  if (least > margin) candidate[first].separation = separation;

  Real most = same * same;
  for (int k = 0; k < slots; ++k) {
    const Real x = candidate[k].x - candidate[first].x, y = candidate[k].y - candidate[first].y, distance_2 = x * x + y * y;
    if (valid[k] && distance_2 > most) most = distance_2, second = k;
  }
  if (second >= 0) {
    const Real along_x = candidate[second].x - candidate[first].x, along_y = candidate[second].y - candidate[first].y;
    Real most_left = same * sqrt(most), most_right = most_left;
    for (int k = 0; k < slots; ++k) {
      const Real area = along_x * (candidate[k].y - candidate[first].y) - along_y * (candidate[k].x - candidate[first].x);
      if (valid[k] && area > most_left) most_left = area, left = k;
      if (valid[k] && -area > most_right) most_right = -area, right = k;
    }
  }
  for (int k = 0; k < slots; ++k) valid[k] = k == first || k == second || k == left || k == right;
}

// Points of two faces.
void face_contact(const BoxPair<Real>& boxes, const Pose<Real>& pose, bool on_b, int axis, const Three<Real>& normal, Real margin,
                  Real separation, Manifold<Real>& manifold) {
  const Faces faces = see_faces(boxes, pose, on_b, axis, normal);
  Candidate candidate[slots];
  bool valid[slots];
  find_candidates(faces, separation, candidate, valid);
  keep_four(candidate, faces.size, margin, separation, valid);

  const auto in_world = [&](const Vector3<Real>& v) { return v.x * faces.x + v.y * faces.y + v.z * faces.z; };
  const Vector3<Real> out = in_world(faces.normal);
  manifold.normal = on_b ? -out : out;
  for (int k = 0; k < slots; ++k)
    if (valid[k]) {
      const auto& [x, y, separation] = candidate[k];
      manifold.feature[manifold.count] = faces.feature + k;
      manifold.point[manifold.count++] = {faces.origin + (in_world({x, y, 0}) + Real(.5) * separation * out), separation};
    }
}

// The point of two edges: midway between their closest points.
void edge_contact(const BoxPair<Real>& boxes, const Pose<Real>& pose_a, int i, int j, const Three<Real>& normal,
                  const Three<Real>& normal_b, Real separation, Manifold<Real>& manifold) {
  const auto& [half_a, half_b, t, r] = boxes;
  // The edge of a that is foremost along the normal, and the edge of b that is hindmost: their middles.
  Three<Real> on_a, on_b = t;
  for (int k = 0; k < 3; ++k) on_a[k] = k == i ? Real(0) : normal[k] < 0 ? -half_a[k] : half_a[k];
  for (int k = 0; k < 3; ++k) {
    const Real along = k == j ? Real(0) : normal_b[k] < 0 ? half_b[k] : -half_b[k];
    on_b = {on_b[0] + along * r[0][k], on_b[1] + along * r[1][k], on_b[2] + along * r[2][k]};
  }
  // Seen along the normal they cross where b's has no distance from a's line: along that distance, and not along the edges, which may be
  // all but parallel, rounding moves them no farther apart than it moves points.
  const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
  const Three<Real> direction = {r[0][j], r[1][j], r[2][j]}, between = {on_b[0] - on_a[0], on_b[1] - on_a[1], on_b[2] - on_a[2]};
  const Real across = between[i1] * normal[i2] - between[i2] * normal[i1], slope = direction[i1] * normal[i2] - direction[i2] * normal[i1];
  const auto within = [](Real x, Real half) { return min(max(x, -half), half); };
  const Real along_edge_b = within(-across / slope, half_b[j]);
  const Real along_edge_a = within(between[i] + along_edge_b * direction[i], half_a[i]);
  for (int k = 0; k < 3; ++k) {
    on_b[k] = on_b[k] + along_edge_b * direction[k];
    on_a[k] = k == i ? along_edge_a : on_a[k];
  }

  const Matrix3<Real> m = matrix_of(pose_a.orientation);
  const auto edge = [](int axis, bool next, bool after) { return 4 * axis + (next ? 1 : 0) + (after ? 2 : 0); };
  const int edge_a = edge(i, !(normal[i1] < 0), !(normal[i2] < 0));
  const int edge_b = edge(j, normal_b[j1] < 0, normal_b[j2] < 0);
  const Vector3<Real> twice = {on_a[0] + on_b[0], on_a[1] + on_b[1], on_a[2] + on_b[2]};
  manifold.normal = m * Vector3<Real>{normal[0], normal[1], normal[2]};
  manifold.count = 1;
  manifold.point[0] = {pose_a.position + m * (Real(.5) * twice), separation};
  manifold.feature[0] = first_edge_feature + 12 * edge_a + edge_b;
}

}  // namespace

void box_box(const Placed<Real>& placed, std::span<const Pair> pairs, Real margin, std::span<Manifold<Real>> manifolds) {
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const auto [a, b] = pairs[k];
    const Pose<Real>&pose_a = placed.pose[a], &pose_b = placed.pose[b];
    const BoxPair<Real> boxes = box_pair(pose_a.position, pose_a.orientation, placed.colliders.size[a],  //
                                         pose_b.position, pose_b.orientation, placed.colliders.size[b]);
    manifolds[k].count = 0;
    const Axis face = best_face(boxes, margin);
    if (face.number == separated) continue;
    const Axis axis = best_axis(boxes, margin, face);
    if (axis.number == separated) continue;

    Manifold<Real> manifold = {};
    manifold.a = a, manifold.b = b;
    if (axis.number < 6) {
      const bool on_b = axis.number >= 3;
      const int number = axis.number % 3;
      const Real offset = on_b ? -along_b(boxes, boxes.offset)[number] : boxes.offset[number];
      Three<Real> normal = {0, 0, 0};
      normal[number] = offset < 0 ? Real(-1) : Real(1);
      face_contact(boxes, on_b ? pose_b : pose_a, on_b, number, normal, margin, axis.separation, manifold);
    } else {
      const int i = (axis.number - 6) / 3, j = (axis.number - 6) % 3;
      const Three<Real> normal = edge_normal(boxes, i, j), normal_b = along_b(boxes, normal);
      const int face_a = longest(normal), face_b = longest(normal_b);
      if (min(abs(normal[face_a]), abs(normal_b[face_b])) >= Real(flush_cosine))
        face_contact(boxes, pose_a, false, face_a, normal, margin, axis.separation, manifold);
      else
        edge_contact(boxes, pose_a, i, j, normal, normal_b, axis.separation, manifold);
    }
    manifolds[k] = manifold;
  }
}

}  // namespace lockstep::rigid::serial
