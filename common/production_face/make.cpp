#include "common/production_face/make.h"

#include <algorithm>

#include "common/convert.h"

namespace lockstep::production_face {
namespace {

// The gradients of the shape functions of corners 1, 2 and 3, and the volume. In double for both precisions: float's
// are those of double, rounded.
struct Shape {
  Vector3<double> gradient[3];
  double volume;
};

Shape shape_of(const Vector3<double> (&x)[4]) {
  const Vector3<double> a = x[1] - x[0], b = x[2] - x[0], c = x[3] - x[0];
  const double six = dot(a, cross(b, c));
  return {{(1 / six) * cross(b, c), (1 / six) * cross(c, a), (1 / six) * cross(a, b)}, six / 6};
}

template <class Real>
void set_shapes(Body<Real>& body) {
  for (int t = 0; t < body.padded_tetrahedra(); ++t) {
    Vector3<double> x[4];
    for (int a = 0; a < 4; ++a) {
      const Vector3<Real> rest = load(body.rest, body.corner.at(t, a));
      x[a] = {double(rest.x), double(rest.y), double(rest.z)};
    }
    const Shape shape = shape_of(x);
    for (int a = 0; a < 3; ++a) {
      body.gradient.at(t, 3 * a) = static_cast<Real>(shape.gradient[a].x);
      body.gradient.at(t, 3 * a + 1) = static_cast<Real>(shape.gradient[a].y);
      body.gradient.at(t, 3 * a + 2) = static_cast<Real>(shape.gradient[a].z);
    }
    body.volume.at(t, 0) = t < body.tetrahedra ? static_cast<Real>(shape.volume) : Real(0);
  }
}

void set_fibres(const std::vector<Fibre>& fibres, Body<float>& body) {
  std::vector<int> of_tetrahedron(body.padded_tetrahedra(), 0);
  for (const Fibre& fibre : fibres) ++of_tetrahedron[fibre.tetrahedron];
  body.first_fibre.assign(body.blocks() + 1, 0);
  for (int block = 0; block < body.blocks(); ++block) {
    const auto begin = of_tetrahedron.begin() + std::ptrdiff_t(block) * lanes;
    body.first_fibre[block + 1] = body.first_fibre[block] + *std::max_element(begin, begin + lanes);
  }
  const int slots = body.first_fibre.back();
  body.muscle = {1, slots}, body.fibre = {5, slots};
  std::ranges::fill(body.muscle.value, -1);
  std::ranges::fill(of_tetrahedron, 0);
  for (const Fibre& fibre : fibres) {
    const int t = fibre.tetrahedron;
    const int place = (body.first_fibre[t / lanes] + of_tetrahedron[t]++) * lanes + t % lanes;
    body.muscle.at(place, 0) = fibre.muscle;
    const double values[] = {fibre.direction.x, fibre.direction.y, fibre.direction.z, fibre.share, fibre.stress};
    for (int k = 0; k < 5; ++k) body.fibre.at(place, k) = static_cast<float>(values[k]);
  }
}

void set_corners_at_nodes(Body<float>& body) {
  body.first_corner.assign(body.nodes + 1, 0);
  for (int t = 0; t < body.tetrahedra; ++t)
    for (int a = 0; a < 4; ++a) ++body.first_corner[body.corner.at(t, a) + 1];
  for (int n = 0; n < body.nodes; ++n) body.first_corner[n + 1] += body.first_corner[n];
  Array<std::int32_t> next(body.first_corner.begin(), body.first_corner.end());
  body.corner_at_node.resize(4 * static_cast<std::size_t>(body.tetrahedra));
  for (int t = 0; t < body.tetrahedra; ++t)
    for (int a = 0; a < 4; ++a) body.corner_at_node[next[body.corner.at(t, a)]++] = 4 * t + a;
}

// Numbers the nodes of a box of nx ny nz points, x first.
struct Points {
  int nx, ny, nz, first;

  std::int32_t operator()(int x, int y, int z) const { return first + x + nx * (y + ny * z); }
};

}  // namespace

Mesh make_lattice(const std::array<int, 3>& cells, double spacing) {
  const int nx = cells[0], ny = cells[1], nz = cells[2];
  const Points corner = {nx + 1, ny + 1, nz + 1, 0}, middle = {nx, ny, nz, (nx + 1) * (ny + 1) * (nz + 1)};
  Mesh mesh;
  for (int z = 0; z <= nz; ++z)
    for (int y = 0; y <= ny; ++y)
      for (int x = 0; x <= nx; ++x) mesh.nodes.push_back({spacing * x, spacing * y, spacing * z});
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) mesh.nodes.push_back({spacing * (x + .5), spacing * (y + .5), spacing * (z + .5)});

