// Scenes settle into the same state by serial and by openmp steps (verify/inputs.h).
#include <gtest/gtest.h>

#include "verify/arrays.h"
#include "verify/cloth/inputs.h"
#include "verify/inputs.h"
#include "verify/rigid/inputs.h"

namespace lockstep::verify {
namespace {

// What make(path) gives, without and with openmp steps. The cache knows inputs by their paths, so these differ.
template <class Make>
auto both_ways(const std::string& path, const Make& make) {
  const auto serial = make(path);
  settles_by_openmp = true;
  const auto openmp = make("./" + path);
  settles_by_openmp = false;
  EXPECT_NE(serial, openmp);
  return std::pair(serial, openmp);
}

template <class S>
void expect_same(const S& openmp, const S& serial, const char* what) {
  Judgement judgement{.verdict = Verdict::bitwise, .worst_at = ""};
  same_bits(judgement, openmp, serial);
  EXPECT_TRUE(judgement.passed) << what << ": " << judgement.worst_at;
}

TEST(Settling, OfRigidBodiesHasTheSerialBits) {
  for (const char* scene : {"scenes/rigid/pyramid_15.toml", "scenes/rigid/mesh_and_hulls.toml"}) {
    const auto [serial, openmp] = both_ways(scene, rigid_inputs::inputs);
    ASSERT_GT(serial->scene.settle, 0);
    expect_same(openmp->world, serial->world, scene);
    expect_same(openmp->last, serial->last, scene);
    expect_same(openmp->now, serial->now, scene);
  }
}

TEST(Settling, OfClothHasTheSerialBits) {
  for (const char* scene : {"scenes/cloth/flag_33.toml", "scenes/cloth/garment.toml"}) {
    const auto [serial, openmp] = both_ways(scene, cloth_inputs::inputs);
    expect_same(*openmp->before_verlet, *serial->before_verlet, scene);
    expect_same(*openmp->before_collide, *serial->before_collide, scene);
  }
}

}  // namespace
}  // namespace lockstep::verify
