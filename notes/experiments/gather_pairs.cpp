// Trilinear samples of a field, sixteen at a time: eight gathers of one float a lane, or four of two neighbours
// (gather_pairs)?
//
// Fields of 32^3 (in the first two levels of cache), 128^3 (8 MiB) and 256^3 (64 MiB) points. Samples lie at random, or
// behind one another as those of semi-Lagrangian advection do: point i, moved by less than two cells. Both forms must
// give the same bits. Prints the table of notes/simd.md, the least of many runs.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <vector>

#include "common/simd.h"

namespace {

using namespace lockstep;

struct Samples {
  std::vector<std::int32_t> corner;
  std::vector<float> u, v, w;  // where in the cell, 0 .. 1
};

struct FloatGathers {
  static Halves along_x(const float* field, intv index) { return {gather(field, index), gather(field, index + 1)}; }
};
struct PairGathers {
  static Halves along_x(const float* field, intv index) { return gather_pairs(field, index); }
};

template <class Gathers>
void sample(const float* field, int n, const Samples& at, float* out) {
  for (std::size_t i = 0; i < at.corner.size(); i += lanes) {
    const intv corner = load(&at.corner[i]);
    const floatv u = load(&at.u[i]), v = load(&at.v[i]), w = load(&at.w[i]);
    const auto along_x = [&](int offset) {
      const auto [a, b] = Gathers::along_x(field, corner + offset);
      return a + u * (b - a);
    };
    const floatv y0 = along_x(0), y1 = along_x(n), y2 = along_x(n * n), y3 = along_x(n * n + n);
    const floatv z0 = y0 + v * (y1 - y0), z1 = y2 + v * (y3 - y2);
    store(&out[i], z0 + w * (z1 - z0));
  }
}

double ns(auto run) {
  const auto start = std::chrono::steady_clock::now();
  run();
  return std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - start).count();
}

void measure(int n, bool in_order) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> part(0, 1);
  std::vector<float> field(std::size_t(n) * n * n);
  for (float& x : field) x = part(random);
  const int count = 1 << 15;
  Samples at;
  for (int i = 0; i < count; ++i) {
    const int own[] = {i % n, i / n % n, i / n / n % n};
    int corner[3];
    for (int axis = 0; axis < 3; ++axis)
      corner[axis] = in_order ? std::min(own[axis] + int(random() % 2), n - 2) : int(random() % (n - 1));
    at.corner.push_back((corner[2] * n + corner[1]) * n + corner[0]);
    for (auto* x : {&at.u, &at.v, &at.w}) x->push_back(part(random));
  }
  std::vector<float> one(count), other(count);
  double floats = 1e18, pairs = 1e18;
  for (int repeat = 0; repeat < 500; ++repeat) {  // in alternation
    floats = std::min(floats, ns([&] { sample<FloatGathers>(field.data(), n, at, one.data()); }) / count);
    pairs = std::min(pairs, ns([&] { sample<PairGathers>(field.data(), n, at, other.data()); }) / count);
  }
  if (one != other) std::puts("the two forms differ"), std::exit(1);
  std::printf("| %s | %d^3 | %s | %.2f | %.2f | %.2f |\n", isa_name, n, in_order ? "in order" : "at random", floats,
              pairs, floats / pairs);
}

}  // namespace

int main() {
  for (int n : {32, 128, 256})
    for (bool in_order : {true, false}) measure(n, in_order);
}
