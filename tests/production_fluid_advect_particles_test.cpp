// Particles that move, against flows whose paths are known.
#include "common/production_fluid/advect_particles.h"

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include "tests/production_fluids.h"

namespace lockstep::production_fluid {
namespace {

AdvectParticles<float>* const advects[] = {serial::advect_particles, openmp::advect_particles};

constexpr float h = .125f;         // so that positions in cells are exact
constexpr float margin = .1f * h;  // from walls and obstacles
constexpr double u = std::numeric_limits<float>::epsilon() / 2;

using Point = Vector3<float>;

// Their radii are their numbers, so that each is known wherever it goes.
Particles<float> particles_at(const std::vector<Point>& points) {
  Particles<float> particles;
  resize(particles, points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    store(particles.position, i, points[i]);
    particles.radius[i] = static_cast<float>(i), particles.sign[i] = i % 3 == 0 ? 1.f : -1.f;
  }
  return particles;
}

// Anywhere in the box, its sides included.
std::vector<Point> random_points(const Fluid<float>& fluid, int count, int seed) {
  std::mt19937 random(seed);
  const auto along = [&](int n) { return float(n) * h * static_cast<float>(random() % 65537) / 65536; };
  std::vector<Point> points(count);
  for (Point& p : points) p = {along(fluid.nx), along(fluid.ny), along(fluid.nz)};
  return points;
}

// velocity(x, y, z), m/s, of a position in cells.
template <class F>
Faces<float> faces_of(const Fluid<float>& fluid, const F& velocity) {
  Faces<float> faces = make_faces<float>(fluid.nx, fluid.ny, fluid.nz, h);
  const auto fill = [&](Field<float>& field, const Point& first, double Vector3<double>::*component) {
    for_each_place(field, [&](int x, int y, int z) {
      const Vector3<double> v = velocity(x + double(first.x), y + double(first.y), z + double(first.z));
      field(x, y, z) = static_cast<float>(v.*component);
    });
  };
  fill(faces.u, first_u, &Vector3<double>::x), fill(faces.v, first_v, &Vector3<double>::y),
      fill(faces.w, first_w, &Vector3<double>::z);
  return faces;
}
Faces<float> constant(const Fluid<float>& fluid, const Vector3<double>& v) {
  return faces_of(fluid, [&](double, double, double) { return v; });
}

// solid(x, y, z), m, of the centre of a cell, in cells.
template <class F>
void set_solid(Fluid<float>& fluid, const F& solid) {
  for_each_place(fluid.solid, [&](int x, int y, int z) {
    fluid.solid(x, y, z) = static_cast<float>(solid(x + .5, y + .5, z + .5));
  });
}

std::vector<Point> advected(AdvectParticles<float>* advect, const Fluid<float>& fluid, const Faces<float>& faces,
                            float dt, const std::vector<Point>& points) {
  Particles<float> particles = particles_at(points);
  advect(fluid, faces, dt, particles);
  EXPECT_EQ(particles.count, int(points.size()));
  std::vector<Point> result;
  for (int i = 0; i < particles.count; ++i) {
    EXPECT_EQ(particles.radius[i], float(i));
    EXPECT_EQ(particles.sign[i], i % 3 == 0 ? 1.f : -1.f);
    result.push_back(load(particles.position, i));
  }
  return result;
}
Point advected(AdvectParticles<float>* advect, const Fluid<float>& fluid, const Faces<float>& faces, float dt,
               const Point& point) {
  return advected(advect, fluid, faces, dt, std::vector{point})[0];
}

Point kept(const Fluid<float>& fluid, const Point& p) {
  const auto along = [](float x, int n) { return std::clamp(x, margin, float(n) * h - margin); };
  return {along(p.x, fluid.nx), along(p.y, fluid.ny), along(p.z, fluid.nz)};
}

void expect_equal(const Point& a, const Point& b) {
  EXPECT_EQ(a.x, b.x);
  EXPECT_EQ(a.y, b.y);
  EXPECT_EQ(a.z, b.z);
}

TEST(ProductionFluidAdvectParticles, LeavesAllBitsAtRest) {
  for (const auto& [nx, ny, nz] : {Vector3<int>{1, 1, 1}, {17, 5, 4}, {3, 1, 2}})
    for (AdvectParticles<float>* advect : advects) {
      const Fluid<float> fluid = make_air(nx, ny, nz);
      const std::vector<Point> points = random_points(fluid, 100, nx);
      const std::vector<Point> now = advected(advect, fluid, fluid.velocity, .5f, points);
      for (std::size_t i = 0; i < points.size(); ++i) expect_equal(now[i], kept(fluid, points[i]));
    }
}

// All numbers have few bits, so nothing rounds. Particles move by up to four cells, and most come to a side, where they
// stay; so they do at an open top.
TEST(ProductionFluidAdvectParticles, MovesWithAConstantVelocityAndStopsAtTheSides) {
  for (const auto& [nx, ny, nz] : {Vector3<int>{1, 1, 1}, {21, 7, 6}, {4, 9, 1}})
    for (const bool open_top : {false, true})
      for (const Vector3<double>& v : {Vector3<double>{2, -1, .5}, {-.25, 1, -2}, {0, 4, .125}})
        for (AdvectParticles<float>* advect : advects) {
          Fluid<float> fluid = make_air(nx, ny, nz);
          fluid.open_top = open_top;
          std::vector<Point> points = random_points(fluid, 333, ny);
          for (Point& p : points)
            p = {std::round(p.x * 1024) / 1024, std::round(p.y * 1024) / 1024, std::round(p.z * 1024) / 1024};
          const std::vector<Point> now = advected(advect, fluid, constant(fluid, v), .125f, points);
          for (std::size_t i = 0; i < points.size(); ++i) {
            const Point& p = points[i];
            expect_equal(now[i],
                         kept(fluid, {p.x + .125f * float(v.x), p.y + .125f * float(v.y), p.z + .125f * float(v.z)}));
          }
        }
}

// Interpolation between equal numbers does not round, nor does the sum of both velocities. What is left is the product
// with dt and the sum with the position.
TEST(ProductionFluidAdvectParticles, MovesWithAConstantVelocityToTwoRoundings) {
  const Fluid<float> fluid = make_air(23, 21, 19);
  const Vector3<double> v = {double(.7f), double(-1.1f), double(.3f)};
  const float dt = .0337f;
  for (AdvectParticles<float>* advect : advects) {
    std::vector<Point> points = random_points(fluid, 1000, 1);
    for (Point& p : points) p = {.1f + .8f * p.x, .1f + .8f * p.y, .1f + .8f * p.z};
    const std::vector<Point> now = advected(advect, fluid, constant(fluid, v), dt, points);
    const auto expect_near = [&](float to, float from, double velocity) {
      const double way = double(dt) * velocity;
      EXPECT_NEAR(to, from + way, u * (std::abs(way) + std::abs(to)));
    };
    for (std::size_t i = 0; i < points.size(); ++i) {
      expect_near(now[i].x, points[i].x, v.x);
      expect_near(now[i].y, points[i].y, v.y);
      expect_near(now[i].z, points[i].z, v.z);
    }
  }
}

// One step by the angle a is off by r |exp(ia) - (1 + ia - a^2/2)| = r a^3/6, within a factor of 1 + a/3. A linear
// velocity of up to V is interpolated to 16 u V: four roundings at each of three levels, and the position's. Two
// velocities, and that the second is taken 16 u V dt + u L away, which an angle of at most 1 does not enlarge, move
// the particle by up to 24 u V dt + u L; its own sum rounds by 2 u L.
TEST(ProductionFluidAdvectParticles, TurnsWithAnErrorOfThirdOrder) {
  constexpr int n = 20;
  constexpr double middle = n / 2., length = n * double(h), omega = 3;
  const double fastest = omega * length / std::sqrt(2.);
  const Fluid<float> fluid = make_air(n, n, n);
  for (int axis = 0; axis < 3; ++axis) {
    // The two coordinates across the axis.
    const auto across = [&](double x, double y, double z) {
      const double at[] = {x, y, z};
      return std::pair{at[(axis + 1) % 3] - middle, at[(axis + 2) % 3] - middle};
    };
    const Faces<float> faces = faces_of(fluid, [&](double x, double y, double z) {
      const auto [a, b] = across(x, y, z);
      double v[3] = {};
      v[(axis + 1) % 3] = -omega * h * b, v[(axis + 2) % 3] = omega * h * a;
      return Vector3<double>{v[0], v[1], v[2]};
    });
    for (AdvectParticles<float>* advect : advects)
      for (const double angle : {.5, .25, .125, .0625}) {
        std::vector<Point> points = random_points(fluid, 200, axis);
        for (Point& p : points)
          p = {.25f * float(length) + .5f * p.x, .25f * float(length) + .5f * p.y, .25f * float(length) + .5f * p.z};
        const std::vector<Point> now = advected(advect, fluid, faces, static_cast<float>(angle / omega), points);
        const double rounding = u * (24 * fastest * angle / omega + 3 * length);
        for (std::size_t i = 0; i < points.size(); ++i) {
          const auto cells = [&](const Point& p) { return across(p.x / h, p.y / h, p.z / h); };
          const auto [a, b] = cells(points[i]);
          const auto [to_a, to_b] = cells(now[i]);
          const double c = std::cos(angle), s = std::sin(angle), error = angle * angle * angle / 6 * std::hypot(a, b);
          EXPECT_NEAR(h * std::hypot(to_a - (c * a - s * b), to_b - (s * a + c * b)), h * error,
                      h * error * angle / 3 + 2 * rounding);  // of two coordinates
        }
      }
  }
}

// The velocity along x is that of the distance from a plane, which the particle crosses halfway. In the middle it
// vanishes; at both ends, of which Heun's method takes the mean, it does not.
TEST(ProductionFluidAdvectParticles, TakesTheMeanOfTheVelocitiesAtBothEnds) {
  const Fluid<float> fluid = make_air(20, 8, 6);
  const Faces<float> faces = faces_of(fluid, [](double, double y, double) {
    return Vector3<double>{std::abs(y - 3.5), 2, 0};
  });
  for (AdvectParticles<float>* advect : advects)
    expect_equal(advected(advect, fluid, faces, .125f, {8 * h, 2.5f * h, 3 * h}), {8 * h + .125f, 4.5f * h, 3 * h});
}

// A wall x < 10 h, whose distance is exact. What is nearer than the margin, or inside, comes to the margin; the rest
// keeps its bits. Distances of up to 10 cells are interpolated to 16 x 10 u, and the position's sum rounds by 20 u.
TEST(ProductionFluidAdvectParticles, StopsAtObstacles) {
  Fluid<float> fluid = make_air(20, 7, 6);
  set_solid(fluid, [](double x, double, double) { return (x - 10) * h; });
  const Faces<float> rest = constant(fluid, {0, 0, 0}), towards = constant(fluid, {-1, 0, 0});
  for (AdvectParticles<float>* advect : advects) {
    const auto distance = [&](const Faces<float>& faces, float cells) {
      const Point p = {(10 + cells) * h, 3.25f * h, 2.75f * h}, now = advected(advect, fluid, faces, h, p);
      EXPECT_EQ(now.y, p.y);
      EXPECT_EQ(now.z, p.z);
      return now.x / h - 10;
    };
    for (const float cells : {.125f, .5f, 1.875f, 2.5f, 8.f}) {
      EXPECT_EQ(distance(rest, cells), cells);
      EXPECT_EQ(distance(towards, cells + 1), cells);
    }
    for (const float cells : {.09f, 0.f, -.25f, -3.f}) {
      EXPECT_NEAR(distance(rest, cells), .1, 180 * u);
      EXPECT_NEAR(distance(towards, cells + 1), .1, 180 * u);
    }
  }
}

// A wall that slants, with a field that rises by one or less a cell: the way is along the normal, and by what the field
// lacks. Its values of up to 16 h are interpolated to 256 u h. They are stored to 16 u h, which turns a slope of no
// less than h / 2 by up to 2 sqrt(3) (2 + 1) 16 u: 340 u h at the end of a way of 2 h. The position's sum rounds by 20
// u h.
TEST(ProductionFluidAdvectParticles, LeavesObstaclesAlongTheNormal) {
  constexpr double bound = 640 * u * h;
  constexpr int n = 20;
  const Vector3<double> normal = {2 / 7., -3 / 7., 6 / 7.};
  for (const double rise : {1., .5}) {
    Fluid<float> fluid = make_air(n, n, n);
    const auto solid = [&](double x, double y, double z) {
      return rise * h * dot(normal, Vector3<double>{x - 10, y - 10, z - 10});
    };
    set_solid(fluid, solid);
    for (AdvectParticles<float>* advect : advects) {
      std::vector<Point> points = random_points(fluid, 4000, 1);
      for (Point& p : points) p = {.4f + .7f * p.x, .4f + .7f * p.y, .4f + .7f * p.z};
      const std::vector<Point> now = advected(advect, fluid, fluid.velocity, .1f, points);
      int pushed = 0;
      for (std::size_t i = 0; i < points.size(); ++i) {
        const Point& p = points[i];
        const double missing = margin - solid(p.x / h, p.y / h, p.z / h), way = std::max(missing, 0.);
        if (way > 2 * h) continue;
        EXPECT_NEAR(now[i].x, p.x + way * normal.x, bound);
        EXPECT_NEAR(now[i].y, p.y + way * normal.y, bound);
        EXPECT_NEAR(now[i].z, p.z + way * normal.z, bound);
        pushed += way > 0;
      }
      EXPECT_GT(pushed, 100);
    }
  }
}

TEST(ProductionFluidAdvectParticles, StaysWhereObstaclesShowNoWayOut) {
  Fluid<float> fluid = make_air(5, 4, 3);
  set_solid(fluid, [](double, double, double) { return -1.; });
  const Point p = {2.25f * h, h, 1.75f * h};
  for (AdvectParticles<float>* advect : advects) expect_equal(advected(advect, fluid, fluid.velocity, .1f, p), p);
}

// The field rises away from the box, so the way out of the obstacle is the way out of the box.
TEST(ProductionFluidAdvectParticles, NeverPushesOutOfTheBox) {
  constexpr int n = 5;
  const float least = margin, most = n * h - margin;
  for (int axis = 0; axis < 3; ++axis)
    for (const bool far : {false, true}) {
      Fluid<float> fluid = make_air(n, n, n);
      set_solid(fluid, [&](double x, double y, double z) {
        const double at[] = {x, y, z};
        return (far ? at[axis] - n - 2 : -2 - at[axis]) * h;
      });
      const Point from = {2 * h, 2.25f * h, 3 * h};
      for (AdvectParticles<float>* advect : advects) {
        const Point now = advected(advect, fluid, fluid.velocity, .1f, from);
        const float to = far ? most : least;
        expect_equal(now, {axis == 0 ? to : from.x, axis == 1 ? to : from.y, axis == 2 ? to : from.z});
      }
    }
}

// Obstacles at random are no distances; the two versions must agree all the same.
TEST(ProductionFluidAdvectParticles, LeavesTheSameBitsAtEveryNumberOfThreads) {
  const int threads_before = omp_get_max_threads();
  int seed = 0;
  for (const auto& [nx, ny, nz] : {Vector3<int>{1, 1, 1}, {2, 1, 3}, {15, 1, 1}, {17, 5, 4}, {50, 7, 6}})
    for (const int count : {0, 1, 15, 16, 17, 31, 1025, 20001}) {
      Fluid<float> fluid = make_random(nx, ny, nz, ++seed);
      if (seed % 2 == 0) for_each_cell(fluid.solid, [](float& solid) { solid *= h; });
      const std::vector<Point> points = random_points(fluid, count, seed),
                               expected = advected(serial::advect_particles, fluid, fluid.velocity, .2f, points);
      for (const int threads : {1, 2, 3, 8}) {
        omp_set_num_threads(threads);
        const std::vector<Point> now = advected(openmp::advect_particles, fluid, fluid.velocity, .2f, points);
        for (int i = 0; i < count; ++i) {
          expect_equal(now[i], expected[i]);
          expect_equal(now[i], kept(fluid, now[i]));
        }
      }
    }
  omp_set_num_threads(threads_before);
}

}  // namespace
}  // namespace lockstep::production_fluid
