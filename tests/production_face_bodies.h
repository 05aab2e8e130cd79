// Small bodies, poses and vectors of nodes for the tests of the production face.
#pragma once

#include <random>
#include <span>
#include <string>
#include <vector>

#include "common/convert.h"
#include "common/production_face/make.h"
#include "common/production_face/scene.h"
#include "common/production_face/update_state.h"

namespace lockstep::production_face {

inline Scene scene_of(const char* name) { return load_scene(std::string("scenes/production_face/") + name + ".toml"); }

// The first tetrahedra of a lattice, with their nodes. Some have no fibre, some one, some two; their nodes are shaken.
inline Scene tetrahedra(int count, double shake) {
  const Mesh lattice = make_lattice({2, 2, 2}, .005);
  Mesh mesh;
  std::vector<std::int32_t> number(lattice.nodes.size(), -1);
  for (int t = 0; t < count; ++t) {
    mesh.tetrahedra.push_back(lattice.tetrahedra[t]);
    for (std::int32_t& corner : mesh.tetrahedra.back()) {
      if (number[corner] < 0) {
        number[corner] = static_cast<std::int32_t>(mesh.nodes.size());
        mesh.nodes.push_back(lattice.nodes[corner]);
      }
      corner = number[corner];
    }
  }
  std::vector<Fibre> fibres;
  for (int t = 0; t < count; ++t) {
    if (t % 3 != 1) fibres.push_back({t, 0, {.6, .8, 0}, 1});
    if (t % 3 == 2) fibres.push_back({t, 1, {0, .6, -.8}, .5});
  }
  Scene scene = {.name = "", .path = "", .body = make_body(mesh, fibres, 2), .flesh = {}, .pose = {}, .motion = {}};
  scene.pose.displacement.resize(scene.body.nodes);
  std::mt19937 random(1);
  for (Array<float>* component : {&scene.pose.displacement.x, &scene.pose.displacement.y, &scene.pose.displacement.z})
    for (int n = 0; n < scene.body.nodes; ++n)
      (*component)[n] = static_cast<float>(shake * std::uniform_real_distribution<double>(-1, 1)(random));
  scene.pose.activation = {.7f, .4f};
  return scene;
}

// The double truth of a scene.
struct InDouble {
  Body<double> body;
  Flesh flesh;
  Pose<double> pose;
};

inline InDouble widened(const Scene& scene) {
  InDouble d = {in_double(scene.body), scene.flesh, {}};
  d.pose.displacement.resize(d.body.nodes);
  for (int n = 0; n < d.body.nodes; ++n)
    store(d.pose.displacement, n, convert<double>(load(scene.pose.displacement, n)));
  d.pose.activation = convert<double>(scene.pose.activation);
  return d;
}

// The pose moved by a vector of the nodes.
template <class Real>
Pose<Real> moved(Pose<Real> pose, double by, std::span<const Real> x) {
  for (std::size_t n = 0; n < x.size() / 3; ++n) {
    pose.displacement.x[n] += by * x[3 * n], pose.displacement.y[n] += by * x[3 * n + 1];
    pose.displacement.z[n] += by * x[3 * n + 2];
  }
  return pose;
}

template <class Real>
Strained<Real> strained(const Body<Real>& body, const Flesh& flesh, const Pose<Real>& pose, bool definite) {
  Strained<Real> s = make_strained(body);
  serial::update_state(body, flesh, pose, definite, s);
  return s;
}

template <class Real>
Array<Real> random_vector(int nodes, unsigned seed) {
  Array<Real> x(3 * static_cast<std::size_t>(nodes));
  std::mt19937 random(seed);
  for (Real& e : x) e = std::uniform_real_distribution<Real>(-1, 1)(random);
  return x;
}

}  // namespace lockstep::production_face
