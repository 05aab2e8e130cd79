#include "common/rigid/generators.h"

#include <cmath>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

namespace lockstep::rigid {
namespace {

using Vector = Vector3<double>;
using std::numbers::pi;

// --- Chance

// SplitMix64 (Steele, Lea and Flood, OOPSLA 2014).
struct Random {
  std::uint64_t state;

  std::uint64_t next() {
    std::uint64_t z = state += 0x9e3779b97f4a7c15;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9;
    z = (z ^ z >> 27) * 0x94d049bb133111eb;
    return z ^ z >> 31;
  }
  double from_to(double low, double high) { return low + (high - low) * (static_cast<double>(next() >> 11) * 0x1p-53); }
};

// A uniform point on the unit sphere: a uniform point in the ball, divided by its length. Points near the middle are
// rejected, because they have few digits.
Vector random_direction(Random& random) {
  for (;;) {
    Vector v;
    for (double* x : {&v.x, &v.y, &v.z}) *x = random.from_to(-1, 1);
    const double length_2 = dot(v, v);
    if (length_2 > 1e-4 && length_2 <= 1) return 1 / std::sqrt(length_2) * v;
  }
}

// A uniform point on the sphere in four dimensions is a uniform rotation.
Quaternion<double> random_orientation(Random& random) {
  for (;;) {
    Quaternion<double> q;
    for (double* x : {&q.x, &q.y, &q.z, &q.w}) *x = random.from_to(-1, 1);
    const double length_2 = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w, scale = 1 / std::sqrt(length_2);
    if (length_2 > 1e-4 && length_2 <= 1) return {scale * q.x, scale * q.y, scale * q.z, scale * q.w};
  }
}

// --- Shapes

struct Shape {
  Kind kind;
  Vector half;    // of a box; y of a capsule
  double radius;  // of a sphere or a capsule
  int hull;
};

void add_shape(World<double>& world, const Shape& shape) {
  switch (shape.kind) {
    case Kind::sphere: return add_sphere(world, shape.radius);
    case Kind::capsule: return add_capsule(world, shape.half.y, shape.radius);
    case Kind::hull: return add_hull(world, shape.hull);
    default: return add_box(world, shape.half);
  }
}

int add_random_hull(Hulls<double>& hulls, Random& random, int count) {
  Vector axis;
  for (double* x : {&axis.x, &axis.y, &axis.z}) *x = random.from_to(.45, .75);
  std::vector<Vector> points;
  while (static_cast<int>(points.size()) < count) {
    const Vector d = random_direction(random), p{axis.x * d.x, axis.y * d.y, axis.z * d.z};
    bool apart = true;
    for (const Vector& q : points) apart &= dot(p - q, p - q) >= .1 * .1;
    if (apart) points.push_back(p);
  }
  return make_hull(hulls, points);
}

constexpr int hulls_of_assortment = 64, most_points = 24;

// The assortment's shapes, in the order in which they are taken.
std::vector<Shape> shapes_of(World<double>& world, Assortment assortment, Random& random) {
  const auto box = [](const Vector& half) { return Shape{Kind::box, half, 0, 0}; };
  const auto round = [](Kind kind, double half, double radius) { return Shape{kind, {0, half, 0}, radius, 0}; };
  const std::vector<Shape> boxes = {box({.5, .5, .5}), box({.3, .5, .7}), box({.4, .4, .4}), box({.6, .3, .4})};
  const std::vector<Shape> rounds = {round(Kind::sphere, 0, .5), round(Kind::capsule, .4, .3),
                                     round(Kind::sphere, 0, .35), round(Kind::capsule, .2, .4)};
  if (assortment == Assortment::boxes) return boxes;
  if (assortment == Assortment::rounds) return rounds;
  std::vector<Shape> hulls;
  for (int i = 0; i < hulls_of_assortment; ++i)
    hulls.push_back({Kind::hull, {}, 0, add_random_hull(world.hulls, random, 12 + i % (most_points - 11))});
  if (assortment == Assortment::hulls) return hulls;
  std::vector<Shape> mixed;
  for (int i = 0; i < hulls_of_assortment; ++i) mixed.insert(mixed.end(), {boxes[i % 4], rounds[i % 4], hulls[i]});
  return mixed;
}

// Volume, area, and the integral of mean curvature over the surface.
struct Measures {
  double volume, area, curvature;
};

// Half the sum over edges of length times the angle between the faces there. A hull's volume comes from its faces.
Measures measures_of(const Hulls<double>& hulls, int hull) {
  const auto vertex = [&](int corner) {
    const Quad<double>& v = hulls.vertex[hulls.first_vertex[hull] + corner];
    return Vector{v.x, v.y, v.z};
  };
  Measures sum{0, 0, 0};
  std::map<std::pair<int, int>, int> face_of;  // directed edge
  for (int face = hulls.first_face[hull]; face < hulls.first_face[hull + 1]; ++face) {
    const int first = hulls.first_corner[face], end = hulls.first_corner[face + 1];
    const Quad<double>& plane = hulls.plane[face];
    Vector around{0, 0, 0};  // twice the area, along the normal
    for (int k = first; k < end; ++k) {
      const int a = hulls.corner[k], b = hulls.corner[k + 1 < end ? k + 1 : first];
      around = around + cross(vertex(a), vertex(b));
      face_of[{a, b}] = face;
    }
    const double area = .5 * dot(around, {plane.x, plane.y, plane.z});
    sum.area += area;
    sum.volume += area * plane.w / 3;
  }
  for (const auto& [edge, face] : face_of) {
    if (edge.first > edge.second) continue;
    const Quad<double>&p = hulls.plane[face], &q = hulls.plane[face_of.at({edge.second, edge.first})];
    const Vector along = vertex(edge.second) - vertex(edge.first), n = cross(Vector{p.x, p.y, p.z}, {q.x, q.y, q.z});
    const double angle = std::atan2(std::sqrt(dot(n, n)), dot(Vector{p.x, p.y, p.z}, {q.x, q.y, q.z}));
    sum.curvature += .5 * std::sqrt(dot(along, along)) * angle;
  }
  return sum;
}

Measures measures_of(const Hulls<double>& hulls, const Shape& shape) {
  const double r = shape.radius, length = 2 * shape.half.y;
  switch (shape.kind) {
    case Kind::hull: return measures_of(hulls, shape.hull);
    case Kind::sphere:
    case Kind::capsule:
      return {4 * pi / 3 * r * r * r + pi * r * r * length, 4 * pi * r * r + 2 * pi * r * length,
              4 * pi * r + pi * length};
    default: break;
  }
  const double x = 2 * shape.half.x, y = 2 * shape.half.y, z = 2 * shape.half.z;
  return {x * y * z, 2 * (x * y + y * z + z * x), pi * (x + y + z)};
}

// --- Bodies

void add_body(World<double>& world, const Kit& kit, const Shape& shape, const Vector& offset,
              const Quaternion<double>& turn = no_rotation, double share_of_mass = 1) {
  begin_body(world, {kit.position + offset, turn, 0}, {}, kit.surface);
  add_shape(world, shape);
  finish_body(world, of_mass(share_of_mass * kit.mass));
}

constexpr Shape box_of(double x, double y, double z) { return {Kind::box, {x, y, z}, 0, 0}; }

// A brick is two cells long, one wide, and a course high.
constexpr double cell = .51, course_height = .5;

// Corner of the ground plan, in cells.
struct Cell {
  double x, z;
};

// Lays bricks on a square ground plan of `side` cells, whose middle is at the kit's position. `across` swaps x and z.
struct Mason {
  World<double>& world;
  const Kit& kit;
  int side;

