// Forces on nodes: the slope of the energy, their balance, none in rigid motions; and the serial bits. And the waves in
// which openmp takes a body.
#include "common/production_face/forces.h"

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>

#include "openmp/production_face/corner_parts.h"
#include "tests/production_face_bodies.h"
#include "tests/production_face_matrices.h"

namespace lockstep::production_face {
namespace {

template <class Real>
Array<Real> forces_of(const Body<Real>& body, const Strained<Real>& strained) {
  Array<Real> force(3 * static_cast<std::size_t>(body.nodes), std::numeric_limits<Real>::quiet_NaN());
  serial::forces(body, strained, force);
  return force;
}

template <class Real>
Parts<Real> parts_at(const Body<Real>& body, const Strained<Real>& strained, int t) {
  return element_forces<Real>(body, strained, [&](const Blocked<Real>& array, int k) { return array.at(t, k); });
}

template <class Real>
int tetrahedra_at(const Body<Real>& body, int node) {
  return body.first_corner[node + 1] - body.first_corner[node];
}

double energy(const InDouble& d, const Pose<double>& pose) {
  const Strained<double> s = strained(d.body, d.flesh, pose, false);
  double sum = 0;
  for (int t = 0; t < d.body.tetrahedra; ++t) sum += d.body.volume.at(t, 0) * s.energy.at(t, 0);
  return sum;
}

TEST(ProductionFaceForces, AreMinusTheSlopeOfTheEnergy) {
  for (const double shake : {0., .0002, .0008, .004}) {
    const InDouble d = widened(tetrahedra(24, shake));
    const Array<double> force = forces_of(d.body, strained(d.body, d.flesh, d.pose, false));
    const double size = std::sqrt(std::inner_product(force.begin(), force.end(), force.begin(), 0.));
    ASSERT_GT(size, 0);  // muscles pull at rest, too
    // Energies are curved over the size of a cell, so that the error is about (1e-7 / 5e-3)^2 = 4e-10, and their
    // rounding 2^-53 by the step in units of a cell. What is left is the curves' coefficients, which are float.
    constexpr double step = 1e-7;
    for (std::size_t i = 0; i < force.size(); ++i) {
      Array<double> unit(force.size(), 0);
      unit[i] = 1;
      const auto energy_at = [&](double by) { return energy(d, moved<double>(d.pose, by, unit)); };
      EXPECT_NEAR(force[i], (energy_at(-step) - energy_at(step)) / (2 * step), 1e-6 * size) << shake << ' ' << i;
    }
  }
}

// The force on corner 0 rounds by 2 u of the others', and the sum of a node by u for each term.
TEST(ProductionFaceForces, SumToNothing) {
  for (const char* name : {"twelve", "bar_shaken", "inside_out"}) {
    const Scene scene = scene_of(name);
    const Strained<float> s = strained(scene.body, scene.flesh, scene.pose, true);
    const Array<float> force = forces_of(scene.body, s);
    double sum[3] = {}, bound[3] = {};
    for (std::size_t i = 0; i < force.size(); ++i) sum[i % 3] += force[i];
    for (int t = 0; t < scene.body.tetrahedra; ++t) {
      const Parts<float> part = parts_at(scene.body, s, t);
      for (int a = 0; a < 4; ++a) {
        const double size = 0x1p-24 * (2 + tetrahedra_at(scene.body, scene.body.corner.at(t, a)));
        bound[0] += size * std::abs(part.of[a].x), bound[1] += size * std::abs(part.of[a].y);
        bound[2] += size * std::abs(part.of[a].z);
      }
    }
    for (int c = 0; c < 3; ++c) EXPECT_LE(std::abs(sum[c]), bound[c]) << name << ' ' << c;
  }
}

// A tetrahedron's torque is that of P F^T, which is symmetric: volume |P| |F| times what its factors are off by.
// Singular values are off by up to 1.8e-14 in double (notes/production_face.md), which counts twice; products, sums and
// gradients by 64 u, gradients times the ratio of a tetrahedron's longest edge and least height, 4.
TEST(ProductionFaceForces, HaveNoTorque) {
  for (const double shake : {0., .0002, .0008}) {
    const InDouble d = widened(tetrahedra(40, shake));
    const Strained<double> s = strained(d.body, d.flesh, d.pose, false);
    const Array<double> force = forces_of(d.body, s);
    Vector torque = {0, 0, 0};
    double bound = 0;
    const auto place = [&](int n) { return load(d.body.rest, n) + load(d.pose.displacement, n); };
    for (int n = 0; n < d.body.nodes; ++n)
      torque = torque + cross(place(n), Vector{force[3 * n], force[3 * n + 1], force[3 * n + 2]});
    for (int t = 0; t < d.body.tetrahedra; ++t) {
      const Parts<double> part = parts_at(d.body, s, t);
      for (int a = 0; a < 4; ++a) {
        const int n = d.body.corner.at(t, a);
        bound +=
            (4 + tetrahedra_at(d.body, n)) * 0x1p-53 * std::sqrt(dot(place(n), place(n)) * dot(part.of[a], part.of[a]));
      }
      Matrix f = identity;
      for (int a = 0; a < 3; ++a)
        f = f +
            outer(load(d.pose.displacement, d.body.corner.at(t, a + 1)) -
                      load(d.pose.displacement, d.body.corner.at(t, 0)),
                  {d.body.gradient.at(t, 3 * a), d.body.gradient.at(t, 3 * a + 1), d.body.gradient.at(t, 3 * a + 2)});
      double stress = 0;
      for (int k = 0; k < 9; ++k) stress += s.stress.at(t, k) * s.stress.at(t, k);
      bound += (2 * 1.8e-14 + 4 * 64 * 0x1p-53) * d.body.volume.at(t, 0) * std::sqrt(stress) * norm(f);
    }
    EXPECT_LE(std::sqrt(dot(torque, torque)), bound) << shake;
    EXPECT_LT(bound, 1e-12) << "the bound says something";
  }
}

// Displacements round by u, their differences, products and sums with gradients by 8 u, and singular values by what
// tests of them allow. What that does to the stress is at most the derivative's norm times it. The material's 2/3 is a
// float, in double too: at rest its error is a pressure.
template <class Real>
void rigid_motions_do_not_strain(const Body<Real>& body, double u, double of_svd) {
  const Matrix turn = svd(Matrix{{.8, .6, .1}, {-.6, .8, -.3}, {.2, .3, 1}}).u;
  Pose<Real> pose;
  pose.displacement.resize(body.nodes);
  for (int n = 0; n < body.nodes; ++n) {
    const Vector at = convert<double>(load(body.rest, n));
    store(pose.displacement, n, convert<Real>(turn * at - at + Vector{.01, -.02, .03}));
  }
  pose.activation.assign(body.muscles, 0);
  const Strained<Real> s = strained(body, Flesh{}, pose, false);
  const Array<Real> force = forces_of(body, s);
  std::vector<double> bound(body.nodes, 0);
  for (int t = 0; t < body.tetrahedra; ++t) {
    double derivative = 0, farthest = 0;
    for (int k = 0; k < 12; ++k) derivative += 2 * std::pow(s.derivative.at(t, k), 2);  // each stands twice
    for (int a = 0; a < 4; ++a) {
      const Vector by = convert<double>(load(pose.displacement, body.corner.at(t, a)));
      farthest = std::max(farthest, std::sqrt(dot(by, by)));
    }
    double gradients = 0;
    Vector size[4] = {};
    for (int a = 0; a < 3; ++a) {
      size[a + 1] = {body.gradient.at(t, 3 * a), body.gradient.at(t, 3 * a + 1), body.gradient.at(t, 3 * a + 2)};
      size[0] = size[0] + size[a + 1];
      gradients += std::sqrt(dot(size[a + 1], size[a + 1]));
    }
    const double strain = 8 * u * (2 * farthest * gradients + 3) + 3 * of_svd;
    const double pressure = 0x1p-24 * 2 / 3 * (3 * Flesh{}.m10 + 6 * Flesh{}.m01);
    const double stress = std::sqrt(derivative) * strain + std::sqrt(3) * pressure;
    for (int a = 0; a < 4; ++a)
      bound[body.corner.at(t, a)] += body.volume.at(t, 0) * stress * std::sqrt(dot(size[a], size[a]));
  }
  for (std::size_t i = 0; i < force.size(); ++i) ASSERT_LE(std::abs(force[i]), bound[i / 3]) << i;
}

TEST(ProductionFaceForces, AreNotThereInRigidMotions) {
  for (const char* name : {"twelve", "bar_shaken"}) {
    Scene scene = scene_of(name);
    rigid_motions_do_not_strain(scene.body, 0x1p-24, 1e-6);
    rigid_motions_do_not_strain(in_double(scene.body), 0x1p-53, 1.8e-14);
  }
}

// The energy of a body that turns and shifts as it is. A turned displacement, its differences and F round by 8 u, and
// singular values by what tests of them allow; the stress is the energy's slope. Energies round by 16 u of terms that
// are no more than it and twice what is taken from it.
TEST(ProductionFaceForces, TurningKeepsTheEnergy) {
  for (const double shake : {0., .0002, .0008}) {
    const InDouble d = widened(tetrahedra(40, shake));
    const Matrix turn = svd(Matrix{{.8, .6, .1}, {-.6, .8, -.3}, {.2, .3, 1}}).u;
    Pose<double> turned = d.pose;
    double farthest = 0;
    for (int n = 0; n < d.body.nodes; ++n) {
      const Vector at = load(d.body.rest, n) + load(d.pose.displacement, n);
      const Vector by = turn * at - load(d.body.rest, n) + Vector{.01, -.02, .03};
      store(turned.displacement, n, by);
      farthest = std::max(farthest, std::sqrt(dot(by, by)) + std::sqrt(dot(at, at)));
    }
    const Strained<double> s = strained(d.body, d.flesh, d.pose, false);
    double bound = 0;
    for (int t = 0; t < d.body.tetrahedra; ++t) {
      double stress = 0, gradients = 0;
      for (int k = 0; k < 9; ++k)
        stress += std::pow(s.stress.at(t, k), 2), gradients += std::abs(d.body.gradient.at(t, k));
      const double strain = 2 * (8 * 0x1p-53 * (2 * farthest * gradients + 3) + 3 * 3 * 1.8e-14);
      const double terms = s.energy.at(t, 0) + 6 * (double(d.flesh.m10) + d.flesh.m01);
      // To the second order, as at rest there is no stress.
      bound += d.body.volume.at(t, 0) * (std::sqrt(stress) * strain + 4 * d.flesh.kappa * strain * strain +
                                         (2 * 16 + d.body.tetrahedra) * 0x1p-53 * terms);
    }
    EXPECT_NEAR(energy(d, turned), energy(d, d.pose), bound) << shake;
    EXPECT_LT(bound, 1e-8) << "the bound says something";
    if (shake > 0) {
      EXPECT_GT(energy(d, d.pose), 1e-6);
    }
  }
}

TEST(ProductionFaceForces, LanesHaveTheSerialBitsAtEverySizeAndThreadCount) {
  for (const int count : {1, 2, 15, 16, 17, 31, 32, 33, 90}) {
    const Scene scene = tetrahedra(count, .0008);
    const Strained<float> s = strained(scene.body, scene.flesh, scene.pose, true);
    const Array<float> expected = forces_of(scene.body, s);
    for (const int blocks : {1, 2, 2048})
      for (const int threads : {1, 2, 3, 8}) {
        omp_set_num_threads(threads);
        const Waves waves = make_waves(scene.body, blocks);
        Array<float> parts = make_parts(scene.body), force(expected.size(), NAN), by_locks(expected.size(), NAN);
        std::ranges::fill(parts, NAN);
        openmp::forces(scene.body, s, waves, parts, force);
        EXPECT_EQ(std::memcmp(force.data(), expected.data(), 4 * force.size()), 0) << count << ' ' << threads;
        openmp::forces_locks(scene.body, s, by_locks);
        for (std::size_t i = 0; i < expected.size(); ++i) {
          double size = 0;
          for (int t = 0; t < count; ++t)
            for (int a = 0; a < 4; ++a)
              if (scene.body.corner.at(t, a) == int(i / 3)) {
                const Vector3<float> part = parts_at(scene.body, s, t).of[a];
                size += std::abs(i % 3 == 0 ? part.x : i % 3 == 1 ? part.y : part.z);
              }
          ASSERT_LE(std::abs(by_locks[i] - expected[i]), 2 * tetrahedra_at(scene.body, int(i / 3)) * 0x1p-24 * size);
        }
      }
  }
  omp_set_num_threads(1);
}

TEST(ProductionFaceForces, RunsHoldAllPartsUntilTheyAreAddedUp) {
  const Body<float> body = scene_of("bar_shaken").body;
  const int parts_of_block = openmp::parts_of_block;
  for (const int blocks : {1, 3, 100})
    for (const int threads : {1, 2, 5, 64}) {
      const Waves waves = make_waves(body, blocks);
      ASSERT_EQ(waves.first.back(), body.nodes);
      std::vector<int> holds(parts_of_block * body.blocks(), -1), seen(body.nodes, 0);
      const auto add_up = [&](int at, const auto& place_of) {
        const int node = waves.node[at];
        ++seen[node];
        ASSERT_EQ(waves.first_part[at + 1] - waves.first_part[at], tetrahedra_at(body, node));
        for (int k = 0; k < tetrahedra_at(body, node); ++k) {
          const int part = body.corner_at_node[body.first_corner[node] + k];
          ASSERT_EQ(waves.part[waves.first_part[at] + k], part);
          ASSERT_EQ(holds[place_of(part)], part) << blocks << ' ' << threads;
        }
      };
      std::vector<int> at_borders;
      for (int thread = 0; thread < threads; ++thread) {
        const openmp::Run run = openmp::run_of(waves, body.blocks(), thread, threads);
        const auto place_of = [&](int part) { return run.place_of(part); };
        for (int begin = run.first; begin < run.last; begin += blocks) {
          const int end = std::min(begin + blocks, run.last);
          for (int part = parts_of_block * begin; part < parts_of_block * end; ++part) {
            ASSERT_EQ(openmp::run_with(waves, body.blocks(), part, threads).first, run.first);
            ASSERT_GE(place_of(part), parts_of_block * run.first);
            ASSERT_LE(place_of(part), part);
            holds[place_of(part)] = part;
          }
          for (int at = waves.first[begin]; at < waves.first[end]; ++at)
            if (waves.part[waves.first_part[at]] >= parts_of_block * run.first)
              add_up(at, place_of);
            else
              at_borders.push_back(at);
        }
      }
      for (const int at : at_borders)
        add_up(at, [&](int part) { return openmp::run_with(waves, body.blocks(), part, threads).place_of(part); });
      EXPECT_EQ(std::ranges::count(seen, 1), body.nodes);
      if (blocks == 1 && threads == 1) {
        EXPECT_LT(std::ranges::count_if(holds, [](int part) { return part >= 0; }), std::ssize(holds))
            << "room is used again";
      }
    }
}

}  // namespace
}  // namespace lockstep::production_face
