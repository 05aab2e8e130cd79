// Where a cloth passes through itself: exact, in sequence.
//
// An edge and a triangle without a common vertex must have no point in common. In a motion, that changes only where a
// point meets a triangle, or an edge an edge. So a cloth of which it is true at the start and after every step, with no
// impact missed in between, has not passed through itself. Two triangles that intersect, and have no edge in common,
// always have such an edge and triangle.
//
// Touching counts: from where two sheets touch, nobody can say on which side of each other they are. Nothing is
// rounded, so sheets apart by the least float do not touch. Edges and triangles in one plane are decided exactly as
// well. A triangle without an area, whose corners are on a line, has no plane: it is said to meet every edge whose box
// overlaps its own.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "common/production_cloth/topology.h"

namespace lockstep::production_cloth {

// Whether the edge from p to q and the triangle have a point in common.
bool edge_meets_triangle(const Vector3<float>& p, const Vector3<float>& q,
                         const std::array<Vector3<float>, 3>& triangle);

// How many pairs of an edge and a triangle, without a common vertex, have a point in common. Positions, m, are finite.
std::size_t count_intersections(const Topology& topology, const Vectors<float>& position);

// Two triangles that intersect: the first that has the least such edge, and the least triangle that this edge meets.
std::optional<std::array<std::int32_t, 2>> first_intersection(const Topology& topology, const Vectors<float>& position);

}  // namespace lockstep::production_cloth
