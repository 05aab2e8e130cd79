// What tests of a cloth's contacts share: contacts between random vertices, and their momenta.
#pragma once

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <random>
#include <string>

#include "common/convert.h"
#include "common/production_cloth/contacts.h"
#include "common/production_cloth/respond.h"

namespace lockstep::production_cloth {

// Vertices of 1 kg, and contacts of vertex and triangle or of two edges among them. Weights are multiples of 1/64, so
// that they sum to 0 exactly. Normals are along the differences of the contacts' points. The first `busy` contacts are
// all at vertex 0.
template <class Real>
struct ContactCloth {
  Vectors<Real> position, velocity;
  Array<Real> inverse_mass;
  Contacts<Real> contacts;
  int vertices;

  ContactCloth(int vertices, int count, int busy, int seed) : vertices(vertices) {
    std::mt19937 random(seed);
    const auto number = [&] { return static_cast<Real>(static_cast<int>(random() % 2001) - 1000) / 1024; };
    const auto vector = [&] {
      const Real x = number(), y = number(), z = number();
      return Vector3<Real>{x, y, z};
    };
    position.resize(vertices), velocity.resize(vertices), inverse_mass.resize(padded(vertices));
    for (int v = 0; v < vertices; ++v) store(position, v, vector()), store(velocity, v, vector()), inverse_mass[v] = 1;
    for (int k = 0; k < count; ++k) {
      std::array<std::int32_t, 4> corner;
      for (int i = 0; i < 4; ++i) {
        do corner[i] = random() % vertices;
        while (std::find(corner.begin(), corner.begin() + i, corner[i]) != corner.begin() + i);
      }
      if (k < busy && std::ranges::find(corner, 0) == corner.end()) corner[random() % 4] = 0;
      const Real a = Real(random() % 33) / 64, b = Real(random() % 31) / 64;
      if (k % 2)
        add(corner, {1, -(1 - a - b), -a, -b});
      else
        add(corner, {1 - a, a, -(1 - b), -b});
    }
  }

  void add(const std::array<std::int32_t, 4>& corner, const std::array<Real, 4>& weight) {
    const std::size_t k = 4 * contacts.count;
    contacts.resize(contacts.count + 1);
    Vector3<Real> difference = {0, 0, 0};
    for (int i = 0; i < 4; ++i) difference = difference + weight[i] * load(position, corner[i]);
    const Real distance = std::sqrt(dot(difference, difference));
    std::ranges::copy(corner, &contacts.corner[k]);
    std::ranges::copy(weight, &contacts.weight[k]);
    std::ranges::copy(std::array{difference.x / distance, difference.y / distance, difference.z / distance, distance},
                      &contacts.normal[k]);
  }

  // Contact k alone.
  Contacts<Real> only(std::size_t k) const {
    Contacts<Real> one;
    one.resize(1);
    std::copy_n(&contacts.corner[4 * k], 4, one.corner.begin());
    std::copy_n(&contacts.weight[4 * k], 4, one.weight.begin());
    std::copy_n(&contacts.normal[4 * k], 4, one.normal.begin());
    return one;
  }

  Touching<Real> touching(std::size_t k) const {
    Touching<Real> c;
    for (std::size_t i = 0; i < 4; ++i) {
      const std::int32_t v = contacts.corner[4 * k + i];
      c.weight[i] = contacts.weight[4 * k + i], c.velocity[i] = load(velocity, v), c.inverse_mass[i] = inverse_mass[v];
    }
    c.normal = {contacts.normal[4 * k], contacts.normal[4 * k + 1], contacts.normal[4 * k + 2]};
    c.distance = contacts.normal[4 * k + 3];
    return c;
  }
  double speed(std::size_t k) const {
    const Touching<Real> c = touching(k);
    return dot(c.normal, weighted(c.weight, c.velocity));
  }
  // How fast contacts approach: the sum of squares.
  double approach() const {
    double sum = 0;
    for (std::size_t k = 0; k < contacts.count; ++k) sum += std::pow(std::min(speed(k), 0.), 2);
    return sum;
  }

  Vector3<double> momentum() const {
    Vector3<double> sum = {0, 0, 0};
    for (int v = 0; v < vertices; ++v) sum = sum + convert<double>(load(velocity, v));
    return sum;
  }
  Vector3<double> angular_momentum() const {
    Vector3<double> sum = {0, 0, 0};
    for (int v = 0; v < vertices; ++v)
      sum = sum + cross(convert<double>(load(position, v)), convert<double>(load(velocity, v)));
    return sum;
  }
};

inline double length(const Vector3<double>& v) { return std::sqrt(dot(v, v)); }

// A point .25 above the middle of a triangle whose corners stand still; the point moves by `velocity`.
inline ContactCloth<double> point_over_triangle(const Vector3<double>& velocity) {
  ContactCloth<double> c(4, 0, 0, 1);
  store(c.position, 0, {0, .25, 0}), store(c.position, 1, {2, 0, -1});
  store(c.position, 2, {-1, 0, -1}), store(c.position, 3, {-1, 0, 2});
  store(c.velocity, 0, velocity);
  for (int v : {1, 2, 3}) store(c.velocity, v, {0, 0, 0});
  const double third = 1 / 3.;
  c.add({0, 1, 2, 3}, {1, -third, -third, -third});
  return c;
}

template <class Real>
testing::AssertionResult same_vectors(const Vectors<Real>& a, const Vectors<Real>& b, int count) {
  for (int v = 0; v < count; ++v) {
    const Vector3<Real> x = load(a, v), y = load(b, v);
    if (std::memcmp(&x, &y, sizeof x) != 0) return testing::AssertionFailure() << "vertex " << v;
  }
  return testing::AssertionSuccess();
}

// Runs `respond` on one contact after another, and holds each to the momenta. A new velocity is rounded, and so are
// weight / mass times impulse, twice; normals, impulse and difference are off by u each, and their product by four
// more.
template <class Respond>
void keeps_momenta(ContactCloth<double> c, bool slides, const Respond& respond) {
  constexpr double u = 0x1p-53;
  for (std::size_t k = 0; k < c.contacts.count; ++k) {
    const Contacts<double> one = c.only(k);
    const Vectors<double> before = c.velocity;
    const Vector3<double> linear = c.momentum(), angular = c.angular_momentum();
    respond(one, c.velocity);
    // Momenta are summed over all vertices, twice.
    double bound = 0, moments = 0;
    for (int v = 0; v < c.vertices; ++v)
      bound += 2 * c.vertices * u * length(load(before, v)), moments += 8 * c.vertices * u * length(load(before, v));
    for (int i = 0; i < 4; ++i) {
      const int v = one.corner[i];
      const Vector3<double> change = load(c.velocity, v) - load(before, v);
      bound += u * (length(load(c.velocity, v)) + 3 * length(change));
      moments += std::sqrt(3) * (u * (length(load(c.velocity, v)) + 3 * length(change)) + 8 * u * length(change));
    }
    EXPECT_LE(length(c.momentum() - linear), bound) << k;
    if (!slides) {
      EXPECT_LE(length(c.angular_momentum() - angular), moments) << k;
    }
  }
}

// What `respond` does at every number of threads is what `expected` holds.
template <class Respond>
void at_each_team(const Respond& respond) {
  const int before = omp_get_max_threads();
  for (const int threads : {1, 2, 3, 4, 8}) {
    SCOPED_TRACE(testing::Message() << threads << " threads");
    omp_set_num_threads(threads);
    respond();
  }
  omp_set_num_threads(before);
}

}  // namespace lockstep::production_cloth
