// Bodies in contact for tests of the contact solver: made by hand, at random, and as in the papers.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <type_traits>
#include <vector>

#include "common/convert.h"
#include "common/rigid/batches.h"
#include "common/rigid/contact_row.h"
#include "common/rigid/contact_solver.h"
#include "common/rigid/make.h"
#include "common/rigid/match_contacts.h"

namespace lockstep::rigid::contacts {

using Vector = Vector3<double>;

inline constexpr double u = std::numeric_limits<double>::epsilon() / 2,
                        u_float = std::numeric_limits<float>::epsilon() / 2;
inline constexpr double g = 9.81;
inline constexpr int thread_counts[] = {1, 2, 3, 4, 8};

template <class Real>
struct Problem {
  Bodies<Real> bodies;
  Array<Manifold<Real>> manifolds;
  std::vector<std::int32_t> body;  // [collider]
  Array<Impulses<Real>> impulses;  // [manifold]
  Array<Motion<Real>> moving;
};

struct Body {
  Vector position = {0, 0, 0};
  double mass = 0;                                   // kg; 0: static
  Vector inertia = {1, 1, 1};                        // kg m^2
  Vector velocity = {0, 0, 0}, angular = {0, 0, 0};  // m/s, rad/s
  Quaternion<double> orientation = no_rotation;
  double friction = 0, restitution = 0;
};

// Adds a body with one collider, which has the body's number.
inline int add(Problem<double>& p, const Body& body) {
  Bodies<double>& b = p.bodies;
  const int i = b.count++;
  b.pose.resize(padded(b.count), no_offset);
  b.motion.resize(padded(b.count)), b.inverse_mass.resize(padded(b.count));
  b.friction.resize(padded(b.count)), b.restitution.resize(padded(b.count));
  b.pose[i] = {body.position, body.orientation, 0};
  b.motion[i] = {body.velocity, body.angular, {}};
  if (body.mass > 0) b.inverse_mass[i] = {1 / body.inertia.x, 1 / body.inertia.y, 1 / body.inertia.z, 1 / body.mass};
  b.friction[i] = body.friction, b.restitution[i] = body.restitution;
  p.body.push_back(i);
  return i;
}

inline int add_box(Problem<double>& p, const Vector& half, Body body) {
  const Vector squares = {half.x * half.x, half.y * half.y, half.z * half.z};
  body.inertia = body.mass / 3 * Vector{squares.y + squares.z, squares.x + squares.z, squares.x + squares.y};
  return add(p, body);
}

using Points = std::vector<ContactPoint<double>>;

inline void touch(Problem<double>& p, int collider_a, int collider_b, const Vector& normal, const Points& points) {
  Manifold<double> m{};
  m.normal = normal;
  m.count = static_cast<std::int32_t>(points.size());
  m.a = collider_a, m.b = collider_b;
  std::ranges::copy(points, m.point);
  p.manifolds.push_back(m);
  p.impulses.push_back({});
}

// The four corners of a rectangle around `middle`, with sides along s and t.
inline Points rectangle(const Vector& middle, const Vector& s, const Vector& t, double separation = 0) {
  return {{middle - s - t, separation},
          {middle + s - t, separation},
          {middle + s + t, separation},
          {middle - s + t, separation}};
}

template <class To, class From>
Problem<To> convert(const Problem<From>& p) {
  if constexpr (std::is_same_v<To, From>) {
    return p;
  } else {
    World<From> world;
    world.bodies = p.bodies;
    Problem<To> to{rigid::convert<To>(world).bodies, {}, p.body, {}, {}};
    for (const Manifold<From>& m : p.manifolds) {
      Manifold<To>& n = to.manifolds.emplace_back();
      n = {lockstep::convert<To>(m.normal), m.count, m.a, m.b, {}, {}, {}, {}};
      for (int k = 0; k < most_points; ++k) {
        n.point[k] = {lockstep::convert<To>(m.point[k].position), static_cast<To>(m.point[k].separation)};
        n.feature[k] = m.feature[k];
      }
    }
    for (const Impulses<From>& from : p.impulses) {
      Impulses<To>& i = to.impulses.emplace_back();
      for (int k = 0; k < most_points; ++k) {
        i.normal[k] = static_cast<To>(from.normal[k]);
        i.tangent[k] = static_cast<To>(from.tangent[k]), i.bitangent[k] = static_cast<To>(from.bitangent[k]);
      }
    }
    return to;
  }
}

template <class Real>
void solve_original(const SolverSettings& settings, Problem<Real>& p) {
  serial::contact_solver_original(settings, p.manifolds, p.body, p.bodies, p.impulses, p.moving);
}
template <class Real>
void solve_batches(const SolverSettings& settings, Problem<Real>& p) {
  const Batches batches = serial::batches(p.manifolds, p.body, p.bodies);
  serial::contact_solver_batches(settings, p.manifolds, p.body, batches, p.bodies, p.impulses, p.moving);
}

inline Vector unit(const Vector& v) { return 1 / std::sqrt(dot(v, v)) * v; }

// A static ground of friction 1: the friction of a contact is then the square root of the other body's friction.
inline int add_ground(Problem<double>& p) { return add(p, {.friction = 1}); }

inline constexpr Vector box_half = {.5, .25, .4};

// [LRB08] Figure 13, [ITJ07] Figure 2: b2 bridges b1 and b3, which stand on the ground b4.
inline Problem<double> papers_bodies(double friction, const Vector& velocity) {
  Problem<double> p;
  const int b1 =
      add_box(p, box_half, {.position = {-.6, .25, 0}, .mass = 1, .velocity = {0, -.1, 0}, .friction = friction});
  const int b2 =
      add_box(p, {1, .25, .4}, {.position = {0, .75, 0}, .mass = 3, .velocity = velocity, .friction = friction});
  const int b3 =
      add_box(p, box_half, {.position = {.6, .25, 0}, .mass = 1, .velocity = {0, -.1, 0}, .friction = friction});
  const int b4 = add(p, {.friction = friction});
  touch(p, b1, b2, {0, 1, 0}, rectangle({-.55, .5, 0}, {.45, 0, 0}, {0, 0, .4}));
  touch(p, b2, b3, {0, -1, 0}, rectangle({.55, .5, 0}, {.45, 0, 0}, {0, 0, .4}));
  touch(p, b3, b4, {0, -1, 0}, rectangle({.6, 0, 0}, {.5, 0, 0}, {0, 0, .4}));
  touch(p, b1, b4, {0, -1, 0}, rectangle({-.6, 0, 0}, {.5, 0, 0}, {0, 0, .4}));
  return p;
}

// Bodies stand around a static one or around none. Contacts have 1 to 4 points, between neighbours whose normals lie
// within 30 degrees of the line from one body to the other. A solution therefore exists: moving all bodies away from
// the first one parts all contacts.
inline Problem<double> cluster(int bodies, int contacts, bool with_static, double friction, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto vector = [&] { return Vector{uniform(random), uniform(random), uniform(random)}; };
  Problem<double> p;
  for (int i = 0; i < bodies; ++i) {
    const Vector q = vector();
    const Quaternion<double> turned = {.5 * q.x, .5 * q.y, .5 * q.z, std::sqrt(1 - .25 * dot(q, q))};
    const double mass = with_static && i == 0 ? 0 : 1.5 + uniform(random);
    const Vector inertia =
        mass * Vector{.1 + .05 * uniform(random), .1 + .05 * uniform(random), .1 + .05 * uniform(random)};
    add(p, {.position = i == 0 ? Vector{0, 0, 0} : 2. * vector(),
            .mass = mass,
            .inertia = inertia,
            .velocity = vector(),
            .angular = vector(),
            .orientation = turned,
            .friction = friction});
  }
  for (int k = 0; k < contacts; ++k) {
    const int a = k < bodies - 1 ? random() % (k + 1) : random() % bodies,
              b = k < bodies - 1 ? k + 1 : random() % bodies;
    if (a >= b) continue;
    const Vector &at_a = p.bodies.pose[a].position, &at_b = p.bodies.pose[b].position;
    const Vector line = unit(at_b - at_a), across = unit(cross(line, vector())), normal = unit(line + .5 * across);
    Vector t, s;
    make_tangents(normal, t, s);
    // The points lie within .8 of both bodies along the line, as if the bodies touched.
    Points points = rectangle(.5 * (at_a + at_b), (.2 + .1 * uniform(random)) * t, (.2 + .1 * uniform(random)) * s);
    points.resize(1 + random() % 4);
    for (ContactPoint<double>& point : points) point.separation = .004 * uniform(random);
    touch(p, a, b, normal, points);
  }
  return p;
}

template <class T>
bool same_bits(const Array<T>& a, const Array<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

// Contacts between arbitrary bodies in arbitrary directions. Each body has two colliders, and static bodies move like
// conveyors.
inline Problem<float> crowd(int bodies, int contacts, double static_share, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto vector = [&] { return Vector{uniform(random), uniform(random), uniform(random)}; };
  Problem<double> p;
  for (int i = 0; i < bodies; ++i) {
    const Vector q = vector();
    add(p, {.position = 5. * vector(),
            .mass = uniform(random) < 2 * static_share - 1 ? 0. : 2 + uniform(random),
            .inertia = {.2 + .1 * uniform(random), .2 + .1 * uniform(random), .2},
            .velocity = 3. * vector(),
            .angular = vector(),
            .orientation = {.5 * q.x, .5 * q.y, .5 * q.z, std::sqrt(1 - .25 * dot(q, q))},
            .friction = std::max(0., uniform(random)),
            .restitution = std::max(0., uniform(random))});
  }
  p.body.clear();
  for (int i = 0; i < bodies; ++i) p.body.insert(p.body.end(), 2, i);
  while (static_cast<int>(p.manifolds.size()) < contacts) {
    const int a = random() % (2 * bodies), b = random() % (2 * bodies);
    const auto moves = [&](int collider) { return p.bodies.inverse_mass[p.body[collider]].w > 0; };
    if (p.body[a] >= p.body[b] || (!moves(a) && !moves(b))) continue;
    const Vector middle = .5 * (p.bodies.pose[p.body[a]].position + p.bodies.pose[p.body[b]].position);
    Points points(1 + random() % 4);
    for (ContactPoint<double>& point : points) point = {middle + .3 * vector(), .02 * uniform(random)};
    touch(p, a, b, unit(vector()), points);
    for (std::size_t k = 0; k < points.size(); ++k) {
      p.impulses.back().normal[k] = std::max(0., uniform(random));
      p.impulses.back().tangent[k] = .2 * uniform(random), p.impulses.back().bitangent[k] = .2 * uniform(random);
    }
  }
  Problem<float> crowd = convert<float>(p);
  for (int i = 0; i < bodies; ++i)
    if (crowd.bodies.inverse_mass[i].w == 0) crowd.bodies.motion[i].unused[0] = 7;  // shows a write to a static body
  return crowd;
}

}  // namespace lockstep::rigid::contacts
