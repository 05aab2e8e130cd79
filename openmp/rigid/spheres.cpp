// Sphere or capsule against sphere, capsule or box, sixteen pairs at once. The formulas and how they work:
// common/rigid/round_contacts.h.
//
// Works relative to collider a, or in the axes of the box. Threads take blocks of pairs; a block is sorted by form, and
// sixteen pairs of one form go through its formula at once. The contract stands in common/rigid/narrow_phase.h.
#include <algorithm>

#include "common/real.h"
#include "common/rigid/narrow_phase.h"
#include "common/rigid/round_contacts.h"
#include "common/simd.h"
#include "openmp/rigid/bins.h"
#include "openmp/rigid/chunks.h"
#include "openmp/rigid/lanes.h"

namespace lockstep::rigid::openmp {
namespace {

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
    RoundContact<floatv> contact;
    if constexpr (box) {
      const Matrix3<floatv> axes = matrix_of(pose_a.orientation);
      const Vector3<floatv> half = {size_a.x, size_a.y, size_a.z}, c = transposed_times(axes, d);
      if constexpr (form == RoundForm::box_point)
        contact = contact_of_box_and_point(half, c, size_b.w);
      else
        contact = contact_of_box_and_segment(half, c, transposed_times(axes, matrix_of(pose_b.orientation).y), size_b.y,
                                             size_b.w);
      contact.normal = axes * contact.normal;
      contact.position[0] = axes * contact.position[0], contact.position[1] = axes * contact.position[1];
    } else if constexpr (form == RoundForm::segments) {
      contact = contact_of_segments(d, matrix_of(pose_a.orientation).y, size_a.y, matrix_of(pose_b.orientation).y,
                                    size_b.y, size_a.w, size_b.w);
    } else {
      contact = contact_of_points(d, size_a.w, size_b.w);
    }

    ManifoldLanes manifold = {};
    manifold.normal = select(turned, -contact.normal, contact.normal);
    manifold.a = min(shape_a, shape_b), manifold.b = max(shape_a, shape_b);
    // The second point moves up where the first is not near.
    const maskv near = contact.separation[0] <= margin, other = contact.two & (contact.separation[1] <= margin),
                both = near & other;
    const auto put = [&](int k, maskv mask, maskv upper) {
      const Vector3<floatv> position = pose_a.position + select(upper, contact.position[1], contact.position[0]);
      const Vector3<floatv> zero = {0, 0, 0};
      manifold.position[k] = select(mask, position, zero);
      manifold.separation[k] = select(mask, select(upper, contact.separation[1], contact.separation[0]), floatv(0));
      manifold.feature[k] =
          select(mask, select(contact.two, select(upper, intv(upper_end), intv(lower_end)), intv(only_point)), intv(0));
    };
    put(0, near | other, ~near);
    put(1, both, both);
    manifold.count = select(both, intv(2), select(near | other, intv(1), intv(0)));
    store_short_manifolds<form == RoundForm::segments || form == RoundForm::box_segment ? 2 : 1>(manifolds, pair,
                                                                                                 manifold);
  }
}

}  // namespace

void spheres(const Placed<Real>& placed, std::span<const Pair> pairs, Real margin,
             std::span<Manifold<Real>> manifolds) {
  const int count = static_cast<int>(pairs.size()), size = chunk_of(pairs.size(), block);
  // A block writes the manifolds of its own pairs alone. Forms differ in work, hence dynamic.
#pragma omp parallel for schedule(dynamic)
  for (int begin = 0; begin < count; begin += size) {
    Bin bins[round_forms];
    sort_block(pairs, begin, std::min(begin + size, count), bins, [&](const Pair& pair) -> Place {
      const auto [a, b] = pair;
      const Kind kind_a = static_cast<Kind>(placed.colliders.kind[a]),
                 kind_b = static_cast<Kind>(placed.colliders.kind[b]);
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
