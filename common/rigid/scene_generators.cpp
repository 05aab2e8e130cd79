#include <cstdint>
#include <limits>
#include <map>

#include "common/rigid/generators.h"
#include "common/rigid/scene_values.h"

namespace lockstep::rigid {
namespace {

// Counts of bodies that are made one by one; more are refused in require_room.
constexpr int most_whole = 1 << 26;

int count_of(const toml::table& table, std::string_view key) { return *whole_int(table, key, 1, most_whole); }

Assortment read_assortment(const toml::table& table) {
  const std::map<std::string, Assortment> named = {{"boxes", Assortment::boxes},
                                                   {"rounds", Assortment::rounds},
                                                   {"hulls", Assortment::hulls},
                                                   {"mixed", Assortment::mixed}};
  const auto found = named.find(table.get("of")->value_exact<std::string>().value_or(""));
  if (found == named.end()) refuse_value(*table.get("of"), "of", "\"boxes\", \"rounds\", \"hulls\" or \"mixed\"");
  return found->second;
}

std::uint64_t read_seed(const toml::table& table) {
  return static_cast<std::uint64_t>(whole(table, "seed", 0, std::numeric_limits<std::int64_t>::max()).value_or(1));
}

}  // namespace

void read_generators(const toml::table& scene, World<double>& world, const Defaults& defaults) {
  const auto kit_of = [&](const toml::table& table, double bodies, double triangles = 0) {
    require_room(world, bodies, triangles, position(table.source()));
    return Kit{near_vector(table, "position", "m"), read_mass(table).value_or(1), defaults.surface};
  };
  // Each of one key; its bodies are made by action(table).
  const auto each = [&](std::string_view key, auto action) {
    for (const toml::table* table : subtables(scene, key)) {
      const int first = world.bodies.count;
      action(*table);
      for (int body = first; body < world.bodies.count; ++body) require_floats(world, body, position(table->source()));
    }
  };
  each("pyramid", [&](const toml::table& table) {
    check_keys(table, {"layers"}, {"position", "mass"});
    const int layers = count_of(table, "layers");
    add_pyramid(world, kit_of(table, pyramid_bodies(layers)), layers);
  });
  each("stack", [&](const toml::table& table) {
    check_keys(table, {"count", "box"}, {"position", "mass"});
    const int count = count_of(table, "count");
    add_stack(world, kit_of(table, count), count, read_box(table));
  });
  each("wall", [&](const toml::table& table) {
    check_keys(table, {"courses", "bricks"}, {"position", "mass"});
    const int courses = count_of(table, "courses"), bricks = count_of(table, "bricks");
    add_wall(world, kit_of(table, static_cast<double>(courses) * bricks), courses, bricks);
  });
  each("castle", [&](const toml::table& table) {
    check_keys(table, {}, {"courses", "bricks", "position", "mass"});
    const int courses = whole_int(table, "courses", 1, most_whole).value_or(16);
    const int bricks = whole_int(table, "bricks", 15, most_whole).value_or(42);  // fewer leave no room for the keep
    add_castle(world, kit_of(table, castle_bodies(courses, bricks)), courses, bricks);
  });
  each("dominoes", [&](const toml::table& table) {
    check_keys(table, {"count"}, {"position", "mass"});
    const int count = count_of(table, "count");
    add_dominoes(world, kit_of(table, count), count);
  });
  each("pit", [&](const toml::table& table) {
    check_keys(table, {"of", "count"}, {"across", "from", "seed", "position", "mass"});
    const Assortment assortment = read_assortment(table);
    const int count = count_of(table, "count"), across = whole_int(table, "across", 1, 10'000).value_or(11);
    const double from = read_length(table, "from").value_or(1.2);
    const std::uint64_t seed = read_seed(table);
    add_pit(world, kit_of(table, count + pit_walls, assortment_triangles(assortment)), assortment, count, across, from,
            seed);
  });
  each("soup", [&](const toml::table& table) {
    check_keys(table, {"of", "count", "overlapping"}, {"seed", "position", "mass"});
    const Assortment assortment = read_assortment(table);
    const int count = count_of(table, "count");
    const double overlapping = *number_between(table, "overlapping", 1e-6, .999, "");
    const std::uint64_t seed = read_seed(table);
    add_soup(world, kit_of(table, count, assortment_triangles(assortment)), assortment, count, overlapping, seed);
  });
}

}  // namespace lockstep::rigid