  // Lays a brick, or a part of one: `length` cells along x and `width` along z, from a corner on.
  void lay(Cell at, double length, double width, int course, bool across) {
    if (across) std::swap(length, width);
    const double x = cell * (at.x + .5 * length - .5 * side), z = cell * (at.z + .5 * width - .5 * side);
    add_body(world, kit, box_of(.25 * length, .5 * course_height, .25 * width), {x, course_height * (course + .5), z},
             no_rotation, .5 * length * width);
  }
  // The four sides of a square of `bricks` a side, each from one corner to just before the next. Odd courses go round
  // the other way.
  void ring(Cell corner, int bricks, int course, int step) {
    sides(corner, 2 * bricks, 1, course,
          [&](Cell from, bool across, bool) { row(from, bricks, course, across, step); });
  }
  // A straight row, one brick thick, of every step-th brick.
  void row(Cell from, int bricks, int course, bool across, int step) {
    for (int k = 0; k < bricks; k += step) lay(moved(from, 2 * k, 0, across), 2, 1, course, across);
  }
  // One course of a straight wall two cells thick, in English bond. Even courses lie along the wall. Odd courses lie
  // across it, shifted by half a cell, so that one brick in two lies on four others; a half of a brick, cut along,
  // closes either end.
  void bond(Cell from, int bricks, int course, bool across) {
    if (course % 2 == 0) {
      for (const int inner : {0, 1}) row(moved(from, 0, inner, across), bricks, course, across, 1);
      return;
    }
    lay(from, .5, 2, course, across);
    for (int k = 0; k < 2 * bricks - 1; ++k) lay(moved(from, k + .5, 0, across), 1, 2, course, across);
    lay(moved(from, 2 * bricks - .5, 0, across), .5, 2, course, across);
  }
  // Calls side(from, across, far) for the sides of a square, each `length` cells long and `thick` wide, from one corner
  // to where the next one begins.
  template <class Side>
  void sides(Cell corner, int length, int thick, int course, Side side) {
    for (const bool across : {false, true}) {
      const int near = across == (course % 2 == 1) ? 0 : thick;  // where the side at 0 begins, and the far one does not
      side(moved(corner, near, 0, across), across, false);
      side(moved(corner, thick - near, length, across), across, true);
    }
  }
  static Cell moved(Cell from, double along, double in, bool across) {
    return across ? Cell{from.x + in, from.z + along} : Cell{from.x + along, from.z + in};
  }
};

constexpr int tower_bricks = 8, tower_courses = 5, keep_bricks = 7, keep_courses = 14;  // courses: more than the walls

// Bricks of a straight wall of that many courses in English bond, with every other brick of one more course on top,
// along one side.
double wall_bodies(double courses, double bricks) {
  return courses * 2 * bricks + std::floor(courses / 2) + std::ceil(bricks / 2);
}

}  // namespace

// A hull of v vertices has at most 2 v - 4 faces.
double assortment_triangles(Assortment assortment) {
  return assortment == Assortment::boxes || assortment == Assortment::rounds ? 0 : hulls_of_assortment * most_points;
}

double pyramid_bodies(double layers) { return layers * (layers + 1) * (2 * layers + 1) / 6; }

void add_pyramid(World<double>& world, const Kit& kit, int layers) {
  constexpr double s = 1.05;
  for (int i = 0; i < layers; ++i)
    for (int j = i / 2; j < layers - (i + 1) / 2; ++j)
      for (int k = i / 2; k < layers - (i + 1) / 2; ++k) {
        const double corner = -.5 * layers * s + (i % 2 == 1 ? .5 * s : 0);
        add_body(world, kit, box_of(.5, .5, .5), {corner + s * j, .5 + i, corner + s * k});
      }
}

void add_stack(World<double>& world, const Kit& kit, int count, const Vector3<double>& half) {
  for (int i = 0; i < count; ++i) add_body(world, kit, box_of(half.x, half.y, half.z), {0, (2 * i + 1) * half.y, 0});
}

void add_wall(World<double>& world, const Kit& kit, int courses, int bricks) {
  for (int i = 0; i < courses; ++i)
    for (int k = 0; k < bricks; ++k)
      add_body(world, kit, box_of(.5, .25, .25), {cell * (2 * k + i % 2 - (bricks - 1)), course_height * (i + .5), 0});
}

double castle_bodies(double courses, double bricks) {
  const double towers = 4 * (4 * tower_bricks * (courses + tower_courses) + 2 * tower_bricks);
  return 4 * wall_bodies(courses, bricks) + towers + 4 * wall_bodies(courses + keep_courses, keep_bricks);
}

void add_castle(World<double>& world, const Kit& kit, int courses, int bricks) {
  const int tower = 2 * tower_bricks + 1, keep = 2 * keep_bricks + 2, side = 2 * bricks + 2 * tower;  // cells
  Mason mason{world, kit, side};
  for (const double x : {0, side - tower})
    for (const double z : {0, side - tower}) {
      for (int course = 0; course < courses + tower_courses; ++course) mason.ring({x, z}, tower_bricks, course, 1);
      mason.ring({x, z}, tower_bricks, courses + tower_courses, 2);
    }

  const Cell corner = {.5 * (side - keep), .5 * (side - keep)};
  const int top = courses + keep_courses;
  for (int course = 0; course < top; ++course)
    mason.sides(corner, 2 * keep_bricks, 2, course,
                [&](Cell from, bool across, bool) { mason.bond(from, keep_bricks, course, across); });
  mason.sides(corner, 2 * keep_bricks, 2, top, [&](Cell from, bool across, bool far) {
    mason.row(Mason::moved(from, 0, far ? 1 : 0, across), keep_bricks, top, across, 2);
  });

  const int out = tower / 2 - 1;  // how far in from the edge of the plan a wall is
  for (const bool across : {false, true})
    for (const bool far : {false, true}) {
      const Cell from = Mason::moved({0, 0}, tower, far ? side - out - 2 : out, across);
      for (int course = 0; course < courses; ++course) mason.bond(from, bricks, course, across);
      mason.row(Mason::moved(from, 0, far ? 1 : 0, across), bricks, courses, across, 2);
    }
}

void add_dominoes(World<double>& world, const Kit& kit, int count) {
  for (int i = 0; i < count; ++i) add_body(world, kit, box_of(.1, .5, .25), {.5 * i, .5, 0});
}

void add_pit(World<double>& world, const Kit& kit, Assortment assortment, int count, int across, double from,
             std::uint64_t seed) {
  const bool with_boxes = assortment == Assortment::boxes || assortment == Assortment::mixed;
  const double spacing = with_boxes ? 1.7 : 1.65, jitter = with_boxes ? .1 : .05;
  // Eleven boxes across fit half a width of 10 m, nine hulls one of 8 m, as in the pits that other engines are measured
  // with.
  const double half_width = .5 * across * spacing + (with_boxes ? .65 : .575);
  constexpr double height = 40, thickness = 1;
  const auto fixed = [&](const Vector& offset) {
    begin_body(world, {kit.position + offset, no_rotation, 0}, {}, kit.surface);
  };
  fixed({0, 0, 0});
  add_plane(world);
  finish_body(world, immovable);
  const double out = half_width + .5 * thickness;
  for (const double side : {-1., 1.}) {
    fixed({side * out, .5 * height, 0});
    add_box(world, {.5 * thickness, .5 * height, half_width + thickness});
    finish_body(world, immovable);
  }
  for (const double side : {-1., 1.}) {
    fixed({0, .5 * height, side * out});
    add_box(world, {half_width, .5 * height, .5 * thickness});
    finish_body(world, immovable);
  }

  Random random{seed};
  const std::vector<Shape> shapes = shapes_of(world, assortment, random);
  for (int i = 0; i < count; ++i) {
    const int layer = i / (across * across), row = i / across % across, column = i % across;
    const auto place = [&](int k) { return spacing * (k - .5 * (across - 1)) + random.from_to(-jitter, jitter); };
    const double x = place(column), z = place(row);
    add_body(world, kit, shapes[i % shapes.size()], {x, from + spacing * layer, z}, random_orientation(random));
  }
}

void add_soup(World<double>& world, const Kit& kit, Assortment assortment, int count, double overlapping,
              std::uint64_t seed) {
  Random random{seed};
  const std::vector<Shape> shapes = shapes_of(world, assortment, random);
  Measures mean{0, 0, 0};
  for (const Shape& shape : shapes) {
    const Measures m = measures_of(world.hulls, shape);
    const double share = 1. / static_cast<double>(shapes.size());
    mean = {mean.volume + share * m.volume, mean.area + share * m.area, mean.curvature + share * m.curvature};
  }
  const double excluded = 2 * mean.volume + mean.area * mean.curvature / (2 * pi);
  const double half_side = .5 * std::cbrt(count * excluded / -std::log1p(-overlapping));
  for (int i = 0; i < count; ++i) {
    Vector p;
    for (double* x : {&p.x, &p.y, &p.z}) *x = random.from_to(-half_side, half_side);
    add_body(world, kit, shapes[i % shapes.size()], p, random_orientation(random));
  }
}

}  // namespace lockstep::rigid
