#include "common/cloth/make.h"

#include <algorithm>
#include <map>
#include <utility>

#include "common/batches.h"
#include "common/convert.h"

namespace lockstep::cloth {
namespace {

void allocate(Cloth<double>& cloth, int count) {
  cloth.count = count;
  cloth.position.resize(count);
  cloth.inverse_mass.resize(padded(count));
}

// Adding 0 turns -0 into 0. So adding a correction of 0 of either sign leaves a pinned particle alone to the bit.
void place(Cloth<double>& cloth, int i, Vector3<double> point) {
  cloth.position.x[i] = point.x + 0, cloth.position.y[i] = point.y + 0, cloth.position.z[i] = point.z + 0;
}

// Adds a constraint between a and b, unless both are pinned.
void constrain(Cloth<double>& cloth, int a, int b, double rest_2) {
  if (cloth.inverse_mass[a] == 0 && cloth.inverse_mass[b] == 0) return;
  Constraints<double>& list = cloth.constraints;
  list.a.push_back(a), list.b.push_back(b), list.rest_2.push_back(rest_2);
  ++list.count;
}

// What follows from particles, constraints and triangles.
void finish(Cloth<double>& cloth) {
  cloth.previous = cloth.position;

  std::vector<char> movable(cloth.count);
  for (int i = 0; i < cloth.count; ++i) movable[i] = cloth.inverse_mass[i] != 0;
  Constraints<double>&list = cloth.constraints, &batched = cloth.batched;
  const Batches batches = make_batches(list.a, list.b, movable);
  batched.count = list.count;
  for (const int k : batches.order)
    batched.a.push_back(list.a[k]), batched.b.push_back(list.b[k]), batched.rest_2.push_back(list.rest_2[k]);
  cloth.batch_begin.assign(batches.begin.begin(), batches.begin.end());
  for (Constraints<double>* constraints : {&list, &batched}) {
    constraints->a.resize(padded(list.count)), constraints->b.resize(padded(list.count)),
        constraints->rest_2.resize(padded(list.count));
  }

  const int triangles = static_cast<int>(cloth.triangles.size());
  cloth.force.resize(std::max(triangles, 2 * (cloth.sheet.rows + 1) * (cloth.sheet.pitch + 16)));
  cloth.corner_begin.assign(cloth.count + 1, 0);
  for (const Triangle& t : cloth.triangles)
    for (const int i : {t.a, t.b, t.c}) ++cloth.corner_begin[i + 1];
  for (int i = 0; i < cloth.count; ++i) cloth.corner_begin[i + 1] += cloth.corner_begin[i];
  std::vector<int> next(cloth.corner_begin.begin(), cloth.corner_begin.end() - 1);
  cloth.corner.resize(3 * triangles);
  for (int t = 0; t < triangles; ++t)
    for (const int i : {cloth.triangles[t].a, cloth.triangles[t].b, cloth.triangles[t].c}) cloth.corner[next[i]++] = t;
}

template <class To, class From>
Constraints<To> convert(const Constraints<From>& c) {
  return {c.a, c.b, convert<To>(c.rest_2), c.count};
}
template <class To, class From>
Bodies<To> convert(const Bodies<From>& b) {
  Bodies<To> bodies;
  for (const auto& plane : b.planes)
    bodies.planes.push_back({convert<To>(plane.normal), static_cast<To>(plane.offset)});
  for (const auto& c : b.capsules)
    bodies.capsules.push_back({convert<To>(c.from), convert<To>(c.to), static_cast<To>(c.radius)});
  for (const auto& box : b.boxes)
    bodies.boxes.push_back({convert<To>(box.centre),
                            convert<To>(box.half),
                            {convert<To>(box.axis[0]), convert<To>(box.axis[1]), convert<To>(box.axis[2])}});
  bodies.friction = static_cast<To>(b.friction);
  return bodies;
}

}  // namespace

Cloth<double> make_sheet(const Model<double>& model, const Bodies<double>& bodies, const SheetPlan& plan) {
  Cloth<double> cloth;
  cloth.model = model;
  cloth.bodies = bodies;
  const int rows = plan.rows, columns = plan.columns;
  cloth.sheet = {rows, columns, (columns + 15) / 16 * 16};
  const Sheet& sheet = cloth.sheet;
  allocate(cloth, rows * sheet.pitch);
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c) {
      place(cloth, sheet.index(r, c), plan.origin + r * plan.down + c * plan.across);
      cloth.inverse_mass[sheet.index(r, c)] = rows * columns / plan.mass;
    }
  for (const int i : plan.pinned) cloth.inverse_mass[sheet.index(i / columns, i % columns)] = 0;

