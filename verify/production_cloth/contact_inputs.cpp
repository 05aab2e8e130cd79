#include "verify/production_cloth/contact_inputs.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "common/production_cloth/contact_batches.h"
#include "verify/inputs.h"

namespace lockstep::production_cloth {

double bytes_of(const ContactInputs& in) {
  return lockstep::bytes_of(in.pairs) + lockstep::bytes_of(in.excluded) + lockstep::bytes_of(in.nearby) +
         40. * static_cast<double>(in.inverse_mass.size());
}

}  // namespace lockstep::production_cloth

namespace lockstep::verify::production_cloth_inputs {
namespace {

using namespace production_cloth;

double longest_edge(const Topology& topology, const Vectors<double>& rest) {
  double longest = 0;
  for (const auto& [a, b] : topology.edges) {
    const Vector3<double> e = load(rest, a) - load(rest, b);
    longest = std::max(longest, dot(e, e));
  }
  return std::sqrt(longest);
}

void fold(const Scene& scene, ContactInputs& in) {
  constexpr int layers = 4;
  const double thickness = scene.contact.thickness, edge = longest_edge(scene.topology, scene.rest), pinched = 3 * edge;
  const int n = scene.topology.vertices;
  const auto [least, greatest] = std::minmax_element(scene.rest.x.begin(), scene.rest.x.begin() + n);
  const double length = (*greatest - *least) / layers;
  const Vector3<double> centre = {*least + .5 * length, scene.rest.y[0], scene.rest.z[n / 2]};
  std::mt19937 random;  // whose numbers the standard fixes
  const auto shake = [&] { return static_cast<double>(random() >> 8) / (1 << 24) - .5; };
  in.position.resize(n), in.velocity.resize(n);
  for (int i = 0; i < n; ++i) {
    const Vector3<double> rest = load(scene.rest, i);
    const int layer = std::clamp(static_cast<int>((rest.x - *least) / length), 0, layers - 1);
    const double along = rest.x - *least - layer * length;
    Vector3<double> p = {*least + (layer % 2 ? length - along : along), rest.y + .6 * thickness * layer, rest.z};
    p = p + layer * edge * Vector3<double>{.37, 0, .21};  // so that layers' vertices do not face each other
    const double radius = std::hypot(p.x - centre.x, p.z - centre.z) / pinched;
    if (radius < 1) {
      const double drawn = .1 + .9 * radius * radius;
      p.x = centre.x + drawn * (p.x - centre.x), p.z = centre.z + drawn * (p.z - centre.z);
    }
    const double x = shake(), y = shake(), z = shake();
    p = p + .1 * thickness * Vector3<double>{x, y, z};
    store(in.position, i, {float(p.x), float(p.y), float(p.z)});
    const double vx = shake(), vy = shake(), vz = shake();
    store(in.velocity, i, {float(.3 * vx), float(.3 * vy - .2 * (layer - 1.5)), float(.3 * vz)});
  }
}

}  // namespace

std::shared_ptr<const ContactInputs> contact_inputs(const std::string& path) {
  return lockstep::verify::inputs<ContactInputs>(path, [&] {
    ContactInputs in;
    in.scene = inputs(path);
    const Scene& scene = *in.scene;
    const auto thickness = static_cast<float>(scene.contact.thickness);
    in.time_step = static_cast<float>(scene.frame_time / scene.substeps);
    in.inverse_mass = inverse_masses(scene);
    fold(scene, in);
    in.pairs = pairs_within(scene.topology, in.position, in.position, thickness / 2);
    for (std::size_t k = 3; k < in.pairs.point_triangle.size(); k += 7)
      in.excluded.point_triangle.push_back(in.pairs.point_triangle[k]);
    for (std::size_t k = 4; k < in.pairs.edge_edge.size(); k += 7)
      in.excluded.edge_edge.push_back(in.pairs.edge_edge[k]);
    serial::near_contacts(scene.topology, in.pairs, in.excluded, in.position, thickness, in.nearby);
    return in;
  });
}

double approach_of(const Contacts<float>& contacts, const Vectors<float>& velocity) {
  double sum = 0;
  for (std::size_t k = 0; k < contacts.count; ++k) {
    Vector3<float> relative = {0, 0, 0};
    for (std::size_t i = 0; i < 4; ++i)
      relative = relative + contacts.weight[4 * k + i] * load(velocity, contacts.corner[4 * k + i]);
    const float* const n = &contacts.normal[4 * k];
    const double speed = std::min(dot(relative, {n[0], n[1], n[2]}), 0.f);
    sum += speed * speed;
  }
  return sum;
}

double lane_use_of_batches(const ContactInputs& in) {
  const Batches batches = make_contact_batches(in.nearby, in.inverse_mass);
  std::vector<int> lengths;
  for (int k = 0; k < batches.count(); ++k) lengths.push_back(batches.begin[k + 1] - batches.begin[k]);
  return lanes_in_use(lengths);
}

// A contact's twelve numbers are read once, and so are a vertex's inverse mass and velocity, which is written, too.
Work work_of_contacts(const ContactInputs& in, double lane_use) {
  const double n = static_cast<double>(in.nearby.count), vertices = static_cast<double>(in.inverse_mass.size());
  return {n, "contacts", 4 * (12 * n + 7 * vertices), 150 * n, lane_use};
}

}  // namespace lockstep::verify::production_cloth_inputs
