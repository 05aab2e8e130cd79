// The implicit step of a cloth in lanes: the serial bits at every size and thread count, and nothing that is not
// finite.
#define EIGEN_DONT_VECTORIZE  // lanes of other widths than the rest of the program's

#include <gtest/gtest.h>
#include <omp.h>

#include <cstring>

#include "common/production_cloth/implicit_solve.h"
#include "tests/production_cloth_newton.h"

namespace lockstep::production_cloth {
namespace {

TEST(ProductionClothImplicit, IsFiniteWhereTheClothHasCollapsed) {
  for (const Material& material : all_materials()) {
    const SmallCloth cloth = sheet_of(3, 3, material);
    const int n = cloth.topology.vertices;
    const Elements<float> elements = make_elements<float>(cloth.topology, cloth.rest, material);
    const Array<float> mass = convert<float>(lumped_masses(cloth.topology, cloth.rest, material.density));
    SerialImplicitMemory memory = serial::make_implicit_memory(elements, mass);
    State<float> state = serial::make_state(elements);
    Vectors<float> x = convert<float>(cloth.rest), force;
    force.resize(n);
    const auto expect_finite = [&] {
      Vectors<float> v = convert<float>(shaken(cloth.rest, n, 1, 7));
      serial::forces(elements, x, state, force);
      const linear::Solution s = serial::implicit_solve(elements, x, mass, 1.f / 240, force,
                                                        {.tolerance = 1e-3, .iterations = 1000}, v, memory);
      EXPECT_LE(s.recursive_residual, 1e-3);
      for (int i = 0; i < n; ++i) EXPECT_TRUE(std::isfinite(v.x[i]) && std::isfinite(v.y[i]) && std::isfinite(v.z[i]));
    };
    store(x, 5, load(x, 6));
    expect_finite();
    std::ranges::fill(x.z, 0.f);  // a line
    expect_finite();
    for (Array<float>* c : {&x.x, &x.y, &x.z}) std::ranges::fill(*c, 0.f);  // a point
    expect_finite();
  }
}

// Some vertices are held. A few iterations: each takes the same sums again.
TEST(ProductionClothImplicit, LanesHaveTheSerialBitsAtEverySizeAndThreadCount) {
  for (const Material& material : all_materials())
    for (const SmallCloth& cloth :
         {sheet_of(1, 1, material), sheet_of(4, 2, material), sheet_of(3, 3, material), tube_of(3, 4, material),
          tube_of(16, 2, material), closed_of(material), sheet_of(20, 33, material)}) {
      const int n = cloth.topology.vertices;
      const Elements<float> elements = make_elements<float>(cloth.topology, cloth.rest, material);
      const Vectors<float> x = convert<float>(shaken(cloth.rest, n, .004)),
                           v = convert<float>(shaken(cloth.rest, n, 1, 7));
      const Array<float> mass = convert<float>(lumped_masses(cloth.topology, cloth.rest, material.density));
      Array<float> inverse_mass(mass.size());
      for (int i = 0; i < n; ++i) inverse_mass[i] = i % 7 == 3 ? 0 : 1 / mass[i];
      State<float> state = serial::make_state(elements);
      Vectors<float> force;
      force.resize(n);
      serial::forces(elements, x, state, force);
      const linear::Stop stop = {.tolerance = 1e-4, .iterations = 3};
      const auto solved = [&](auto memory, auto* solve) {
        Vectors<float> velocity = v;
        solve(elements, x, mass, .004f, force, stop, velocity, memory);
        return velocity;
      };
      ImplicitSolve<float, linear::BlockRows<float>>* const solve = serial::implicit_solve;
      const Vectors<float> expected = solved(serial::make_implicit_memory(elements, inverse_mass), solve);
      for (const int threads : n < 100 ? std::vector{1, 3} : std::vector{1, 2, 3, 4, 8}) {
        omp_set_num_threads(threads);
        const Vectors<float> found =
            solved(openmp::make_implicit_memory(elements, inverse_mass), openmp::implicit_solve);
        const auto same = [&](const Array<float>& a, const Array<float>& b) {
          return std::memcmp(a.data(), b.data(), 4 * n) == 0;
        };
        ASSERT_TRUE(same(found.x, expected.x) && same(found.y, expected.y) && same(found.z, expected.z))
            << n << ' ' << threads << ' ' << int(material.stretch) << ' ' << int(material.bend);
      }
    }
  omp_set_num_threads(1);
}
}  // namespace
}  // namespace lockstep::production_cloth
