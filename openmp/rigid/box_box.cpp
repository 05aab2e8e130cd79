// Box against box: separating axes, then contact points, of sixteen pairs at once.
//
// Two boxes are apart if and only if they are apart along one of fifteen axes: the three that the faces of either are across, and the nine
// that are across an edge of each. Most pairs that are apart show it along the first few. Where they overlap, the axis of least overlap is
// the way to push them apart. Early outs are masks ([LRB08] Figure 10c): a lane whose pair is apart goes on for nothing until all are.
//
// What a pair needs next depends on its axis: nothing, the contact of two faces, or that of two edges. So a block's pairs go on to two
// queues, and whenever one has sixteen, they go through that contact together: lanes are full again however many pairs were apart.
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
#include <algorithm>
#include <bit>
#include <limits>
#include <utility>

#include "common/real.h"
#include "common/rigid/box_pair.h"
#include "common/rigid/narrow_phase.h"
#include "common/simd.h"
#include "openmp/rigid/lanes.h"

namespace lockstep::rigid::openmp {
namespace {

constexpr Real infinity = std::numeric_limits<Real>::infinity();

// Axes are numbered: a's faces 0 .. 2, b's 3 .. 5, then a's axis i x b's axis j, 6 + 3 i + j.
struct Axis {
  intv number;
  floatv separation;
};

LOCKSTEP_INLINE void choose_better(maskv better, Axis& best, const Axis& other) {
  where(better, best.number) = other.number, where(better, best.separation) = other.separation;
}

// Of the faces' axes the one of greatest separation, a's preferred to b's; pairs that one separates by more than margin leave `active`.
LOCKSTEP_INLINE Axis best_face(const BoxPair<floatv>& boxes, floatv margin, maskv& active) {
  Axis best = {0, -infinity}, best_b = best;
#pragma GCC unroll 3
  for (int i = 0; i < 3; ++i) {
    const floatv separation = face_separation_a(boxes, i);
    active &= ~(separation > margin);
    choose_better(separation > best.separation, best, {i, separation});
  }
#pragma GCC unroll 3
  for (int j = 0; j < 3; ++j) {
    const floatv separation = face_separation_b(boxes, j);
    active &= ~(separation > margin);
    choose_better(separation > best_b.separation, best_b, {3 + j, separation});
  }
  choose_better(best_b.separation > best.separation + axis_preference * largest_half(boxes), best, best_b);
  return best;
}

// Of the edges' axes and that of a face, likewise; the face's preferred.
LOCKSTEP_INLINE Axis best_axis(const BoxPair<floatv>& boxes, floatv margin, Axis face, maskv& active) {
  Axis best = {0, -infinity};
#pragma GCC unroll 3
  for (int i = 0; i < 3; ++i)
#pragma GCC unroll 3
    for (int j = 0; j < 3; ++j) {
      const floatv sine_2 = edge_sine_2(boxes, i, j);
      const maskv turned = ~(sine_2 <= parallel_sine_2);
      const floatv separation = edge_separation(boxes, i, j, sine_2);
      active &= ~(turned & (separation > margin));
      choose_better(turned & (separation > best.separation), best, {6 + 3 * i + j, separation});
    }
  choose_better(best.separation > face.separation + axis_preference * largest_half(boxes), face, best);
  return face;
}

// Of the edges' axis of that number, a's axis; of others, some axis.
LOCKSTEP_INLINE intv axis_a(intv number) { return select(number >= 12, intv(2), select(number >= 9, intv(1), 0)); }

// The axis after i.
LOCKSTEP_INLINE intv next(intv i) { return select(i == 2, 0, i + 1); }

// a's axis i x b's axis j, of length 1, from a to b, along a's axes.
LOCKSTEP_INLINE Three<floatv> edge_normal(const BoxPair<floatv>& boxes, intv i, intv j) {
  const auto& [half_a, half_b, t, r] = boxes;
  const Three<floatv> c = {r[0][j], r[1][j], r[2][j]};
  const Three<floatv> n = {select(i == 0, 0.f, select(i == 1, c[2], -c[1])), select(i == 1, 0.f, select(i == 2, c[0], -c[2])),
                           select(i == 2, 0.f, select(i == 0, c[1], -c[0]))};
  const floatv length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  const floatv scale = select(t[0] * n[0] + t[1] * n[1] + t[2] * n[2] < 0.f, floatv(-1), 1.f) / length;
  return {scale * n[0], scale * n[1], scale * n[2]};
}

// Which of three is the longest, the first of equals.
LOCKSTEP_INLINE intv longest(const Three<floatv>& v) {
  const intv i = select(abs(v[1]) > abs(v[0]), intv(1), 0);
  return select(abs(v[2]) > max(abs(v[0]), abs(v[1])), 2, i);
}

// Two faces, seen along the normal. The origin is the middle of the reference face, x and y run along it and z out of it.
struct Faces {
  floatv half_x, half_y;            // of the reference face
  Vector3<floatv> normal;           // z > 0
  Vector3<floatv> middle, p, q;     // incident face: its middle and its half sides, as x, y and separation
  floatv lowest;                    // separation of the incident face's deepest corner, rounded as the axis's is
  floatv size;                      // the largest half side
  Vector3<floatv> origin, x, y, z;  // in the world
  intv feature;                     // of slot 0
};

LOCKSTEP_INLINE Faces see_faces(const BoxPair<floatv>& boxes, const Pose<floatv>& pose, maskv on_b, intv axis, const Three<floatv>& normal) {
  const BoxPair<floatv> from_reference = choose(on_b, swapped(boxes), boxes);
  const auto& [half_a, half_b, t, r] = from_reference;
  const intv x = next(axis), y = next(x);
  const floatv up = select(normal[axis] < 0.f, floatv(-1), 1.f);
  const Three<floatv> row_x = r[x], row_y = r[y], row_z = {up * r[axis][0], up * r[axis][1], up * r[axis][2]};
  const intv incident = longest(row_z), p = next(incident), q = next(p);
  const floatv facing = select(row_z[incident] < 0.f, floatv(1), -1.f), out = facing * half_b[incident];

  Faces faces;
  faces.half_x = half_a[x], faces.half_y = half_a[y];
  faces.normal = {normal[x], normal[y], up * normal[axis]};
  // Along the normal, one unit of height is this much separation.
  const floatv per_height = 1 / faces.normal.z;
  faces.lowest = (up * t[axis] - (half_a[axis] + reach_of_b(from_reference, axis))) * per_height;
  const auto seen = [&](floatv x, floatv y, floatv separation) {
    return Vector3<floatv>{x - faces.normal.x * separation, y - faces.normal.y * separation, separation};
  };
  faces.p = seen(half_b[p] * row_x[p], half_b[p] * row_y[p], half_b[p] * row_z[p] * per_height);
  faces.q = seen(half_b[q] * row_x[q], half_b[q] * row_y[q], half_b[q] * row_z[q] * per_height);
  faces.middle = seen(t[x] + out * row_x[incident], t[y] + out * row_y[incident], faces.lowest + abs(faces.p.z) + abs(faces.q.z));
  faces.size = largest_half(boxes);

  const Matrix3<floatv> m = matrix_of(pose.orientation);
  const Three<Vector3<floatv>> column = {m.x, m.y, m.z};
  faces.x = column[x], faces.y = column[y], faces.z = up * column[axis];
  faces.origin = pose.position + half_a[axis] * faces.z;
  faces.feature =
      ((select(on_b, intv(6), 0) + 2 * axis + select(up > 0.f, intv(1), 0)) * 6 + 2 * incident + select(facing > 0.f, intv(1), 0)) * slots;
  return faces;
}

// A point that both faces have, seen along the normal.
struct Candidate {
  floatv x, y, separation;
};

// Signs of p and q at corner k, counterclockwise; and of x and y.
constexpr Real sign_p[] = {1, -1, -1, 1}, sign_q[] = {1, 1, -1, -1};

LOCKSTEP_INLINE Candidate corner(const Faces& faces, floatv p, floatv q) {
  const Vector3<floatv>& middle = faces.middle;
  return {middle.x + p * faces.p.x + q * faces.q.x, middle.y + p * faces.p.y + q * faces.q.y,
          faces.lowest + ((abs(faces.p.z) + p * faces.p.z) + (abs(faces.q.z) + q * faces.q.z))};
}

// The part of a line that is within |x| <= half: from start on, t from near to far of a step, whose inverse length is given.
struct Span {
  floatv near, far;
};
LOCKSTEP_INLINE Span span_within(floatv start, floatv step, floatv per_step, floatv half) {
  const floatv towards = select(step < 0.f, -start, start);
  return {(-half - towards) * per_step, (half - towards) * per_step};
}
LOCKSTEP_INLINE floatv inverse_length(floatv step) { return 1 / max(abs(step), floatv(1e-30f)); }

// All candidates: which slots are valid. There is at least one.
LOCKSTEP_INLINE void find_candidates(const Faces& faces, floatv separation, Candidate (&candidate)[slots], maskv (&valid)[slots]) {
  const Vector3<floatv>&middle = faces.middle, &p = faces.p, &q = faces.q;
  const floatv widening = face_widening * faces.size, half_x = faces.half_x + widening, half_y = faces.half_y + widening;
  maskv found = first_lanes(0);

  // Edge k leads from corner k to the next: along -p, -q, p and q.
  const floatv per_p_x = inverse_length(2 * p.x), per_p_y = inverse_length(2 * p.y);
  const floatv per_q_x = inverse_length(2 * q.x), per_q_y = inverse_length(2 * q.y);
#pragma GCC unroll 4
  for (int k = 0; k < 4; ++k) {
    const bool along_p = k % 2 == 0;
    const Real way = k < 2 ? -2 : 2;
    const Vector3<floatv> step = way * (along_p ? p : q);
    const Candidate start = corner(faces, sign_p[k], sign_q[k]);
    const Span x = span_within(start.x, step.x, along_p ? per_p_x : per_q_x, half_x);
    const Span y = span_within(start.y, step.y, along_p ? per_p_y : per_q_y, half_y);
    const floatv enter = max(max(x.near, y.near), floatv(0)), exit = min(min(x.far, y.far), floatv(1));
    const auto at = [&](floatv t) { return Candidate{start.x + t * step.x, start.y + t * step.y, start.separation + t * step.z}; };
    candidate[2 * k] = at(enter), candidate[2 * k + 1] = at(exit);
    valid[2 * k] = enter <= exit;
    valid[2 * k + 1] = (enter <= exit) & (exit < 1.f);
    found = found | valid[2 * k];
  }

  // A corner of the reference face is middle + s p + t q; within the incident face if |s|, |t| < 1, by a little more than
  // those are within that an edge above finds.
  const floatv area = p.x * q.y - p.y * q.x, per_area = 1 / area, inside = Real(.5) * widening;
  const floatv most_s = abs(area) - inside * max(abs(q.x), abs(q.y)), most_t = abs(area) - inside * max(abs(p.x), abs(p.y));
#pragma GCC unroll 4
  for (int k = 0; k < 4; ++k) {
    const floatv x = sign_p[k] * faces.half_x, y = sign_q[k] * faces.half_y;
    const floatv from_x = x - middle.x, from_y = y - middle.y;
    const floatv s = from_x * q.y - from_y * q.x, t = p.x * from_y - p.y * from_x;
    candidate[8 + k] = {x, y, middle.z + (s * p.z + t * q.z) * per_area};
    valid[8 + k] = (abs(s) < most_s) & (abs(t) < most_t);
    found = found | valid[8 + k];
  }

  // Boxes apart may be so diagonally: no part of one over the other. Then the deepest corner stands for them.
  candidate[12] = corner(faces, select(p.z < 0.f, floatv(1), -1.f), select(q.z < 0.f, floatv(1), -1.f));
  candidate[12].separation = separation;
  valid[12] = ~found;
}

// A candidate that is kept, and where it was; of none, behind the last slot.
struct Kept {
  Candidate candidate = {0.f, 0.f, 0.f};
  intv slot = slots;
};

LOCKSTEP_INLINE void keep(maskv better, Kept& kept, const Candidate& candidate, intv slot) {
  where(better, kept.candidate.x) = candidate.x, where(better, kept.candidate.y) = candidate.y;
  where(better, kept.candidate.separation) = candidate.separation, where(better, kept.slot) = slot;
}

LOCKSTEP_INLINE void put_in_order(Kept& a, Kept& b) {
  const maskv wrong = b.slot < a.slot;
  const Kept before = a;
  keep(wrong, a, b.candidate, b.slot);
  keep(wrong, b, before.candidate, before.slot);
}

// Of the candidates at most four: the deepest, then of those within margin the farthest from it, and the farthest from the line through
// both on either side. Of equals the one in the first slot; and no point that is nearer than same_point to the first, or to the line. In
// the order of their slots. The axis says that the boxes are within margin: if the deepest is not, by rounding, or as boxes that are apart
// may be so diagonally, it takes the axis's separation.
LOCKSTEP_INLINE void keep_four(const Candidate (&candidate)[slots], floatv size, floatv margin, floatv separation, maskv (&valid)[slots],
                               Kept (&kept)[most_points]) {
  const floatv preference = axis_preference * size, same = same_point * size;
  auto& [first, second, left, right] = kept;
  floatv least = infinity;
#pragma GCC unroll 13
  for (int k = 0; k < slots; ++k) {
    if (none(valid[k])) continue;
    const maskv better = valid[k] & (candidate[k].separation < least - preference);
    where(better, least) = candidate[k].separation;
    keep(better, first, candidate[k], k);
  }
#pragma GCC unroll 13
  for (int k = 0; k < slots; ++k) valid[k] = valid[k] & (candidate[k].separation <= margin);
  where(least > margin, first.candidate.separation) = separation;

  floatv most = same * same;
#pragma GCC unroll 13
  for (int k = 0; k < slots; ++k) {
    if (none(valid[k])) continue;
    const floatv x = candidate[k].x - first.candidate.x, y = candidate[k].y - first.candidate.y, distance_2 = x * x + y * y;
    const maskv better = valid[k] & (distance_2 > most);
    where(better, most) = distance_2;
    keep(better, second, candidate[k], k);
  }
  const maskv two = second.slot < slots;
  const floatv along_x = second.candidate.x - first.candidate.x, along_y = second.candidate.y - first.candidate.y;
  floatv most_left = same * sqrt(most), most_right = most_left;
#pragma GCC unroll 13
  for (int k = 0; k < slots; ++k) {
    if (none(valid[k])) continue;
    const floatv area = along_x * (candidate[k].y - first.candidate.y) - along_y * (candidate[k].x - first.candidate.x);
    const maskv better_left = two & valid[k] & (area > most_left), better_right = two & valid[k] & (-area > most_right);
    where(better_left, most_left) = area, where(better_right, most_right) = -area;
    keep(better_left, left, candidate[k], k);
    keep(better_right, right, candidate[k], k);
  }
  put_in_order(first, second), put_in_order(left, right), put_in_order(first, left), put_in_order(second, right);
  put_in_order(second, left);
}

// Sixteen pairs: which, their boxes, and the axis as far as it is known.
struct Block {
  Indices pair;
  maskv active;
  PairLanes collider;
  BoxPair<floatv> boxes;
  Axis axis;
};

// Pairs that wait for fifteen others that need the same. Their boxes are loaded anew: to bring those along took longer.
struct Queue {
  alignas(array_alignment) std::int32_t pair[2 * lanes] = {}, number[2 * lanes] = {};
  alignas(array_alignment) Real separation[2 * lanes] = {};
  int count = 0;
};

// What threads work with: the arguments of the kernel, and the queues of one thread.
struct Work {
  const Placed<Real>& placed;
  const std::span<const Pair> pairs;
  const Real margin;
  const std::span<Manifold<Real>> manifolds;
  Queue edge_tests, faces, edges;
};

LOCKSTEP_INLINE void load_boxes(const Work& work, Block& block) {
  const Pose<floatv> pose_a = load_pose(work.placed.pose, block.collider.a), pose_b = load_pose(work.placed.pose, block.collider.b);
  block.boxes = box_pair(pose_a.position, pose_a.orientation, load_quad(work.placed.colliders.size, block.collider.a),  //
                         pose_b.position, pose_b.orientation, load_quad(work.placed.colliders.size, block.collider.b));
}

// Up to sixteen pairs off a queue. Lanes beyond the last pair hold one of before, or the first pair there is.
LOCKSTEP_INLINE Block pop(const Work& work, Queue& queue) {
  const int first = std::max(queue.count - lanes, 0);
  Block block;
  block.active = first_lanes(queue.count - first);
  store(block.pair.index, load(queue.pair + first));
  block.axis = {load(queue.number + first), load(queue.separation + first)};
  for (int l = 0; l < lanes; ++l) {
    const Pair& pair = work.pairs[block.pair.index[l]];
    block.collider.a.index[l] = pair.a, block.collider.b.index[l] = pair.b;
  }
  load_boxes(work, block);
  queue.count = first;
  return block;
}

// The next stage, for the pairs of a block that need it: at once where all sixteen do, as in stacks, or else when the queue has sixteen.
template <class Stage>
LOCKSTEP_INLINE void go_on(Work& work, Queue& queue, const Block& block, maskv mask, Stage stage) {
  if (all(mask)) return stage(work, block);
  store(queue.pair + queue.count, compress(mask, load(block.pair.index)));
  store(queue.number + queue.count, compress(mask, block.axis.number));
  store(queue.separation + queue.count, compress(mask, block.axis.separation));
  queue.count += count(mask);
  if (queue.count >= lanes) stage(work, pop(work, queue));
}

void no_contacts(const Work& work, const Indices& pair, maskv mask) {
  for (std::uint32_t set = bits(mask); set != 0; set &= set - 1) work.manifolds[pair.index[std::countr_zero(set)]].count = 0;
}

// Points of two faces.
LOCKSTEP_INLINE void face_contact(const Block& block, const Pose<floatv>& pose, maskv on_b, intv axis, const Three<floatv>& normal,
                                  floatv margin, ManifoldLanes& manifold) {
  const Faces faces = see_faces(block.boxes, pose, on_b, axis, normal);
  Candidate candidate[slots];
  maskv valid[slots];
  find_candidates(faces, block.axis.separation, candidate, valid);
  Kept kept[most_points];
  keep_four(candidate, faces.size, margin, block.axis.separation, valid, kept);

  const auto in_world = [&](const Vector3<floatv>& v) { return v.x * faces.x + v.y * faces.y + v.z * faces.z; };
  const Vector3<floatv> out = in_world(faces.normal);
  manifold.normal = choose(on_b, -out, out);
  manifold.count = 0;
#pragma GCC unroll 4
  for (int k = 0; k < most_points; ++k) {
    const auto& [x, y, separation] = kept[k].candidate;
    const maskv valid = kept[k].slot < slots;
    const Vector3<floatv> position = faces.origin + (in_world({x, y, 0.f}) + Real(.5) * separation * out);
    manifold.count += select(valid, intv(1), 0);
    manifold.feature[k] = select(valid, faces.feature + kept[k].slot, 0);
    manifold.position[k] = choose(valid, position, {0.f, 0.f, 0.f});
    manifold.separation[k] = select(valid, separation, 0.f);
  }
}

// The point of two edges: midway between their closest points.
LOCKSTEP_INLINE void edge_contact(const Block& block, const Pose<floatv>& pose_a, intv i, intv j, const Three<floatv>& normal,
                                  const Three<floatv>& normal_b, ManifoldLanes& manifold) {
  const auto& [half_a, half_b, t, r] = block.boxes;
  // The edge of a that is foremost along the normal, and the edge of b that is hindmost: their middles.
  Three<floatv> on_a, on_b = t;
#pragma GCC unroll 3
  for (int k = 0; k < 3; ++k) on_a[k] = select(i == k, 0.f, select(normal[k] < 0.f, -half_a[k], half_a[k]));
#pragma GCC unroll 3
  for (int k = 0; k < 3; ++k) {
    const floatv along = select(j == k, 0.f, select(normal_b[k] < 0.f, half_b[k], -half_b[k]));
    on_b = {on_b[0] + along * r[0][k], on_b[1] + along * r[1][k], on_b[2] + along * r[2][k]};
  }
  // Seen along the normal they cross where b's has no distance from a's line: along that distance, and not along the edges, which may be
  // all but parallel, rounding moves them no farther apart than it moves points.
  const intv i1 = next(i), i2 = next(i1), j1 = next(j), j2 = next(j1);
  const Three<floatv> direction = {r[0][j], r[1][j], r[2][j]}, between = {on_b[0] - on_a[0], on_b[1] - on_a[1], on_b[2] - on_a[2]};
  const floatv across = between[i1] * normal[i2] - between[i2] * normal[i1],
               slope = direction[i1] * normal[i2] - direction[i2] * normal[i1];
  const auto within = [](floatv x, floatv half) { return min(max(x, -half), half); };
  const floatv along_edge_b = within(-across / slope, half_b[j]);
  const floatv along_edge_a = within(between[i] + along_edge_b * direction[i], half_a[i]);
#pragma GCC unroll 3
  for (int k = 0; k < 3; ++k) {
    on_b[k] = on_b[k] + along_edge_b * direction[k];
    on_a[k] = select(i == k, along_edge_a, on_a[k]);
  }

  const Matrix3<floatv> m = matrix_of(pose_a.orientation);
  const auto edge = [](intv axis, maskv next, maskv after) { return 4 * axis + select(next, intv(1), 0) + select(after, intv(2), 0); };
  const intv edge_a = edge(i, ~(normal[i1] < 0.f), ~(normal[i2] < 0.f));
  const intv edge_b = edge(j, normal_b[j1] < 0.f, normal_b[j2] < 0.f);
  const Vector3<floatv> twice = {on_a[0] + on_b[0], on_a[1] + on_b[1], on_a[2] + on_b[2]};
  manifold.normal = m * Vector3<floatv>{normal[0], normal[1], normal[2]};
  manifold.count = 1;
  manifold.position[0] = pose_a.position + m * (Real(.5) * twice), manifold.separation[0] = block.axis.separation;
  manifold.feature[0] = first_edge_feature + 12 * edge_a + edge_b;
}

// Sixteen pairs whose axis is a face's, or of edges of faces nearly flush.
void face_contacts(Work& work, const Block& block) {
  const auto& [number, separation] = block.axis;
  const maskv on_b = (number >= 3) & (number < 6), of_edges = number >= 6;
  intv face = select(on_b, number - 3, number);
  const floatv offset = select(on_b, -along_b(block.boxes, block.boxes.offset)[face], block.boxes.offset[face]);
  const floatv sign = select(offset < 0.f, floatv(-1), 1.f);
  Three<floatv> normal = {select(face == 0, sign, 0.f), select(face == 1, sign, 0.f), select(face == 2, sign, 0.f)};
  if (any(of_edges)) {
    const intv i = axis_a(number), j = number - 6 - 3 * i;
    const Three<floatv> across = edge_normal(block.boxes, i, j);
    normal = choose(of_edges, across, normal), face = select(of_edges, longest(across), face);
  }
  ManifoldLanes manifold;
  manifold.a = load(block.collider.a.index), manifold.b = load(block.collider.b.index);
  Indices reference;
  store(reference.index, select(on_b, manifold.b, manifold.a));
  face_contact(block, load_pose(work.placed.pose, reference), on_b, face, normal, work.margin, manifold);
  store_manifolds(work.manifolds, block.pair, manifold, block.active);
}

// Sixteen pairs whose axis is that of two edges.
void edge_contacts(Work& work, const Block& block) {
  const intv i = axis_a(block.axis.number), j = block.axis.number - 6 - 3 * i;
  const Three<floatv> normal = edge_normal(block.boxes, i, j), normal_b = along_b(block.boxes, normal);
  ManifoldLanes manifold;
  manifold.a = load(block.collider.a.index), manifold.b = load(block.collider.b.index);
  for (int k = 1; k < most_points; ++k) manifold.position[k] = {0.f, 0.f, 0.f}, manifold.separation[k] = 0.f, manifold.feature[k] = 0;
  edge_contact(block, load_pose(work.placed.pose, block.collider.a), i, j, normal, normal_b, manifold);
  store_manifolds(work.manifolds, block.pair, manifold, block.active);
}

// Sixteen pairs that no face separates.
void edge_tests(Work& work, const Block& untested) {
  Block block = untested;
  maskv active = block.active;
  block.axis = best_axis(block.boxes, work.margin, block.axis, active);
  no_contacts(work, block.pair, block.active & ~active);
  maskv points = active & (block.axis.number >= 6);
  if (any(points)) {
    const intv i = axis_a(block.axis.number), j = block.axis.number - 6 - 3 * i;
    const Three<floatv> normal = edge_normal(block.boxes, i, j), normal_b = along_b(block.boxes, normal);
    const intv face_a = longest(normal), face_b = longest(normal_b);
    points &= ~(min(abs(normal[face_a]), abs(normal_b[face_b])) >= flush_cosine);
  }
  go_on(work, work.faces, block, active & ~points, face_contacts);
  go_on(work, work.edges, block, points, edge_contacts);
}

// The next sixteen pairs, or fewer at the end.
void face_tests(Work& work, int first) {
  const int count = std::min(static_cast<int>(work.pairs.size()) - first, lanes);
  Block block;
  store(block.pair.index, lane_index() + first);
  block.active = first_lanes(count);
  block.collider = load_pairs(work.pairs.subspan(first, count));
  load_boxes(work, block);
  maskv active = block.active;
  block.axis = best_face(block.boxes, work.margin, active);
  no_contacts(work, block.pair, block.active & ~active);
  go_on(work, work.edge_tests, block, active, edge_tests);
}

}  // namespace

void box_box(const Placed<Real>& placed, std::span<const Pair> pairs, Real margin, std::span<Manifold<Real>> manifolds) {
  const int count = static_cast<int>(pairs.size());
#pragma omp parallel
  {
    Work work = {placed, pairs, margin, manifolds, {}, {}, {}};
    // Every pair is taken once, goes from queue to queue of the thread that took it, and has a manifold of its own.
#pragma omp for schedule(dynamic, 16) nowait
    for (int k = 0; k < count; k += lanes) face_tests(work, k);
    if (work.edge_tests.count > 0) edge_tests(work, pop(work, work.edge_tests));
    if (work.faces.count > 0) face_contacts(work, pop(work, work.faces));
    if (work.edges.count > 0) edge_contacts(work, pop(work, work.edges));
  }
}

}  // namespace lockstep::rigid::openmp
