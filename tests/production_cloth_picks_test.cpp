// Lanes pick what they want, from few vectors and from as many as there are lanes.
#include "openmp/production_cloth/picks.h"

#include <algorithm>

#include "tests/simd_values.h"

namespace lockstep::production_cloth::openmp {
namespace {

constexpr int slices = 60;

// Sixteens of vertices, lane l of sixteen k in slice (step k l) % slices: step 0 is one slice, 1 up to sixteen.
Array<std::int32_t> spread(int sixteens, int step) {
  Array<std::int32_t> at;
  for (int k = 0; k < sixteens; ++k)
    for (int l = 0; l < lanes; ++l) at.push_back(lanes * ((step * k * l) % slices) + (5 * l + k) % lanes);
  return at;
}

TEST(ProductionClothPicks, PickFromAnyNumberOfVectors) {
  Array<float> x(3 * lanes * slices);
  for (std::size_t k = 0; k < x.size(); ++k) x[k] = static_cast<float>(k);
  for (const int step : {0, 1, 7}) {
    const Array<std::int32_t> at = spread(12, step);
    const auto own = [](std::size_t) { return slices - 1; };  // which no lane wants
    const Picks<1, 2> alone = make_picks<1, 2>(at, slice_vectors, own);
    const Picks<3, 2> together = make_picks<3, 2>(at, slice_vectors, own);
    const Picks<1, 3> numbers = make_picks<1, 3>(at, 1, own);
    for (int k = 0; k < 12; ++k) {
      const Vector3<floatv> first = load_three(&x[3 * lanes * (slices - 1)]);
      const Vector3<floatv> one = pick_vectors(alone, k, x.data(), first)[0];
      const Vector3<floatv> of_three = pick_vectors(together, k / 3, x.data(), first)[k % 3];
      const Floats number = values(pick_numbers(numbers, k, x.data()));
      for (int l = 0; l < lanes; ++l) {
        const int v = at[lanes * k + l], begin = 3 * lanes * (v / lanes) + v % lanes;
        EXPECT_EQ(values(one.x)[l], x[begin]) << step << " " << k << " " << l;
        EXPECT_EQ(values(one.z)[l], x[begin + 2 * lanes]) << step << " " << k << " " << l;
        EXPECT_EQ(values(of_three.y)[l], x[begin + lanes]) << step << " " << k << " " << l;
        EXPECT_EQ(number[l], x[v]) << step << " " << k << " " << l;
      }
    }
  }
}

}  // namespace
}  // namespace lockstep::production_cloth::openmp
