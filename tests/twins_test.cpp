// Twins read alike: how much of each serial file stands in its openmp twin, printed for all of them and held to a floor
// that may only rise. Run from the root of the repository.
//
// The measure is the share of the serial text's tokens that stand in the openmp text in the same order (the longest
// common subsequence). Comments, includes and pragmas do not count. Tokens tell what lines do not: a twin whose type
// names alone differ keeps few lines and nearly all tokens.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace lockstep {
namespace {

namespace fs = std::filesystem;

// Percent of the serial tokens, rounded down. A twin that comes to share more raises its floor here; a new twin gets
// one.
const std::map<std::string, int> floors = {
    {"cloth/cloths", 81},
    {"cloth/collide", 92},
    {"cloth/relax", 47},
    {"cloth/step", 86},
    {"cloth/verlet", 75},
    {"fluid/advance", 99},
    {"fluid/collisions", 99},
    {"fluid/densities", 73},
    {"fluid/forces", 68},
    {"fluid/rebuild_grid", 85},
    {"fluid/step", 96},
    {"levelset/fast_marching", 98},
    {"levelset/fast_sweeping", 55},
    {"levelset/initialize", 94},
    {"levelset/sample", 87},
    {"linear/conjugate_gradients", 98},
    {"linear/dot", 34},
    {"linear/incomplete_cholesky", 81},
    {"linear/multiply", 72},
    {"linear/update", 74},
    {"production_cloth/bvh", 88},
    {"production_cloth/ccd", 66},
    {"production_cloth/collide_bodies", 95},
    {"production_cloth/step", 94},
    {"production_cloth/pairs", 83},
    {"production_cloth/damping_solve", 59},
    {"production_cloth/forces", 60},
    {"production_cloth/implicit_solve", 79},
    {"production_cloth/impulses", 68},
    {"production_cloth/repulsions", 71},
    {"production_cloth/zones", 99},
    {"production_face/update_state", 82},
    {"production_face/assemble", 63},
    {"production_face/forces", 88},
    {"production_face/multigrid", 82},
    {"production_face/multiply", 41},
    {"production_face/solve", 90},
    {"production_face/step", 99},
    {"production_fluid/add_sources", 95},
    {"production_fluid/adjust_radii", 86},
    {"production_fluid/advance_spray", 84},
    {"production_fluid/advect_level_set", 95},
    {"production_fluid/advect_particles", 90},
    {"production_fluid/advect_velocity", 95},
    {"production_fluid/apply_forces", 97},
    {"production_fluid/correct_level_set", 64},
    {"production_fluid/extend_level_set", 60},
    {"production_fluid/extrapolate", 64},
    {"production_fluid/make_system", 82},
    {"production_fluid/multigrid", 75},
    {"production_fluid/pressure_solve", 58},
    {"production_fluid/project", 96},
    {"production_fluid/redistance", 95},
    {"production_fluid/remove_particles", 72},
    {"production_fluid/reseed", 60},
    {"production_fluid/sort_particles", 76},
    {"production_fluid/step", 91},
    {"production_fluid/time_step", 93},
    {"rigid/batches", 99},
    {"rigid/contact_blocks", 67},
    {"rigid/box_box", 62},
    {"rigid/bvh", 57},
    {"rigid/contact_solver", 69},
    {"rigid/convex_axes", 76},
    {"rigid/convex_clip", 56},
    {"rigid/gjk", 76},
    {"rigid/grid", 72},
    {"rigid/integrate", 84},
    {"rigid/kept_contacts", 76},
    {"rigid/match_contacts", 93},
    {"rigid/narrow_phase", 91},
    {"rigid/place_colliders", 81},
    {"rigid/plane_pairs", 79},
    {"rigid/planes", 57},
    {"rigid/spheres", 73},
    {"rigid/step", 99},
    {"rigid/sweep_and_prune", 43},
    {"spatial/bvh", 76},
};

// Identifiers and numbers whole, every other character on its own.
std::vector<std::string> tokens_of(std::string_view text) {
  std::vector<std::string> tokens;
  const auto is_word = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; };
  while (!text.empty()) {
    std::size_t length = 1;
    if (text.starts_with("//") || text.front() == '#') {
      length = std::min(text.find('\n'), text.size());
    } else if (is_word(text.front())) {
      while (length < text.size() && is_word(text[length])) ++length;
      tokens.emplace_back(text.substr(0, length));
    } else if (!std::isspace(static_cast<unsigned char>(text.front()))) {
      tokens.emplace_back(text.substr(0, 1));
    }
    text.remove_prefix(length);
  }
  return tokens;
}

std::vector<std::string> tokens_of_file(const std::string& path) {
  std::ifstream in(path);
  EXPECT_TRUE(in) << path;
  return tokens_of(std::string{std::istreambuf_iterator<char>(in), {}});
}

// The length of the longest common subsequence.
std::size_t tokens_in_common(const std::vector<std::string>& a, const std::vector<std::string>& b) {
  std::map<std::string_view, std::uint32_t> numbers;
  const auto numbered = [&](const std::vector<std::string>& tokens) {
    std::vector<std::uint32_t> result;
    for (const std::string& token : tokens)
      result.push_back(numbers.try_emplace(token, static_cast<std::uint32_t>(numbers.size())).first->second);
    return result;
  };
  const std::vector<std::uint32_t> x = numbered(a), y = numbered(b);
  std::vector<std::uint32_t> row(y.size() + 1, 0);
  for (const std::uint32_t token : x) {
    std::uint32_t diagonal = 0;
    for (std::size_t j = 0; j < y.size(); ++j) {
      const std::uint32_t above = row[j + 1];
      row[j + 1] = token == y[j] ? diagonal + 1 : std::max(above, row[j]);
      diagonal = above;
    }
  }
  return row.back();
}

TEST(Twins, CountsTokens) {
  EXPECT_EQ(tokens_of("a += b_1; // c\n#include <x>\n1.5f"),
            (std::vector<std::string>{"a", "+", "=", "b_1", ";", "1", ".", "5f"}));
  EXPECT_EQ(tokens_in_common({"a", "b", "c"}, {"x", "b", "y", "c"}), 2u);
  EXPECT_EQ(tokens_in_common({"a", "b"}, {"b", "a"}), 1u);
  EXPECT_EQ(tokens_in_common({}, {"a"}), 0u);
}

TEST(Twins, ReadAlike) {
  std::printf("%-32s %7s %7s %6s %6s\n", "twin", "serial", "openmp", "share", "floor");
  std::size_t twins = 0;
  for (const auto& entry : fs::recursive_directory_iterator("serial")) {
    if (entry.path().extension() != ".cpp") continue;
    ++twins;
    const std::string name = fs::path(entry.path()).lexically_relative("serial").replace_extension();
    const std::vector<std::string> serial = tokens_of_file("serial/" + name + ".cpp"),
                                   openmp = tokens_of_file("openmp/" + name + ".cpp");
    const int share =
        static_cast<int>(100 * tokens_in_common(serial, openmp) / std::max<std::size_t>(serial.size(), 1));
    const auto floor = floors.find(name);
    EXPECT_NE(floor, floors.end()) << name << " has no floor yet";
    if (floor == floors.end()) continue;
    std::printf("%-32s %7zu %7zu %5d%% %5d%%\n", name.c_str(), serial.size(), openmp.size(), share, floor->second);
    EXPECT_GE(share, floor->second) << name;
  }
  EXPECT_EQ(twins, floors.size()) << "a floor for a twin that is not there";
}

}  // namespace
}  // namespace lockstep
