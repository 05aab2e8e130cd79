#include "common/linear/make.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace lockstep::linear {
namespace {

// Stiffness of a unit cube, corner a against corner b; bits 0, 1 and 2 of a corner are its x, y and z.
using Block = std::array<double, 9>;
using Stiffness = std::array<std::array<Block, 8>, 8>;

Stiffness make_stiffness(double young, double poisson) {
  const double lambda = young * poisson / ((1 + poisson) * (1 - 2 * poisson)), mu = young / (2 * (1 + poisson));
  Stiffness stiffness{};
  for (int gauss = 0; gauss < 8; ++gauss) {
    const auto point = [&](int axis) { return .5 + (gauss >> axis & 1 ? .5 : -.5) / std::sqrt(3.); };
    double gradient[8][3];
    for (int a = 0; a < 8; ++a)
      for (int axis = 0; axis < 3; ++axis) {
        gradient[a][axis] = 1;
        for (int other = 0; other < 3; ++other) {
          const bool far = a >> other & 1;
          gradient[a][axis] *= other == axis ? (far ? 1 : -1) : (far ? point(other) : 1 - point(other));
        }
      }
    for (int a = 0; a < 8; ++a)
      for (int b = 0; b < 8; ++b) {
        const auto &ga = gradient[a], &gb = gradient[b];
        const double product = ga[0] * gb[0] + ga[1] * gb[1] + ga[2] * gb[2];
        for (int r = 0; r < 3; ++r)
          for (int c = 0; c < 3; ++c)
            stiffness[a][b][3 * r + c] +=
                (lambda * (ga[r] * gb[c]) + mu * (ga[c] * gb[r]) + (r == c ? mu * product : 0)) / 8;
      }
  }
  return stiffness;
}

}  // namespace

Rows<float> make_poisson(int cells, double hole) {
  const int n = cells;
  const auto inside = [&](int x, int y, int z) { return std::min({x, y, z}) >= 0 && std::max({x, y, z}) < n; };
  const auto solid = [&](int x, int y, int z) {
    const double half = n / 2., dx = x + .5 - half, dy = y + .5 - half, dz = z + .5 - half;
    return dx * dx + dy * dy + dz * dz < hole * n * hole * n;
  };
  const auto cell = [&](int x, int y, int z) { return (static_cast<std::size_t>(z) * n + y) * n + x; };
  std::vector<std::int32_t> number(static_cast<std::size_t>(n) * n * n, -1);
  Rows<float> a;
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x)
        if (!solid(x, y, z)) number[cell(x, y, z)] = a.rows++;
  a.columns = a.rows;
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        if (number[cell(x, y, z)] < 0) continue;
        std::size_t diagonal = 0;
        float open = y == n - 1 ? 1 : 0;
        constexpr int sides[7][3] = {{0, 0, -1}, {0, -1, 0}, {-1, 0, 0}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
        for (const auto& [dx, dy, dz] : sides) {
          if (!inside(x + dx, y + dy, z + dz)) continue;
          const std::int32_t beside = number[cell(x + dx, y + dy, z + dz)];
          if (beside < 0) continue;
          const bool self = beside == number[cell(x, y, z)];
          if (self) diagonal = a.value.size();
          a.column.push_back(beside);
          a.value.push_back(-1);
          open += self ? 0 : 1;
        }
        a.value[diagonal] = open;
        a.begin.push_back(static_cast<std::int32_t>(a.column.size()));
      }
  return a;
}

BlockRows<float> make_elasticity(int points) {
  const int n = points;
  const Stiffness stiffness = make_stiffness(1, .3);
  const auto is_cube = [&](int x, int y, int z) {
    return x >= -1 && std::min(y, z) >= 0 && std::max({x, y, z}) < n - 1;
  };
  BlockRows<float> a;
  a.rows = a.columns = n * n * n;
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        for (int other_z = std::max(z - 1, 0); other_z <= std::min(z + 1, n - 1); ++other_z)
          for (int other_y = std::max(y - 1, 0); other_y <= std::min(y + 1, n - 1); ++other_y)
            for (int other_x = std::max(x - 1, 0); other_x <= std::min(x + 1, n - 1); ++other_x) {
              // The cubes that have both points as corners.
              Block sum{};
              for (int k = std::max(z, other_z) - 1; k <= std::min(z, other_z); ++k)
                for (int j = std::max(y, other_y) - 1; j <= std::min(y, other_y); ++j)
                  for (int i = std::max(x, other_x) - 1; i <= std::min(x, other_x); ++i)
                    if (is_cube(i, j, k)) {
                      const int corner = (x - i) + 2 * (y - j) + 4 * (z - k);
                      const int other = (other_x - i) + 2 * (other_y - j) + 4 * (other_z - k);
                      for (int e = 0; e < 9; ++e) sum[e] += stiffness[corner][other][e];
                    }
              a.column.push_back((other_z * n + other_y) * n + other_x);
              a.value.insert(a.value.end(), sum.begin(), sum.end());
            }
        a.begin.push_back(static_cast<std::int32_t>(a.column.size()));
      }
  return a;
}

}  // namespace lockstep::linear
