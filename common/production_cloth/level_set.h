// Closed meshes as solid bodies: the distance from the surface, on a grid that moves with the body.
//
// Between the grid's points the distance is interpolated along x, then y, then z. The way out of a point is as long as
// its distance, along the slope of the distance. Where the slope is not 1 the way is a little too long or too short,
// and the next round of collide_bodies measures again.
//
// Limits. Distances are known as deep as reach_of_level_set spacings. A point that is deeper has no slope, and so no
// way out. What is thinner than a spacing may be missed by the grid.
//
// Source: Bridson, Marino and Fedkiw 2003, section 5; [LRB08] and [ITJ07] have level sets for all that moves.
#pragma once

#include <memory>
#include <string>
#include <utility>

#include "common/cloth/push_out.h"
#include "common/levelset/field.h"
#include "common/levelset/grid.h"
#include "common/levelset/sample.h"
#include "common/mesh.h"
#include "common/rotation.h"
#include "common/toml.h"

namespace lockstep::production_cloth {

// In spacings: how far from the surface distances are exact; and how far from it, at least, the grid's sides are.
inline constexpr double reach_of_level_set = 8, room_of_level_set = 6;

// A mesh, where it is at time 0, and its distance (m, negative inside) at the points of a grid.
struct Solid {
  Mesh mesh;
  levelset::Grid grid;
  levelset::Field<float> distance;
};

// The inside is where the distance is less than `larger_by`, which is less than the room.
template <class Real>
struct LevelSet {
  std::shared_ptr<const Solid> solid;
  Vector3<Real> origin;  // m: where the grid's first point is
  Matrix3<Real> turn;    // columns: the directions of the grid's axes
  Real larger_by;        // m
};

// The body at time 0. Throws InputError, which `where` opens, where the mesh is not closed, or its grid is larger than
// may be or does not fit the memory.
LevelSet<double> make_level_set(const Mesh& mesh, double spacing, const std::string& where);

// Reads the keys file, scale, shift and spacing of a table of the scene's file.
LevelSet<double> read_level_set(const toml::table& table, const std::string& scene, double thickness);

// --- Formulas; of a number or of lanes

// The value at an index and the next; of sixteen indices, common/simd.h has the same.
inline std::pair<float, float> gather_pairs(const float* base, std::int32_t index) {
  return {base[index], base[index + 1]};
}

// A field between its points, and how it changes along the axes from one point to the next.
template <class V>
struct Sloped {
  V value;
  Vector3<V> slope;
};

// `at`, in spacings from the first point, is within the grid.
template <class V>
[[gnu::always_inline]] inline Sloped<V> sample_with_slope(const levelset::Field<float>& field, const Vector3<V>& at) {
  using Index = decltype(to_int(at.x));
  using levelset::between, levelset::interpolate;
  const auto x = between<Index>(at.x, field.nx), y = between<Index>(at.y, field.ny), z = between<Index>(at.z, field.nz);
  const Index corner = (z.first * Index(field.ny) + y.first) * Index(field.pitch) + x.first;
  V value[4], rise[4];  // of the four lines along x, by dy + 2 dz
  for (int line = 0; line < 4; ++line) {
    const auto pair = gather_pairs(&field.value[field.index(0, line % 2, line / 2)], corner);
    value[line] = interpolate(V(pair.first), V(pair.second), x.fraction);
    rise[line] = V(pair.second) - V(pair.first);
  }
  const V near = interpolate(value[0], value[1], y.fraction), far = interpolate(value[2], value[3], y.fraction);
  return {
      interpolate(near, far, z.fraction),
      {interpolate(interpolate(rise[0], rise[1], y.fraction), interpolate(rise[2], rise[3], y.fraction), z.fraction),
       interpolate(value[1] - value[0], value[3] - value[2], z.fraction), far - near}};
}

// The grid's sides are outside of the body, and so is what is beyond them.
template <class V, class Real>
[[gnu::always_inline]] inline cloth::WayOut<V> way_out(const LevelSet<Real>& body, const Vector3<V>& point) {
  using cloth::spread;
  const levelset::Field<float>& field = body.solid->distance;
  const Vector3<V> x = spread<V>(body.turn.x), y = spread<V>(body.turn.y), z = spread<V>(body.turn.z);
  const Vector3<V> from_first = point - spread<V>(body.origin);
  const V per_spacing = V(1 / Real(field.spacing));
  const Vector3<V> at = {per_spacing * dot(from_first, x), per_spacing * dot(from_first, y),
                         per_spacing * dot(from_first, z)};
  const auto within = [](const V& along, int points) {
    return (along > V(0)) & (along < V(static_cast<float>(points - 1)));
  };
  const auto inside = within(at.x, field.nx) & within(at.y, field.ny) & within(at.z, field.nz);
  if (none(inside)) return {V(-1), {V(0), V(0), V(0)}};
  const auto [distance, slope] = sample_with_slope(field, at);
  const V length = sqrt(dot(slope, slope));
  const auto slopes = length > V(0);
  const V per_length = select(slopes, V(1) / length, V(0));
  return {select(slopes, V(body.larger_by) - distance, V(-1)),
          (per_length * slope.x) * x + (per_length * slope.y) * y + (per_length * slope.z) * z};
}

}  // namespace lockstep::production_cloth
