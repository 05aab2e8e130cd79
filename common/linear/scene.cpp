#include "common/linear/scene.h"

#include <algorithm>
#include <filesystem>
#include <random>
#include <utility>

#include "common/linear/make.h"
#include "common/linear/matrix_market.h"
#include "common/memory.h"
#include "common/toml.h"

namespace lockstep::linear {
namespace {

// What a solve keeps of a matrix in all its forms: rows in two orders, in double, sliced, and the factor.
constexpr double bytes_per_row = 400, bytes_per_entry = 72;

void require_size(const toml::table& table, double rows, double entries) {
  require_memory(bytes_per_row * rows + bytes_per_entry * entries,
                 position(table.source()) + ": a matrix of " + std::to_string(static_cast<long long>(rows)) + " rows");
}

struct Matrix {
  Rows<float> rows;
  BlockRows<float> blocks;
  bool symmetric;
};

Matrix read_poisson(const toml::table& table) {
  check_keys(table, {"cells"}, {"hole"});
  const int cells = static_cast<int>(*whole(table, "cells", 1, 512));
  const double hole =
      number(table, "hole", "a number from 0 to 0.49", [](double x) { return x >= 0 && x <= .49; }).value_or(.25);
  require_size(table, 1. * cells * cells * cells, 7. * cells * cells * cells);
  return {make_poisson(cells, hole), {}, true};
}

Matrix read_elasticity(const toml::table& table) {
  check_keys(table, {"points"}, {});
  const int points = static_cast<int>(*whole(table, "points", 2, 128));
  require_size(table, 3. * points * points * points, 9 * 27. * points * points * points);
  BlockRows<float> blocks = make_elasticity(points);
  Rows<float> rows = scalar_rows(blocks);
  return {std::move(rows), std::move(blocks), true};
}

Matrix read_file(const toml::table& table, const std::string& scene_path) {
  check_keys(table, {"matrix"}, {});
  auto [rows, symmetric] =
      read_matrix_market(std::filesystem::path(scene_path).replace_filename(*text(table, "matrix")).string());
  require_size(table, rows.rows, static_cast<double>(rows.value.size()));
  return {std::move(rows), {}, symmetric};
}

Matrix read_matrix(const toml::table& scene, const std::string& path) {
  const toml::table *poisson = subtable(scene, "poisson"), *elasticity = subtable(scene, "elasticity");
  const toml::table* file = subtable(scene, "file");
  if ((poisson != nullptr) + (elasticity != nullptr) + (file != nullptr) != 1)
    refuse(scene.source(), "expected one of [poisson], [elasticity] and [file]");
  return poisson ? read_poisson(*poisson) : elasticity ? read_elasticity(*elasticity) : read_file(*file, path);
}

bool has_positive_diagonal(const Rows<float>& a) {
  for (int i = 0; i < a.rows; ++i) {
    const auto row = a.column.begin() + a.begin[i], end = a.column.begin() + a.begin[i + 1];
    const auto diagonal = std::lower_bound(row, end, i);
    if (diagonal == end || *diagonal != i || !(a.value[diagonal - a.column.begin()] > 0)) return false;
  }
  return true;
}

}  // namespace

Scene load_scene(const std::string& path) {
  const toml::table scene = parse_toml(path);
  check_keys(scene, {"kind"}, {"tolerance", "iterations", "tau", "poisson", "elasticity", "file"});
  if (scene.get("kind")->value_exact<std::string>() != "linear") refuse_value(*scene.get("kind"), "kind", "\"linear\"");
  const double tolerance = number(scene, "tolerance", "a number from 1e-12 to 0.1", [](double x) {
                             return x >= 1e-12 && x <= .1;
                           }).value_or(1e-6);
  const int iterations = static_cast<int>(whole(scene, "iterations", 1, 1'000'000).value_or(2000));
  const double tau =
      number(scene, "tau", "a number from 0 to 1", [](double x) { return x >= 0 && x <= 1; }).value_or(.97);
  Matrix matrix = read_matrix(scene, path);
  const bool solvable = matrix.symmetric && has_positive_diagonal(matrix.rows);

  std::mt19937 random;  // whose numbers the standard fixes
  Array<float> b(matrix.rows.rows);
  for (float& x : b) x = static_cast<float>(static_cast<int>(random() >> 8) - (1 << 23)) / (1 << 23);
  return {.name = std::filesystem::path(path).stem().string(),
          .path = path,
          .rows = std::move(matrix.rows),
          .blocks = std::move(matrix.blocks),
          .solvable = solvable,
          .b = std::move(b),
          .stop = {.tolerance = tolerance, .iterations = iterations},
          .modification = {.tau = tau}};
}

}  // namespace lockstep::linear
