// log, exp and cbrt of common/transcendental.h: in lanes, for a number, and the library's. Prints the table of
// notes/simd.md: ns per value, the least of 300 runs in alternation over 4096 values from 0.001 to 50.

#include "common/transcendental.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

#include "common/simd.h"

namespace {

using namespace lockstep;

double ns(auto run) {
  const auto start = std::chrono::steady_clock::now();
  run();
  return std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - start).count();
}

void measure(const char* name, auto ours, auto library) {
  const int n = 4096;
  std::vector<float> x(n), y(n);
  std::mt19937 random(1);
  std::uniform_real_distribution<float> numbers(.001f, 50);
  for (float& a : x) a = numbers(random);
  double in_lanes = 1e9, one_by_one = 1e9, of_library = 1e9;
  for (int repeat = 0; repeat < 300; ++repeat) {
    in_lanes = std::min(in_lanes, ns([&] {
                          for (int i = 0; i < n; i += lanes) store(&y[i], ours(load(&x[i])));
                        }));
    one_by_one = std::min(one_by_one, ns([&] {
                            for (int i = 0; i < n; ++i) y[i] = ours(x[i]);
                          }));
    of_library = std::min(of_library, ns([&] {
                            for (int i = 0; i < n; ++i) y[i] = library(x[i]);
                          }));
  }
  std::printf("| %s | %s | %.2f | %.2f | %.2f |\n", isa_name, name, in_lanes / n, one_by_one / n, of_library / n);
}

}  // namespace

int main() {
  measure(
      "log", [](auto x) { return log(x); }, [](float x) { return std::log(x); });
  measure(
      "exp", [](auto x) { return exp(x); }, [](float x) { return std::exp(x); });
  measure(
      "cbrt", [](auto x) { return cbrt(x); }, [](float x) { return std::cbrt(x); });
}
