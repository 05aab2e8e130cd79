// Sphere or capsule against sphere, capsule or box: a point or a segment against a point, a segment or a box, in closed form; then the
// radii.
//
// Two segments: the lines' closest points, each clamped to its segment after the other (Ericson, Real-Time Collision Detection (2005),
// 5.1.9). The cross product of the directions comes from their difference, so that it has all its digits when they are nearly parallel.
//
// Segment and box: along the segment, the square of the distance from the box is convex, a parabola between the points where a coordinate
// passes a side of the box. Of these six, the slope there says which are before the least and which after it; on the piece between them
// the box is a face, an edge or a corner, of which the closest point is a quotient.
//
// Cores that meet: the difference of a segment and a box is bounded by planes along the three axes of the box and across the segment and
// each of these; the nearest plane is the exact depth. For two segments it is the plane of both, at depth 0.
//
// Capsules that lie on a face, along an edge or along one another have two points, at both ends of the stretch over which they do, so
// that they do not spin; separations are along the one normal. All points of convex shapes are at least their distance apart along the
// normal at the closest two, so the deeper end has the exact depth, or the closest point stays alone.
//
// Works relative to collider a, or in the axes of the box. Threads take blocks of pairs; a block is sorted by form, and each form
// goes through its formula sixteen pairs at once. Rare cases are entered where any lane has one. The contract stands in
// common/rigid/narrow_phase.h.
#include <algorithm>

#include "common/real.h"
#include "common/rigid/narrow_phase.h"
#include "common/rigid/round.h"
#include "common/simd.h"
#include "openmp/rigid/bins.h"
#include "openmp/rigid/lanes.h"

