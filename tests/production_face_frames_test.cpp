// Whole frames of faces: the serial bits at every number of threads, and what expressions do.
#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <tuple>

#include "common/production_face/motion.h"
#include "common/production_face/scene.h"
#include "common/production_face/step.h"
#include "tests/production_faces.h"

namespace lockstep::production_face {
namespace {

Scene scene_of(const char* name) { return load_scene(std::string("scenes/production_face/") + name + ".toml"); }

bool same_bits(const Array<float>& a, const Array<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), 4 * a.size()) == 0;
}

// Half a second: the face smiles.
TEST(ProductionFaceFrames, HaveTheSerialBitsAtEveryThreadCount) {
  const Scene scene = scene_of("face_6k");
  const Face<float> face = make_face(scene.body, scene.flesh);
  constexpr int frames = 12;
  std::vector<Pose<float>> expected;
  std::vector<std::tuple<int, int, int, double>> took;
  const auto taken = [](const Frame& f) { return std::tuple(f.steps, f.iterations, f.halvings, f.last); };
  auto rows = serial::make_memory(face);
  Pose<float> pose = scene.pose;
  for (int frame = 1; frame <= frames; ++frame) {
    serial::step_newton(face, target_at(scene.body, scene.motion, frame * frame_time), scene.tolerance, pose, rows);
    expected.push_back(pose), took.push_back(taken(rows.frame));
  }
  for (const int threads : {1, 2, 3, 4, 8}) {
    omp_set_num_threads(threads);
    auto slices = openmp::make_memory(face);
    pose = scene.pose;
    for (int frame = 1; frame <= frames; ++frame) {
      openmp::step_newton(face, target_at(scene.body, scene.motion, frame * frame_time), scene.tolerance, pose, slices);
      const Pose<float>& serial = expected[frame - 1];
      ASSERT_TRUE(same_bits(pose.displacement.x, serial.displacement.x)) << threads << ' ' << frame;
      ASSERT_TRUE(same_bits(pose.displacement.y, serial.displacement.y)) << threads << ' ' << frame;
      ASSERT_TRUE(same_bits(pose.displacement.z, serial.displacement.z)) << threads << ' ' << frame;
      ASSERT_EQ(taken(slices.frame), took[frame - 1]) << threads << ' ' << frame;
    }
  }
  omp_set_num_threads(1);
}

// The mean displacement of the eight nodes that are nearest to a place at rest.
Vector3<double> moved(const Scene& scene, const Pose<float>& pose, const Vector3<double>& place) {
  std::vector<std::pair<double, int>> nodes;
  for (int n = 0; n < scene.body.nodes; ++n) {
    const Vector3<float> x = load(scene.body.rest, n);
    nodes.push_back({std::hypot(x.x - place.x, x.y - place.y, x.z - place.z), n});
  }
  std::ranges::nth_element(nodes, nodes.begin() + 8);
  Vector3<double> sum = {0, 0, 0};
  for (int k = 0; k < 8; ++k) {
    const Vector3<float> d = load(pose.displacement, nodes[k].second);
    sum = sum + .125 * Vector3<double>{d.x, d.y, d.z};
  }
  return sum;
}

Pose<float> after_half_a_second(const Scene& scene) {
  const Face<float> face = make_face(scene.body, scene.flesh);
  auto memory = openmp::make_memory(face);
  Pose<float> pose = scene.pose;
  for (int frame = 1; frame <= 12; ++frame)
    openmp::step_newton(face, target_at(scene.body, scene.motion, frame * frame_time), scene.tolerance, pose, memory);
  return pose;
}

// How far one side is from the other's mirror image, m. The mesh is its own mirror image to the bit; tetrahedra do not
// come in a mirrored order, so both sides end anywhere within what the tolerance allows.
double asymmetry(const Scene& scene, const Pose<float>& pose) {
  std::map<std::tuple<float, float, float>, int> node;
  for (int n = 0; n < scene.body.nodes; ++n) {
    const Vector3<float> x = load(scene.body.rest, n);
    node[{x.x, x.y, x.z}] = n;
  }
  double off = 0;
  for (int n = 0; n < scene.body.nodes; ++n) {
    const Vector3<float> x = load(scene.body.rest, n), d = load(pose.displacement, n);
    const Vector3<float> e = load(pose.displacement, node.at({0.f - x.x, x.y, x.z}));
    off = std::max<double>(off, std::hypot(d.x + e.x, d.y - e.y, d.z - e.z));
  }
  return off;
}

constexpr Vector3<double> left_corner = {.026, -.045, .09}, right_corner = {-.026, -.045, .09};

TEST(ProductionFaceFrames, ASmileLiftsAndPartsTheCornersOfTheMouth) {
  const Scene scene = scene_of("face_smile");
  const Pose<float> pose = after_half_a_second(scene);
  const Vector3<double> left = moved(scene, pose, left_corner), right = moved(scene, pose, right_corner);
  Posed<float> p = posed<float>(scene.body, scene.flesh);
  p.pose = pose;
  const double error = error_of(p), off = asymmetry(scene, pose);
  std::printf("left corner (%.2f, %.2f, %.2f) mm, asymmetry %.1e mm, nodes %.1e mm from balance\n", 1e3 * left.x,
              1e3 * left.y, 1e3 * left.z, 1e3 * off, 1e3 * error);
  EXPECT_GT(left.y, .002);
  EXPECT_GT(right.y, .002);
  EXPECT_GT(left.x, 0);
  EXPECT_LT(right.x, 0);
  // Where forces vanish the face is symmetric; a node and its mirror image are each so far from there, to first order.
  EXPECT_LE(off, 2 * 2 * error);
  EXPECT_LE(error, .01 * left.y) << "the bound says something";
}

TEST(ProductionFaceFrames, APuckerDrawsThemTogetherAndAFrownDown) {
  const Scene pucker = scene_of("face_pucker"), frown = scene_of("face_frown");
  EXPECT_LT(moved(pucker, after_half_a_second(pucker), left_corner).x, -.002);
  EXPECT_LT(moved(frown, after_half_a_second(frown), left_corner).y, -.001);
}

TEST(ProductionFaceFrames, AMouthOpensWithTheJaw) {
  const Scene scene = scene_of("face_open_mouth");
  const Pose<float> pose = after_half_a_second(scene);
  const double lower = moved(scene, pose, {0, -.055, .095}).y, upper = moved(scene, pose, {0, -.03, .095}).y;
  std::printf("lower lip %.1f mm, upper lip %.1f mm\n", 1e3 * lower, 1e3 * upper);
  EXPECT_LT(lower, -.005);
  EXPECT_GT(upper, .5 * lower);
}

}  // namespace
}  // namespace lockstep::production_face
