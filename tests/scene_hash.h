// What a scene of any domain says, as one number.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <variant>

#include "common/cloth/scene.h"
#include "common/fluid/scene.h"
#include "common/levelset/scene.h"
#include "common/linear/scene.h"
#include "common/production_cloth/scene.h"
#include "common/production_face/scene.h"
#include "common/production_fluid/scene.h"
#include "common/rigid/arrays.h"
#include "common/rigid/scene.h"
#include "verify/arrays.h"

namespace lockstep {

template <class... Values>
std::uint64_t hash_all(const Values&... values) {
  std::uint64_t hash = 0;
  ((hash = verify::hash_bytes(std::span(&values, 1), hash)), ...);
  return hash;
}

// All that a scene says, as a number.
inline std::uint64_t hash_of_scene(const std::string& domain, const std::string& path) {
  using verify::hash_of;
  if (domain == "fluid") {
    const fluid::Scene s = fluid::load_scene(path);
    const fluid::Model<float> m = fluid::convert<float>(s.model);
    return hash_all(m.twice_rest_density, m.least_density, m.density_coefficient, m.pressure_coefficient,
                    m.viscosity_coefficient, m.time_step, m.gravity, m.walls, hash_of(s.particles), s.frames,
                    s.holds.momentum_conserved, s.holds.inside_domain, s.holds.lattice_density,
                    s.holds.energy_falls_after.value_or(-1));
  }
  if (domain == "cloth") {
    const cloth::Scene s = cloth::load_scene(path);
    const auto& m = s.cloth.model;
    const auto& b = s.cloth.bodies;
    std::uint64_t hash = hash_all(m.time_step, m.substeps, m.iterations, m.gravity, m.wind, m.drag, m.velocity_factor,
                                  hash_of(s.cloth), s.cloth.constraints.count, b.friction, s.frames);
    for (const auto& plane : b.planes) hash += hash_all(plane.normal, plane.offset);
    for (const auto& capsule : b.capsules) hash += hash_all(capsule.from, capsule.to, capsule.radius);
    for (const auto& box : b.boxes) hash += hash_all(box.centre, box.half, box.axis);
    for (const double inverse_mass : s.cloth.inverse_mass) hash = hash_all(hash, inverse_mass);
    for (const auto& other : s.others) hash = hash_all(hash, hash_of(other), other.constraints.count);
    return hash;
  }
  if (domain == "levelset") {
    const levelset::Scene s = levelset::load_scene(path);
    return hash_all(s.grid.nx, s.grid.spacing, s.grid.origin, s.band, s.rounds,
                    verify::hash_bytes(std::span<const float>(s.phi.value)));
  }
  if (domain == "rigid") {
    const rigid::Scene s = rigid::load_scene(path);
    return hash_all(s.time_step, s.gravity, s.iterations, s.frames, s.rest, s.settle, hash_of(s.world));
  }
  if (domain == "production_fluid") {
    const production_fluid::Scene s = production_fluid::load_scene(path);
    const production_fluid::Model& m = s.model;
    std::uint64_t hash =
        hash_all(s.fluid.nx, s.fluid.ny, s.fluid.nz, s.fluid.spacing, s.fluid.open_top, hash_of(s.fluid), m.gravity,
                 m.frame, m.per_block, m.given, m.period, s.frames, s.volume_bound);
    for (const auto& source : m.sources) hash += hash_all(source.centre, source.radius, source.velocity, source.until);
    return hash;
  }
  if (domain == "production_face") {
    const production_face::Scene s = production_face::load_scene(path);
    std::uint64_t hash = hash_all(s.flesh.m10, s.flesh.m01, s.flesh.kappa, s.frames, s.tolerance, s.motion.repeats);
    for (const auto& bone : s.motion.bones) hash = hash_all(hash, bone.pivot);
    for (const auto& key : s.motion.keys) {
      hash = hash_all(hash, key.time);
      for (const auto& bone : key.bones) hash = hash_all(hash, bone.turn, bone.shift);
      for (const float activation : key.activation) hash = hash_all(hash, activation);
    }
    for (const Array<float>* values : {&s.body.rest.x, &s.body.rest.y, &s.body.rest.z, &s.body.fibre.value,
                                       &s.pose.displacement.x, &s.pose.activation})
      hash = verify::hash_bytes(std::span<const float>(*values), hash);
    return hash;
  }
  if (domain == "production_cloth") {
    const production_cloth::Scene s = production_cloth::load_scene(path);
    const production_cloth::Material& m = s.material;
    std::uint64_t hash =
        hash_all(m.density, m.stretch, m.stiffness, m.membrane, m.poisson, m.stretch_damping, m.bend, m.bending,
                 m.bend_damping, s.contact.thickness, s.contact.stiffness, s.contact.friction, s.contact.zones,
                 s.gravity, s.frame_time, s.substeps, s.tolerance, s.iterations, s.frames, s.topology.edges.size());
    const auto add_path = [&](const production_cloth::Path& path) {
      hash = hash_all(hash, path.pivot);
      for (const auto& key : path.keys) hash = hash_all(hash, key.time, key.placement.turn, key.placement.shift);
    };
    for (const auto& hold : s.holds) {
      hash = verify::hash_bytes(std::span<const std::int32_t>(hold.vertices), hash);
      add_path(hold.path);
    }
    for (const auto& body : s.bodies) {
      if (const auto* solid = std::get_if<production_cloth::LevelSet<double>>(&body.shape))
        hash = verify::hash_bytes(std::span<const float>(solid->solid->distance.value), hash_all(hash, solid->origin));
      else
        std::visit([&](const auto& shape) { hash = hash_all(hash, shape); }, body.shape);
      hash = hash_all(hash, body.friction);
      add_path(body.path);
    }
    for (const Array<double>* values : {&s.rest.x, &s.rest.y, &s.rest.z})
      hash = verify::hash_bytes(std::span<const double>(*values), hash);
    return hash;
  }
  const linear::Scene s = linear::load_scene(path);
  return hash_all(s.stop.tolerance, s.stop.iterations, s.modification.tau,
                  verify::hash_bytes(std::span<const float>(s.rows.value)));
}

}  // namespace lockstep