namespace lockstep::rigid::openmp {
namespace {

// What the formulas are about: sixteen pairs.
using Number = floatv;
using Mask = maskv;
using Vector = Vector3<Number>;

// One point or two that share a normal, from the first shape to the second, relative to the first shape.
struct Contact {
  Vector normal;
  Vector position[2];
  Number separation[2];
  Mask two;
};

LOCKSTEP_INLINE Contact one_point(const Vector& normal, const Vector& position, Number separation) {
  return {normal, {position, {0, 0, 0}}, {separation, 0}, first_lanes(0)};
}

// Both ends, where `two`, instead of one point.
LOCKSTEP_INLINE void take(Mask two, const Contact& ends, Contact& contact) {
  for (int end = 0; end < 2; ++end) {
    contact.position[end] = select(two, ends.position[end], contact.position[end]);
    contact.separation[end] = select(two, ends.separation[end], contact.separation[end]);
  }
  contact.two = two;
}

LOCKSTEP_INLINE Contact points(const Vector& d, Number radius_a, Number radius_b) {
  const Number distance = sqrt(dot(d, d));
  const Vector up = {0, 1, 0};
  const Vector normal = select(distance > nothing, Number(1) / max(distance, Number(nothing)) * d, up);
  const Number separation = distance - (radius_a + radius_b);
  return one_point(normal, (radius_a + Number(.5) * separation) * normal, separation);
}

// Segments of half lengths `half_a` around the origin and `half_b` around d, along the unit vectors u and v.
LOCKSTEP_INLINE Contact segments(const Vector& d, const Vector& u, Number half_a, const Vector& along_b, Number half_b, Number radius_a,
                                 Number radius_b) {
  const Vector v = select(dot(u, along_b) < 0, -along_b, along_b);
  const Vector across = cross(u, v - u);
  const Number sine_2 = dot(across, across);
  const Number uv = dot(u, v), ud = dot(u, d), vd = dot(v, d);
  Number s = clamped(dot(cross(d, v), across) / max(sine_2, Number(nothing * nothing)), -half_a, half_a);
  Number t = clamped(uv * s - vd, -half_b, half_b);
  s = clamped(uv * t + ud, -half_a, half_a);

  // Where the closest point is no end, w is perpendicular to the segment; what rounding leaves along it would tilt the normal.
  Vector w = (d + t * v) - s * u;
  w = w - select(abs(t) < half_b, dot(w, v), Number(0)) * v;
  w = w - select(abs(s) < half_a, dot(w, u), Number(0)) * u;
  const Number radii = radius_a + radius_b, size = half_a + half_b + radii;
  const Number distance = sqrt(dot(w, w));
  Vector normal = Number(1) / max(distance, Number(nothing)) * w;
  if (const Mask meet = distance <= meeting * size; any(meet)) {
    Vector other = select(sine_2 > Number(1e-12), Number(1) / sqrt(max(sine_2, Number(nothing * nothing))) * across, perpendicular(u));
    other = select(dot(other, d) < 0, -other, other);
    normal = select(meet, other, normal);
  }

  // Both ends of the stretch of u beside which v lies. What their true distance has across the normal grows as the sine.
  const auto at = [&](Number s, Number t, Vector& position) {
    const Vector a = s * u, b = d + t * v;
    position = Number(.5) * ((a + b) + (radius_a - radius_b) * normal);
    return dot(normal, b - a) - radii;
  };
  Vector closest;
  const Number exact = at(s, t, closest);
  const Number low = max(-half_a, ud - uv * half_b), high = min(half_a, ud + uv * half_b);
  const Number stretch = high - low, limit = nearly * radii;
  const Mask beside = (stretch > limit) & (sine_2 * (stretch * stretch) <= limit * limit);
  Contact contact = one_point(normal, closest, exact);
  if (any(beside)) {
    Contact ends;
    ends.separation[0] = at(low, clamped(uv * low - vd, -half_b, half_b), ends.position[0]);
    ends.separation[1] = at(high, clamped(uv * high - vd, -half_b, half_b), ends.position[1]);
    take(beside & (abs(min(ends.separation[0], ends.separation[1]) - exact) <= meeting * size), ends, contact);
  }
  return contact;
}

// A box around the origin, along the axes, and a point. Within the box, out through the nearest face.
LOCKSTEP_INLINE Contact box_point(const Vector& half, const Vector& centre, Number radius) {
  const Vector w = excess(centre, half);
  const Number distance = sqrt(dot(w, w));
  Vector normal = Number(1) / max(distance, Number(nothing)) * w;
  if (const Mask inside = distance <= nothing; any(inside)) {
    const Number x = abs(centre.x) - half.x, y = abs(centre.y) - half.y, z = abs(centre.z) - half.z;
    const Number sx = select(centre.x < 0, Number(-1), Number(1)), sy = select(centre.y < 0, Number(-1), Number(1));
    const Number sz = select(centre.z < 0, Number(-1), Number(1));
    const Mask is_x = (x >= y) & (x >= z), is_y = y >= z;
    const Vector out = {select(is_x, sx, Number(0)), select(is_x, Number(0), select(is_y, sy, Number(0))),
                        select(is_x | is_y, Number(0), sz)};
    normal = select(inside, out, normal);
  }
  const Vector below = foot(centre, normal, half, Number(0));
  const Vector middle = Number(.5) * ((below + centre) - radius * normal);
  return one_point(normal, middle, dot(normal, centre - below) - radius);
}

// Where the segment goes through the box: the plane of least depth. Normal, and t of the point that comes out last.
LOCKSTEP_INLINE void least_depth(const Vector& half, const Vector& c, const Vector& u, Number half_length, Vector& normal, Number& t) {
  Number best = -1e30f;
  normal = {0.f, 0.f, 0.f}, t = 0.f;
  const auto face = [&](Number c_i, Number u_i, Number half_i, const Vector& axis) {
    const Number separation = abs(c_i) - (half_i + half_length * abs(u_i));
    const Mask better = separation > best;
    best = select(better, separation, best);
    normal = select(better, select(c_i < 0, -axis, axis), normal);
    t = select(better, select((u_i < 0) ^ (c_i < 0), half_length, -half_length), t);
  };
  const Number zero = 0, one = 1;
  face(c.x, u.x, half.x, {one, zero, zero});
  face(c.y, u.y, half.y, {zero, one, zero});
  face(c.z, u.z, half.z, {zero, zero, one});

  // `across` is an axis of the box times the segment, of the length `sine`; what remains is to turn it outwards.
  const auto edge = [&](const Vector& across) {
    const Number sine_2 = dot(across, across), per_sine = Number(1) / sqrt(max(sine_2, Number(nothing * nothing)));
    const Number distance = dot(c, across);
    const Vector out = select(distance < 0, -per_sine, per_sine) * across;
    const Vector size = {abs(out.x), abs(out.y), abs(out.z)};
    const Number separation = abs(distance) * per_sine - dot(half, size);
    const Vector corner = foot(c, out, half, zero);
    const Mask better = (sine_2 > Number(1e-12)) & (separation > best);
    // From the edge to the closest point: along u without its part along the edge.
    const Vector flat = {select(out.x == 0, zero, u.x), select(out.y == 0, zero, u.y), select(out.z == 0, zero, u.z)};
    best = select(better, separation, best);
    normal = select(better, out, normal);
    t = select(better, clamped(dot(flat, corner - c) / max(sine_2, Number(nothing * nothing)), -half_length, half_length), t);
  };
  edge({zero, -u.z, u.y});
  edge({u.z, zero, -u.x});
  edge({-u.y, u.x, zero});
}

// A box around the origin, along the axes, and a segment of half length around c, along the unit vector u.
LOCKSTEP_INLINE Contact box_segment(const Vector& half, const Vector& c, const Vector& u, Number half_length, Number radius) {
  const Vector per_u = {Number(1) / u.x, Number(1) / u.y, Number(1) / u.z};

  // The piece low .. high on which the distance is least. Where coordinate i passes a side, it adds nothing to the slope.
  Number low = -half_length, high = half_length;
  const auto cut = [&](Number t, Number c_j, Number u_j, Number half_j, Number c_k, Number u_k, Number half_k) {
    const Number slope = u_j * excess(c_j + t * u_j, half_j) + u_k * excess(c_k + t * u_k, half_k);
    const Mask inside = (t > -half_length) & (t < half_length);
    low = select(inside & (slope < 0), max(t, low), low);
    high = select(inside & (slope >= 0), min(t, high), high);
  };
  cut((-half.x - c.x) * per_u.x, c.y, u.y, half.y, c.z, u.z, half.z);
  cut((half.x - c.x) * per_u.x, c.y, u.y, half.y, c.z, u.z, half.z);
  cut((-half.y - c.y) * per_u.y, c.z, u.z, half.z, c.x, u.x, half.x);
  cut((half.y - c.y) * per_u.y, c.z, u.z, half.z, c.x, u.x, half.x);
  cut((-half.z - c.z) * per_u.z, c.x, u.x, half.x, c.y, u.y, half.y);
  cut((half.z - c.z) * per_u.z, c.x, u.x, half.x, c.y, u.y, half.y);

  // There, the coordinates outside are those outside in its middle.
  const Number middle = Number(.5) * (low + high);
  Number above = 0, below = 0;
  const auto add = [&](Number c_i, Number u_i, Number half_i) {
    const Number outside = excess(c_i + middle * u_i, half_i);
    above = above + select(outside == 0, Number(0), u_i * (select(outside > 0, half_i, -half_i) - c_i));
    below = below + select(outside == 0, Number(0), u_i * u_i);
  };
  add(c.x, u.x, half.x), add(c.y, u.y, half.y), add(c.z, u.z, half.z);
  Number t = clamped(select(below > 0, above / below, middle), low, high);

  const Vector w = excess(c + t * u, half);
  Number distance = sqrt(dot(w, w));
  const Number size = half.x + half.y + half.z + half_length + radius;
  Vector normal = Number(1) / max(distance, Number(nothing)) * w;
  if (const Mask meet = distance <= meeting * size; any(meet)) {
    Vector out;
    Number out_t;
    least_depth(half, c, u, half_length, out, out_t);
    normal = select(meet, out, normal);
    t = select(meet, out_t, t);
    distance = select(meet, Number(0), distance);
  }

  // The stretch above a face, where the normal leaves one side; or along an edge, where it leaves two, and to neither of them does the
  // segment go far.
  low = -half_length, high = half_length;
  Number off_2 = 0;
  const auto clip = [&](Number normal_i, Number c_i, Number u_i, Number per_u_i, Number half_i) {
    const Mask side = abs(normal_i) > nearly;
    const Number reach = half_i + (nearly * distance + meeting * size);  // as far as the closest point can be beyond
    const Number from = (-reach - c_i) * per_u_i, to = (reach - c_i) * per_u_i;
    low = select(side, low, max(min(from, to), low));
    high = select(side, high, min(max(from, to), high));
    off_2 = off_2 + select(side, u_i * u_i, Number(0));
    return side;
  };
  const Mask x = clip(normal.x, c.x, u.x, per_u.x, half.x), y = clip(normal.y, c.y, u.y, per_u.y, half.y);
  const Mask z = clip(normal.z, c.z, u.z, per_u.z, half.z);
  // Of segments through the box, the end that is deepest is within the stretch; of those that are parallel to a face, both are.
  t = select(distance == 0, clamped(t, low, high), t);

  const auto at = [&](Number t, Number tilt, Vector& position) {
    const Vector x = c + t * u, below = foot(x, normal, half, tilt);
    position = Number(.5) * ((below + x) - radius * normal);
    return dot(normal, x - below) - radius;
  };
  Vector closest;
  const Number exact = at(t, Number(meeting), closest);
  const Number off = select((x & y) | (x & z) | (y & z), off_2, Number(0)) * (Number(4) * half_length * half_length);
  const Number limit = nearly * radius;
  const Mask lies = (high - low > limit) & (off <= limit * limit);
  Contact contact = one_point(normal, closest, exact);
  if (any(lies)) {
    Contact ends;
    ends.separation[0] = at(low, Number(nearly), ends.position[0]);
    ends.separation[1] = at(high, Number(nearly), ends.position[1]);
    take(lies & (abs(min(ends.separation[0], ends.separation[1]) - exact) <= meeting * size), ends, contact);
  }
  return contact;
}

template <RoundForm form>
void collide(const Placed<Real>& placed, Bin& bin, Real margin, std::span<Manifold<Real>> manifolds) {
  const Colliders<Real>& colliders = placed.colliders;
  bin.fill_up();
  for (int k = 0; k < bin.count; k += lanes) {
    constexpr bool box = form == RoundForm::box_point || form == RoundForm::box_segment;
    const Indices &first = bin.first[k / lanes], &second = bin.second[k / lanes], &pair = bin.pair[k / lanes];
    const intv shape_a = load(first.index), shape_b = load(second.index);
    const maskv turned = shape_a > shape_b;
    // The orientation of a sphere has no effect, and is not loaded.
    const auto load_place = [&](bool is_sphere, const Indices& indices) -> Pose<floatv> {
      if (is_sphere) return {load_position(placed.pose, indices), {0.f, 0.f, 0.f, 1.f}, 0.f};
      return load_pose(placed.pose, indices);
    };
    const Pose<floatv> pose_a = load_place(form == RoundForm::points, first);
    const Pose<floatv> pose_b = load_place(form == RoundForm::points || form == RoundForm::box_point, second);
    const Quad<floatv> size_a = load_quad(colliders.size, first), size_b = load_quad(colliders.size, second);

    const Vector3<floatv> d = pose_b.position - pose_a.position;
    Contact contact;
    if constexpr (box) {
      const Matrix3<floatv> axes = matrix_of(pose_a.orientation);
      const Vector3<floatv> half = {size_a.x, size_a.y, size_a.z}, c = transposed_times(axes, d);
      if constexpr (form == RoundForm::box_point)
        contact = box_point(half, c, size_b.w);
      else
        contact = box_segment(half, c, transposed_times(axes, matrix_of(pose_b.orientation).y), size_b.y, size_b.w);
      contact.normal = axes * contact.normal;
      contact.position[0] = axes * contact.position[0], contact.position[1] = axes * contact.position[1];
    } else if constexpr (form == RoundForm::segments) {
      contact = segments(d, matrix_of(pose_a.orientation).y, size_a.y, matrix_of(pose_b.orientation).y, size_b.y, size_a.w, size_b.w);
    } else {
      contact = points(d, size_a.w, size_b.w);
    }

    ManifoldLanes manifold = {};
    manifold.normal = select(turned, -contact.normal, contact.normal);
    manifold.a = min(shape_a, shape_b), manifold.b = max(shape_a, shape_b);
    // The second point moves up where the first is not near.
    const maskv near = contact.separation[0] <= margin, other = contact.two & (contact.separation[1] <= margin), both = near & other;
    const auto put = [&](int k, maskv mask, maskv upper) {
      const Vector3<floatv> position = pose_a.position + select(upper, contact.position[1], contact.position[0]);
      const Vector3<floatv> zero = {0, 0, 0};
      manifold.position[k] = select(mask, position, zero);
      manifold.separation[k] = select(mask, select(upper, contact.separation[1], contact.separation[0]), floatv(0));
      manifold.feature[k] = select(mask, select(contact.two, select(upper, intv(upper_end), intv(lower_end)), intv(only_point)), intv(0));
    };
    put(0, near | other, ~near);
    put(1, both, both);
    manifold.count = select(both, intv(2), select(near | other, intv(1), intv(0)));
    store_short_manifolds<form == RoundForm::segments || form == RoundForm::box_segment ? 2 : 1>(manifolds, pair, manifold);
  }
}

}  // namespace

void spheres(const Placed<Real>& placed, std::span<const Pair> pairs, Real margin, std::span<Manifold<Real>> manifolds) {
  const int count = static_cast<int>(pairs.size());
  // A block writes the manifolds of its own pairs alone. Forms differ in work, hence dynamic.
#pragma omp parallel for schedule(dynamic)
  for (int begin = 0; begin < count; begin += block) {
    Bin bins[round_forms];
    sort_block(pairs, begin, std::min(begin + block, count), bins, [&](const Pair& pair) -> Place {
      const auto [a, b] = pair;
      const Kind kind_a = static_cast<Kind>(placed.colliders.kind[a]), kind_b = static_cast<Kind>(placed.colliders.kind[b]);
      const bool turned = kind_b == Kind::box;
      return {static_cast<int>(round_form(kind_a, kind_b)), turned ? b : a, turned ? a : b};
    });
    collide<RoundForm::points>(placed, bins[0], margin, manifolds);
    collide<RoundForm::segments>(placed, bins[1], margin, manifolds);
    collide<RoundForm::box_point>(placed, bins[2], margin, manifolds);
    collide<RoundForm::box_segment>(placed, bins[3], margin, manifolds);
  }
}

}  // namespace lockstep::rigid::openmp
