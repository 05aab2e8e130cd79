// The arrays of the rigid bodies' states and the fields of their records, listed once (common/arrays.h). Kernels do not
// need the lists, so they stand in a header of their own. An array added to a state must be added here.
#pragma once

#include "common/arrays.h"
#include "common/rigid/step.h"

namespace lockstep::spatial {

template <Same<Pair> P, class F>
void for_each_field(P& pair, const F& f) {
  f("a", pair.a), f("b", pair.b);
}

}  // namespace lockstep::spatial

namespace lockstep::rigid {

// --- Records

template <Is<Quad> Q, class F>
void for_each_field(Q& q, const F& f) {
  f("x", q.x), f("y", q.y), f("z", q.z), f("w", q.w);
}

template <Is<Pose> P, class F>
void for_each_field(P& pose, const F& f) {
  auto& [x, q, unused] = pose;
  f("position.x", x.x), f("position.y", x.y), f("position.z", x.z);
  f("orientation.x", q.x), f("orientation.y", q.y), f("orientation.z", q.z), f("orientation.w", q.w);
}

template <Is<Motion> M, class F>
void for_each_field(M& motion, const F& f) {
  auto& [v, w, unused] = motion;
  f("velocity.x", v.x), f("velocity.y", v.y), f("velocity.z", v.z);
  f("angular_velocity.x", w.x), f("angular_velocity.y", w.y), f("angular_velocity.z", w.z);
}

// Of a Manifold or a KeptContact; points beyond the count are left out.
template <class Contact, class F>
void for_each_field_of_points(Contact& contact, const F& f) {
  static constexpr const char* names[most_points][5] = {
      {"point[0].position.x", "point[0].position.y", "point[0].position.z", "point[0].separation", "feature[0]"},
      {"point[1].position.x", "point[1].position.y", "point[1].position.z", "point[1].separation", "feature[1]"},
      {"point[2].position.x", "point[2].position.y", "point[2].position.z", "point[2].separation", "feature[2]"},
      {"point[3].position.x", "point[3].position.y", "point[3].position.z", "point[3].separation", "feature[3]"}};
  auto& normal = contact.normal;
  f("normal.x", normal.x), f("normal.y", normal.y), f("normal.z", normal.z);
  for (int k = 0; k < contact.count && k < most_points; ++k) {
    auto& [position, separation] = contact.point[k];
    f(names[k][0], position.x), f(names[k][1], position.y), f(names[k][2], position.z), f(names[k][3], separation);
    f(names[k][4], contact.feature[k]);
  }
}

// A manifold without points has only its count.
template <Is<Manifold> M, class F>
void for_each_field(M& m, const F& f) {
  f("count", m.count);
  if (m.count <= 0) return;
  f("a", m.a), f("b", m.b);
  for_each_field_of_points(m, f);
}

template <Is<KeptContact> K, class F>
void for_each_field(K& kept, const F& f) {
  for_each_field(kept.b_in_a, f);
  f("count", kept.count), f("reach_a", kept.reach_a), f("reach_b", kept.reach_b);
  if (kept.count > 0) for_each_field_of_points(kept, f);
}

template <Is<Impulses> I, class F>
void for_each_field(I& i, const F& f) {
  static constexpr const char* names[3][most_points] = {
      {"normal[0]", "normal[1]", "normal[2]", "normal[3]"},
      {"tangent[0]", "tangent[1]", "tangent[2]", "tangent[3]"},
      {"bitangent[0]", "bitangent[1]", "bitangent[2]", "bitangent[3]"}};
  for (int k = 0; k < most_points; ++k)
    f(names[0][k], i.normal[k]), f(names[1][k], i.tangent[k]), f(names[2][k], i.bitangent[k]);
}

// Corners beyond the count are left out.
template <Same<Simplex> S, class F>
void for_each_field(S& simplex, const F& f) {
  static constexpr const char* names[2][4] = {{"a[0]", "a[1]", "a[2]", "a[3]"}, {"b[0]", "b[1]", "b[2]", "b[3]"}};
  f("count", simplex.count);
  for (int k = 0; k < simplex.count && k < 4; ++k) f(names[0][k], simplex.a[k]), f(names[1][k], simplex.b[k]);
}

template <Is<Closest> C, class F>
void for_each_field(C& c, const F& f) {
  f("on_a.x", c.on_a.x), f("on_a.y", c.on_a.y), f("on_a.z", c.on_a.z);
  f("on_b.x", c.on_b.x), f("on_b.y", c.on_b.y), f("on_b.z", c.on_b.z);
  f("distance", c.distance), f("iterations", c.iterations);
}

// --- States

template <Is<Bodies> B, class F>
void for_each_array(B& b, const F& f) {
  f("pose", b.pose, b.count), f("motion", b.motion, b.count), f("inverse_mass", b.inverse_mass, b.count);
  f("friction", b.friction, b.count), f("restitution", b.restitution, b.count);
}

template <Is<Colliders> C, class F>
void for_each_array(C& c, const F& f) {
  f("kind", c.kind, c.count), f("body", c.body, c.count), f("group", c.group, c.count);
  f("local", c.local, c.count), f("hull", c.hull, c.count), f("size", c.size, c.count);
}

// A target of convert_arrays has no arrays yet.
template <Is<Hulls> H, class F>
void for_each_array(H& h, const F& f) {
  const bool made = !h.first_vertex.empty();
  const int vertices = made ? h.first_vertex[h.count] : 0, faces = made ? h.first_face[h.count] : 0;
  const int corners = made ? h.first_corner[faces] : 0, hull_ends = made ? h.count + 1 : 0;
  f("vertex", h.vertex, vertices), f("plane", h.plane, faces), f("corner", h.corner, corners);
  f("first_vertex", h.first_vertex, hull_ends), f("first_face", h.first_face, hull_ends);
  f("first_corner", h.first_corner, made ? faces + 1 : 0), f("centre", h.centre, h.count), f("half", h.half, h.count);
}

template <Is<World> W, class F>
void for_each_array(W& world, const F& f) {
  for_each_array(world.bodies, f), for_each_array(world.colliders, f), for_each_array(world.hulls, f);
}

template <Same<ContactBlocks> B, class F>
void for_each_array(B& b, const F& f) {
  f("order", b.order, b.order.size()), f("groups", b.groups, b.groups.size());
  f("blocks", b.blocks, b.blocks.size()), f("rounds", b.rounds, b.rounds.size());
}

template <Is<StepMemory> M, class F>
void for_each_array(M& m, const F& f) {
  f("placed", m.placed, m.bounds.count), f("bounds.low", m.bounds.low, m.bounds.count);
  f("bounds.high", m.bounds.high, m.bounds.count);
  const auto nodes = m.tree.first.empty() ? 0 : m.tree.first.back();
  f("tree.order", m.tree.order, m.tree.order.size()), f("tree.first", m.tree.first, m.tree.first.size());
  f("tree.boxes.low", m.tree.boxes.low, nodes), f("tree.boxes.high", m.tree.boxes.high, nodes);
  f("bounded", m.bounded, m.bounded.size()), f("with_planes", m.with_planes, m.with_planes.size());
  f("pairs", m.pairs, m.pairs.size()), f("narrow_phase.pairs", m.narrow_phase.pairs, m.narrow_phase.pairs.size());
  f("narrow_phase.simplex", m.narrow_phase.simplex, m.narrow_phase.simplex.size());
  f("kept.pairs", m.kept.pairs, m.kept.pairs.size()), f("kept.contact", m.kept.contact, m.kept.contact.size());
  f("manifolds", m.manifolds, m.manifolds.size()), f("last_manifolds", m.last_manifolds, m.last_manifolds.size());
  f("impulses", m.impulses, m.impulses.size()), f("last_impulses", m.last_impulses, m.last_impulses.size());
  f("batches.order", m.batches.order, m.batches.order.size());
  f("batches.begin", m.batches.begin, m.batches.begin.size());
  for_each_array(m.blocks, f);
  f("moving", m.moving, m.moving.size());
}

}  // namespace lockstep::rigid