  const auto add = [&](std::array<std::int32_t, 4> t) {
    const Vector3<double> x[4] = {mesh.nodes[t[0]], mesh.nodes[t[1]], mesh.nodes[t[2]], mesh.nodes[t[3]]};
    if (shape_of(x).volume < 0) std::swap(t[2], t[3]);
    mesh.tetrahedra.push_back(t);
  };
  // About the face of four corners, in turn, between the middles of two cells; or, at a side of the box, in front of
  // the one middle, along a diagonal that alternates.
  const auto add_face = [&](const std::array<std::int32_t, 4>& face, std::int32_t low, std::int32_t high, bool odd) {
    if (low >= 0 && high >= 0)
      for (int k = 0; k < 4; ++k) add({low, high, face[k], face[(k + 1) % 4]});
    else
      for (int k = 0; k < 2; ++k)
        add({std::max(low, high), face[odd + 2 * k], face[(odd + 2 * k + 1) % 4], face[(odd + 2 * k + 2) % 4]});
  };
  for (int z = 0; z <= nz; ++z)
    for (int y = 0; y <= ny; ++y)
      for (int x = 0; x <= nx; ++x) {
        const auto cell = [&](int dx, int dy, int dz) {
          const int i = x - dx, j = y - dy, k = z - dz;
          return i < 0 || j < 0 || k < 0 || i >= nx || j >= ny || k >= nz ? -1 : middle(i, j, k);
        };
        const bool odd = (x + y + z) % 2;
        if (y < ny && z < nz)
          add_face({corner(x, y, z), corner(x, y + 1, z), corner(x, y + 1, z + 1), corner(x, y, z + 1)}, cell(1, 0, 0),
                   cell(0, 0, 0), odd);
        if (x < nx && z < nz)
          add_face({corner(x, y, z), corner(x + 1, y, z), corner(x + 1, y, z + 1), corner(x, y, z + 1)}, cell(0, 1, 0),
                   cell(0, 0, 0), odd);
        if (x < nx && y < ny)
          add_face({corner(x, y, z), corner(x + 1, y, z), corner(x + 1, y + 1, z), corner(x, y + 1, z)}, cell(0, 0, 1),
                   cell(0, 0, 0), odd);
      }
  return mesh;
}

Body<float> make_body(const Mesh& mesh, const std::vector<Fibre>& fibres, int muscles) {
  Body<float> body;
  body.nodes = static_cast<int>(mesh.nodes.size());
  body.tetrahedra = static_cast<int>(mesh.tetrahedra.size());
  body.muscles = muscles;
  body.rest.resize(body.nodes);
  for (int n = 0; n < body.nodes; ++n) {
    const Vector3<double>& x = mesh.nodes[n];
    store(body.rest, n, {static_cast<float>(x.x), static_cast<float>(x.y), static_cast<float>(x.z)});
  }
  const int blocks = (body.tetrahedra + lanes - 1) / lanes;
  body.corner = {4, blocks}, body.gradient = {9, blocks}, body.volume = {1, blocks};
  for (int t = 0; t < body.padded_tetrahedra(); ++t)
    for (int a = 0; a < 4; ++a) body.corner.at(t, a) = mesh.tetrahedra[std::min(t, body.tetrahedra - 1)][a];
  set_shapes(body);
  set_fibres(fibres, body);
  set_corners_at_nodes(body);
  return body;
}

Body<double> in_double(const Body<float>& from) {
  Body<double> body;
  body.nodes = from.nodes, body.tetrahedra = from.tetrahedra, body.muscles = from.muscles;
  body.rest = convert<double>(from.rest);
  body.corner = from.corner;
  body.gradient = {9, from.blocks()}, body.volume = {1, from.blocks()};
  set_shapes(body);
  body.first_fibre = from.first_fibre, body.muscle = from.muscle;
  body.fibre.fields = from.fibre.fields, body.fibre.value = convert<double>(from.fibre.value);
  body.first_corner = from.first_corner, body.corner_at_node = from.corner_at_node, body.held = from.held;
  return body;
}

}  // namespace lockstep::production_face
