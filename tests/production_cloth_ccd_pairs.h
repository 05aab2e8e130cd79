// Pairs of elements, each with four vertices of its own, for tests of continuous collision detection.
#pragma once

#include <array>
#include <random>
#include <vector>

#include "common/convert.h"
#include "common/production_cloth/ccd.h"

namespace lockstep::production_cloth {

struct CcdPair {
  bool edges;
  std::array<Vector3<double>, 4> start, end;
};

template <class Real>
struct CcdWorld {
  Topology topology;
  ElementPairs pairs;
  Vectors<Real> start, end;
};

// Pair k has vertices 4 k to 4 k + 3.
template <class Real>
CcdWorld<Real> make_ccd_world(const std::vector<CcdPair>& pairs) {
  CcdWorld<Real> world;
  Topology& topology = world.topology;
  topology.vertices = static_cast<int>(4 * pairs.size());
  world.start.resize(topology.vertices), world.end.resize(topology.vertices);
  for (const CcdPair& pair : pairs) {
    const auto v = static_cast<std::int32_t>(4 * (&pair - pairs.data()));
    if (pair.edges) {
      const auto e = static_cast<std::int32_t>(topology.edges.size());
      topology.edges.push_back({v, v + 1}), topology.edges.push_back({v + 2, v + 3});
      world.pairs.edge_edge.push_back({e, e + 1});
    } else {
      world.pairs.point_triangle.push_back({v, static_cast<std::int32_t>(topology.triangles.size())});
      topology.triangles.push_back({v + 1, v + 2, v + 3});
    }
    const auto put = [&](Vectors<Real>& to, int i, const Vector3<double>& p) {
      store(to, v + i, {static_cast<Real>(p.x), static_cast<Real>(p.y), static_cast<Real>(p.z)});
    };
    for (int i = 0; i < 4; ++i) put(world.start, i, pair.start[i]), put(world.end, i, pair.end[i]);
  }
  return world;
}

// A kernel on a world. `openmp` is of float alone.
template <class Real>
Contacts<Real> serial_impacts(const CcdWorld<Real>& world) {
  Contacts<Real> impacts;
  serial::ccd(world.topology, world.pairs, world.start, world.end, impacts);
  return impacts;
}
inline Contacts<float> openmp_impacts(const CcdWorld<float>& world) {
  openmp::CcdMemory memory;
  Contacts<float> impacts;
  openmp::ccd(world.topology, world.pairs, world.start, world.end, memory, impacts);
  return impacts;
}

// Random numbers with few bits, so that they are floats, and so are small sums of them.
struct CcdRandom {
  std::mt19937 random;
  double number() { return static_cast<double>(random() >> 16) / 0x1p16 * 2 - 1; }  // -1 .. 1
  Vector3<double> vector() {
    const double x = number(), y = number(), z = number();
    return {x, y, z};
  }
  CcdPair pair(bool edges, double size, double motion) {
    CcdPair pair = {edges, {}, {}};
    for (int i = 0; i < 4; ++i) {
      pair.start[i] = size * vector();
      pair.end[i] = pair.start[i] + motion * vector();
    }
    return pair;
  }
};

// Where the pair's points of these weights are apart at a time: 0 where they meet.
template <class Weights>
Vector3<double> apart_at(const CcdPair& pair, double time, const Weights& weight) {
  Vector3<double> sum = {0, 0, 0};
  for (int i = 0; i < 4; ++i) sum = sum + double(weight[i]) * ((1 - time) * pair.start[i] + time * pair.end[i]);
  return sum;
}

// Whether the elements may come nearer than `near` (in each component) from time 0 to `until`: an oracle without roots.
// Points of the elements have two parameters; their difference is linear in time and in either. Over a box of the three
// its components lie between those at the box's corners. Boxes that leave out 0 are dropped, others halved along the
// side that matters most.
class CcdOracle {
 public:
  CcdOracle(const CcdPair& pair, double near) : pair_(pair), near_(near) {}
  bool may_meet(double until = 1) const { return may_meet({0, 0, 0}, {until, 1, 1}); }

 private:
  using Three = std::array<double, 3>;

  Vector3<double> apart(const Three& p) const {
    const auto [t, u, v] = p;
    if (pair_.edges) return apart_at(pair_, t, std::array{1 - u, u, v - 1, -v});
    return apart_at(pair_, t, std::array{1., u + v - 1, -u, -v});
  }
  bool may_meet(const Three& from, const Three& to) const {
    if (!pair_.edges && from[1] + from[2] > 1) return false;  // beyond the triangle
    std::array<Vector3<double>, 8> corner;
    for (int k = 0; k < 8; ++k)
      corner[k] = apart({k & 1 ? to[0] : from[0], k & 2 ? to[1] : from[1], k & 4 ? to[2] : from[2]});
    double widest = 0;
    for (double Vector3<double>::*c : {&Vector3<double>::x, &Vector3<double>::y, &Vector3<double>::z}) {
      double least = corner[0].*c, greatest = least;
      for (const Vector3<double>& p : corner) least = min(least, p.*c), greatest = max(greatest, p.*c);
      if (least > near_ || greatest < -near_) return false;
      widest = max(widest, greatest - least);
    }
    if (widest <= near_) return true;
    int side = 0;
    double longest = -1;
    for (int s = 0; s < 3; ++s)
      for (int k = 0; k < 8; ++k) {
        const Vector3<double> along = corner[k | 1 << s] - corner[k & ~(1 << s)];
        if (dot(along, along) > longest) longest = dot(along, along), side = s;
      }
    Three middle_to = to, middle_from = from;
    middle_to[side] = middle_from[side] = (from[side] + to[side]) / 2;
    return may_meet(from, middle_to) || may_meet(middle_from, to);
  }

  CcdPair pair_;
  double near_;
};

}  // namespace lockstep::production_cloth
