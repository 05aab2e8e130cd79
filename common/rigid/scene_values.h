// Values in scenes of rigid bodies, and what bodies must keep to: for the readers in scene.cpp and
// scene_generators.cpp.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "common/rigid/make.h"
#include "common/rigid/world.h"
#include "common/scene_reader.h"

namespace lockstep::rigid {

// Bodies and colliders are counted in int32, and so are three vertices and six corners of each triangle.
inline constexpr double most_bodies = 1 << 26;
// m; with the masses below, all that is computed stays in the range of float.
inline constexpr double shortest = 1e-4, longest = 1e5;
inline constexpr double farthest = 1e6;  // m, m/s, rad/s

// What the scene says for all bodies.
struct Defaults {
  Surface surface;
  std::string path;                 // of the scene
  std::map<std::string, int> hull;  // by name
};

// m
std::optional<double> read_length(const toml::table& table, std::string_view key);
Vector3<double> read_box(const toml::table& table);  // half the sides

// kg
std::optional<double> read_mass(const toml::table& table);

// m, m/s or rad/s; zero where the key is absent.
Vector3<double> near_vector(const toml::table& table, std::string_view key, std::string_view unit);

Surface read_surface(const toml::table& table, const Surface& otherwise);

// A position and an orientation.
Pose<double> read_pose(const toml::table& table);

// Throws InputError where so many more bodies or triangles are too many, or do not fit the memory.
void require_room(const World<double>& world, double bodies, double triangles, const std::string& where);

// Throws InputError where float cannot hold the body's mass or inertia: sizes and masses may each be in range.
void require_floats(const World<double>& world, int body, const std::string& where);

// Makes the bodies of [[pyramid]], [[stack]] and all other generators.
void read_generators(const toml::table& scene, World<double>& world, const Defaults& defaults);

}  // namespace lockstep::rigid