  const auto family = [&](int down, int right) -> Family<double> {
    const Vector3<double> link = down * plan.down + right * plan.across;
    return {down, right, dot(link, link)};
  };
  cloth.families.push_back(family(1, 0));
  if (plan.bending) cloth.families.push_back(family(2, 0));
  cloth.families.push_back(family(0, 1));
  if (plan.bending) cloth.families.push_back(family(0, 2));
  cloth.families.push_back(family(1, 1));
  cloth.families.push_back(family(1, -1));

  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c) {
      const auto constrain_to = [&](int down, int right) {
        if (r + down < rows && c + right >= 0 && c + right < columns)
          constrain(cloth, sheet.index(r, c), sheet.index(r + down, c + right), family(down, right).rest_2);
      };
      constrain_to(0, 1), constrain_to(1, 0), constrain_to(1, 1), constrain_to(1, -1);
      if (plan.bending) constrain_to(0, 2), constrain_to(2, 0);
    }

  for (int r = 0; r + 1 < rows; ++r)
    for (int c = 0; c + 1 < columns; ++c) {
      cloth.triangles.push_back({sheet.index(r, c), sheet.index(r, c + 1), sheet.index(r + 1, c)});
      cloth.triangles.push_back({sheet.index(r + 1, c + 1), sheet.index(r + 1, c), sheet.index(r, c + 1)});
    }
  finish(cloth);
  return cloth;
}

Cloth<double> make_mesh(const Model<double>& model, const Bodies<double>& bodies, const MeshPlan& plan) {
  Cloth<double> cloth;
  cloth.model = model;
  cloth.bodies = bodies;
  const int count = static_cast<int>(plan.points.size());
  allocate(cloth, count);
  for (int i = 0; i < count; ++i) {
    place(cloth, i, plan.points[i]);
    cloth.inverse_mass[i] = count / plan.mass;
  }
  for (const int i : plan.pinned) cloth.inverse_mass[i] = 0;
  cloth.triangles = plan.triangles;

  const auto constrain_points = [&](int a, int b) {
    constrain(cloth, a, b, dot(plan.points[b] - plan.points[a], plan.points[b] - plan.points[a]));
  };
  std::map<std::pair<int, int>, int> far_corner;  // of the last triangle at an edge
  std::vector<std::pair<int, int>> bends;
  for (const Triangle& t : plan.triangles)
    for (const auto [a, b, far] : {Triangle{t.a, t.b, t.c}, {t.b, t.c, t.a}, {t.c, t.a, t.b}}) {
      const auto [edge, is_new] = far_corner.try_emplace(std::minmax(a, b), far);
      if (is_new) {
        constrain_points(a, b);
      } else if (edge->second != far) {
        bends.push_back({edge->second, far});
        edge->second = far;
      }
    }
  if (plan.bending)
    for (const auto& [a, b] : bends) constrain_points(a, b);
  finish(cloth);
  return cloth;
}

template <class To, class From>
Cloth<To> convert(const Cloth<From>& c) {
  const Model<From>& m = c.model;
  Cloth<To> to;
  to.model = {static_cast<To>(m.time_step),
              m.substeps,
              m.iterations,
              convert<To>(m.gravity),
              convert<To>(m.wind),
              static_cast<To>(m.drag),
              static_cast<To>(m.velocity_factor)};
  to.bodies = convert<To>(c.bodies);
  to.count = c.count;
  to.position = convert<To>(c.position);
  to.previous = convert<To>(c.previous);
  to.inverse_mass = convert<To>(c.inverse_mass);
  to.force = convert<To>(c.force);
  to.sheet = c.sheet;
  for (const Family<From>& family : c.families)
    to.families.push_back({family.down, family.right, static_cast<To>(family.rest_2)});
  to.constraints = convert<To>(c.constraints);
  to.batched = convert<To>(c.batched);
  to.batch_begin = c.batch_begin;
  to.triangles = c.triangles;
  to.corner_begin = c.corner_begin;
  to.corner = c.corner;
  return to;
}
template Cloth<float> convert(const Cloth<double>&);
template Cloth<double> convert(const Cloth<float>&);

}  // namespace lockstep::cloth
