// Box against box: separating axes, then contact points, of sixteen pairs at once.
//
// The axes and the points are those of serial/rigid/box_box.cpp. Early outs are masks ([LRB08] Figure 10c): a lane
// whose pair is apart idles until all are apart.
//
// What a pair needs next depends on its axis: nothing, the contact of two faces, or that of two edges. So a block's
// pairs go on to queues, and whenever one has sixteen, they go through that stage together: lanes are full again
// however many pairs were apart.
//
// Source: [LRB08] "Collision Detection", Figure 10; the rest as in serial/rigid/box_box.cpp. The contract stands in
//         common/rigid/narrow_phase.h, formulas in common/rigid/box_axes.h and box_faces.h, bounds in
//         common/rigid/box_pair.h.
#include <algorithm>
#include <bit>

#include "common/real.h"
#include "common/rigid/box_axes.h"
#include "common/rigid/box_faces.h"
#include "common/rigid/narrow_phase.h"
#include "common/simd.h"
#include "openmp/rigid/chunks.h"
#include "openmp/rigid/lanes.h"

namespace lockstep::rigid::openmp {
namespace {

// Sixteen pairs: which, their boxes, and the axis as far as it is known.
struct Block {
  Indices pair;
  maskv active;
  PairLanes collider;
  BoxPair<floatv> boxes;
  BoxAxis<floatv> axis;
};

// Pairs that wait until sixteen need the same stage. Their boxes are loaded again: queueing them too took longer.
struct Queue {
  alignas(array_alignment) std::int32_t pair[2 * lanes] = {}, number[2 * lanes] = {};
  alignas(array_alignment) Real separation[2 * lanes] = {};
  int count = 0;
};

// The arguments of the kernel, and the queues of one thread.
struct Work {
  const Placed<Real>& placed;
  const std::span<const Pair> pairs;
  const Real margin;
  const std::span<Manifold<Real>> manifolds;
  Queue edge_tests, faces, edges;
};

LOCKSTEP_INLINE void load_boxes(const Work& work, Block& block) {
  const Pose<floatv> pose_a = load_pose(work.placed.pose, block.collider.a),
                     pose_b = load_pose(work.placed.pose, block.collider.b);
  block.boxes =
      box_pair(pose_a.position, pose_a.orientation, load_quad(work.placed.colliders.size, block.collider.a),  //
               pose_b.position, pose_b.orientation, load_quad(work.placed.colliders.size, block.collider.b));
}

// Up to sixteen pairs off a queue. Lanes beyond the last pair hold one of before, or the first pair there is.
LOCKSTEP_INLINE Block pop(const Work& work, Queue& queue) {
  const int first = std::max(queue.count - lanes, 0);
  Block block;
  block.active = first_lanes(queue.count - first);
  store(block.pair.index, load(queue.pair + first));
  block.axis = {load(queue.number + first), load(queue.separation + first)};
  block.collider = load_pairs(work.pairs, block.pair);
  load_boxes(work, block);
  queue.count = first;
  return block;
}

// Runs a stage on up to sixteen pairs off its queue.
template <class Stage>
LOCKSTEP_INLINE void run_stage(Work& work, Queue& queue, Stage stage) {
  Block block = pop(work, queue);
  stage(work, block);
}

// The next stage, for the pairs of a block that need it: at once where all sixteen do, as in stacks, or else when the
// queue has sixteen.
template <class Stage>
LOCKSTEP_INLINE void go_on(Work& work, Queue& queue, Block& block, maskv mask, Stage stage) {
  if (all(mask)) return stage(work, block);
  store(queue.pair + queue.count, compress(mask, load(block.pair.index)));
  store(queue.number + queue.count, compress(mask, block.axis.number));
  store(queue.separation + queue.count, compress(mask, block.axis.separation));
  queue.count += count(mask);
  if (queue.count >= lanes) run_stage(work, queue, stage);
}

void no_contacts(const Work& work, const Indices& pair, maskv mask) {
  for (std::uint32_t set = bits(mask); set != 0; set &= set - 1)
    work.manifolds[pair.index[std::countr_zero(set)]].count = 0;
}

// Points of two faces.
LOCKSTEP_INLINE void face_contact(const Block& block, const Pose<floatv>& pose, const ReferenceFace<floatv>& face,
                                  floatv margin, ManifoldLanes& manifold) {
  const auto& [on_b, axis, normal] = face;
  const BoxFaces<floatv> faces = see_faces(block.boxes, pose, on_b, axis, normal);
  BoxPoint<floatv> point[most_points];
  find_points(faces, block.axis.separation, margin, point);
  const Vector3<floatv> out = in_world(faces, faces.normal);
  manifold.normal = select(on_b, -out, out);
  manifold.count = 0;
#pragma GCC unroll 4
  for (int k = 0; k < most_points; ++k) {
    const auto& [x, y, separation, slot] = point[k];
    const maskv valid = slot < slots;
    const Vector3<floatv> position = faces.origin + (in_world(faces, {x, y, 0.f}) + Real(.5) * separation * out);
    manifold.count += select(valid, intv(1), 0);
    manifold.feature[k] = select(valid, faces.feature + slot, 0);
    manifold.position[k] = select(valid, position, {0.f, 0.f, 0.f});
    manifold.separation[k] = select(valid, separation, 0.f);
  }
}

// The point of two edges.
LOCKSTEP_INLINE void edge_contact(const Block& block, const Pose<floatv>& pose_a, intv i, intv j,
                                  const Three<floatv>& normal, const Three<floatv>& normal_b, ManifoldLanes& manifold) {
  const EdgePoint<floatv> point = edge_point(block.boxes, pose_a, i, j, normal, normal_b);
  manifold.normal = point.normal;
  manifold.count = 1;
  manifold.position[0] = point.position, manifold.separation[0] = block.axis.separation;
  manifold.feature[0] = point.feature;
}

// Sixteen pairs whose axis is a face's, or of edges of which one has a face beside it that is nearly flush.
void face_contacts(Work& work, const Block& block) {
  const auto& [number, separation] = block.axis;
  ReferenceFace<floatv> face = winning_face(block.boxes, number);
  const maskv of_edges = number >= 6;
  if (any(of_edges)) {
    const intv i = axis_a(number), j = number - 6 - 3 * i;
    const Three<floatv> normal = edge_normal(block.boxes, i, j), normal_b = along_b(block.boxes, normal);
    maskv flush;
    const ReferenceFace<floatv> beside = flush_face(normal, normal_b, flush);
    face.normal = select(of_edges, beside.normal, face.normal), face.axis = select(of_edges, beside.axis, face.axis);
    face.on_b |= of_edges & beside.on_b;
  }
  ManifoldLanes manifold;
  manifold.a = load(block.collider.a.index), manifold.b = load(block.collider.b.index);
  const Indices reference = indices_of(select(face.on_b, manifold.b, manifold.a));
  face_contact(block, load_pose(work.placed.pose, reference), face, work.margin, manifold);
  store_manifolds(work.manifolds, block.pair, manifold, block.active);
}

// Sixteen pairs whose axis is that of two edges.
void edge_contacts(Work& work, const Block& block) {
  const intv i = axis_a(block.axis.number), j = block.axis.number - 6 - 3 * i;
  const Three<floatv> normal = edge_normal(block.boxes, i, j), normal_b = along_b(block.boxes, normal);
  ManifoldLanes manifold;
  manifold.a = load(block.collider.a.index), manifold.b = load(block.collider.b.index);
  for (int k = 1; k < most_points; ++k)
    manifold.position[k] = {0.f, 0.f, 0.f}, manifold.separation[k] = 0.f, manifold.feature[k] = 0;
  edge_contact(block, load_pose(work.placed.pose, block.collider.a), i, j, normal, normal_b, manifold);
  store_manifolds(work.manifolds, block.pair, manifold, block.active);
}

// Sixteen pairs that no face separates.
void edge_tests(Work& work, Block& block) {
  maskv active = block.active;
  block.axis = best_axis<floatv>(block.boxes, work.margin, block.axis, active);
  no_contacts(work, block.pair, block.active & ~active);
  maskv points = active & (block.axis.number >= 6);
  if (any(points)) {
    const intv i = axis_a(block.axis.number), j = block.axis.number - 6 - 3 * i;
    const Three<floatv> normal = edge_normal(block.boxes, i, j), normal_b = along_b(block.boxes, normal);
    maskv flush;
    flush_face(normal, normal_b, flush);
    points &= ~flush;
  }
  go_on(work, work.faces, block, active & ~points, face_contacts);
  go_on(work, work.edges, block, points, edge_contacts);
}

// The next sixteen pairs, or fewer at the end.
void face_tests(Work& work, int first) {
  const int count = std::min(static_cast<int>(work.pairs.size()) - first, lanes);
  Block block;
  block.pair = sixteen(first);
  block.active = first_lanes(count);
  block.collider = load_pairs(work.pairs.subspan(first, count));
  load_boxes(work, block);
  maskv active = block.active;
  block.axis = best_face<floatv>(block.boxes, work.margin, active);
  no_contacts(work, block.pair, block.active & ~active);
  go_on(work, work.edge_tests, block, active, edge_tests);
}

}  // namespace

void box_box(const Placed<Real>& placed, std::span<const Pair> pairs, Real margin,
             std::span<Manifold<Real>> manifolds) {
  constexpr int most_at_once = 256;
  const int count = static_cast<int>(pairs.size()), vectors = chunk_of(pairs.size(), most_at_once) / lanes;
#pragma omp parallel
  {
    Work work = {placed, pairs, margin, manifolds, {}, {}, {}};
    // Every pair is taken once, goes from queue to queue of the thread that took it, and has a manifold of its own.
#pragma omp for schedule(dynamic, vectors) nowait
    for (int k = 0; k < count; k += lanes) face_tests(work, k);
    if (work.edge_tests.count > 0) run_stage(work, work.edge_tests, edge_tests);
    if (work.faces.count > 0) run_stage(work, work.faces, face_contacts);
    if (work.edges.count > 0) run_stage(work, work.edges, edge_contacts);
  }
}

}  // namespace lockstep::rigid::openmp
