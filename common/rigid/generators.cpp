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

// Uniform on the sphere, as points in the ball are, divided by their length. Not too near its middle, where digits are few.
Vector random_direction(Random& random) {
  for (;;) {
    Vector v;
    for (double* x : {&v.x, &v.y, &v.z}) *x = random.from_to(-1, 1);
    const double length_2 = dot(v, v);
    if (length_2 > 1e-4 && length_2 <= 1) return 1 / std::sqrt(length_2) * v;
  }
}

// The same in four dimensions, where directions are rotations.
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

// What the assortment has, in the order in which it is taken.
std::vector<Shape> shapes_of(World<double>& world, Assortment assortment, Random& random) {
  const std::vector<Shape> boxes = {
      {Kind::box, {.5, .5, .5}, 0, 0}, {Kind::box, {.3, .5, .7}, 0, 0}, {Kind::box, {.4, .4, .4}, 0, 0}, {Kind::box, {.6, .3, .4}, 0, 0}};
  const std::vector<Shape> rounds = {
      {Kind::sphere, {}, .5, 0}, {Kind::capsule, {0, .4, 0}, .3, 0}, {Kind::sphere, {}, .35, 0}, {Kind::capsule, {0, .2, 0}, .4, 0}};
  if (assortment == Assortment::boxes) return boxes;
  if (assortment == Assortment::rounds) return rounds;
  std::vector<Shape> hulls;
  for (int i = 0; i < 64; ++i) hulls.push_back({Kind::hull, {}, 0, add_random_hull(world.hulls, random, 12 + i % 13)});
  if (assortment == Assortment::hulls) return hulls;
  std::vector<Shape> mixed;
  for (int i = 0; i < 64; ++i) mixed.insert(mixed.end(), {boxes[i % 4], rounds[i % 4], hulls[i]});
  return mixed;
}

// Volume, area, and the integral of mean curvature over the surface.
struct Measures {
  double volume, area, curvature;
};

// Half the sum over edges of their length times the angle that the surface turns by. A hull's volume from its faces.
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
      return {4 * pi / 3 * r * r * r + pi * r * r * length, 4 * pi * r * r + 2 * pi * r * length, 4 * pi * r + pi * length};
    default: break;
  }
  const double x = 2 * shape.half.x, y = 2 * shape.half.y, z = 2 * shape.half.z;
  return {x * y * z, 2 * (x * y + y * z + z * x), pi * (x + y + z)};
}

// --- Bodies

void add_body(World<double>& world, const Kit& kit, const Shape& shape, const Vector& offset, const Quaternion<double>& turn = no_rotation,
              double share_of_mass = 1) {
  begin_body(world, {kit.position + offset, turn, 0}, {}, kit.surface);
  add_shape(world, shape);
  finish_body(world, of_mass(share_of_mass * kit.mass));
}

constexpr Shape box_of(double x, double y, double z) { return {Kind::box, {x, y, z}, 0, 0}; }

// A brick is two cells long, one wide, and a course high.
constexpr double cell = .51, course_height = .5;

// Corner of the ground plan, in cells.
struct Cell {
  int x, z;
};

// Lays bricks on a ground plan of `side` cells square, its middle at the kit's position. Where `across`, x and z change places.
struct Mason {
  World<double>& world;
  const Kit& kit;
  int side;

  void lay(Cell at, int course, int length, bool across) {
    const double middle = .5 * side, x = cell * (at.x + (across ? .5 : .5 * length) - middle),
                 z = cell * (at.z + (across ? .5 * length : .5) - middle);
    const double half = .25 * length;
    add_body(world, kit, across ? box_of(.25, .25, half) : box_of(half, .25, .25), {x, course_height * (course + .5), z}, no_rotation,
             .5 * length);
  }
  // The four sides of a square, of `bricks` a side, each from one corner to just before the next. Every other course goes the other way
  // round.
  void ring(Cell corner, int bricks, int course, int step) {
    const int last = 2 * bricks;
    for (const bool across : {false, true}) {
      const int near = across == (course % 2 == 1) ? 0 : 1;  // where the side at 0 begins, and the one at `last` does not
      for (int k = 0; k < bricks; k += step) {
        const Cell a{2 * k + near, 0}, b{2 * k + 1 - near, last};
        for (const Cell& c : {a, b})
          lay(across ? Cell{corner.x + c.z, corner.z + c.x} : Cell{corner.x + c.x, corner.z + c.z}, course, 2, across);
      }
    }
  }
  // A straight row, shifted by half a brick where its beginning and its end are half bricks.
  void row(Cell from, int bricks, int course, bool across, bool shifted) {
    const auto at = [&](int along) { return across ? Cell{from.x, from.z + along} : Cell{from.x + along, from.z}; };
    if (shifted) lay(at(0), course, 1, across);
    for (int k = 0; k < bricks - shifted; ++k) lay(at(2 * k + shifted), course, 2, across);
    if (shifted) lay(at(2 * bricks - 1), course, 1, across);
  }
};

constexpr int tower_bricks = 8, tower_courses = 6, keep_bricks = 14, keep_courses = 12;  // courses: more than the walls

}  // namespace

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
  const double walls = 4 * (courses * (2 * bricks + 1) + std::ceil(bricks / 2));
  const double towers = 4 * (4 * tower_bricks * (courses + tower_courses) + 2 * tower_bricks);
  return walls + towers + 4 * keep_bricks * (courses + keep_courses) + 2 * keep_bricks;
}

void add_castle(World<double>& world, const Kit& kit, int courses, int bricks) {
  const int tower = 2 * tower_bricks + 1, keep = 2 * keep_bricks + 1, side = 2 * bricks + 2 * tower;  // cells
  Mason mason{world, kit, side};
  const auto square = [&](Cell corner, int bricks, int courses) {
    for (int course = 0; course < courses; ++course) mason.ring(corner, bricks, course, 1);
    mason.ring(corner, bricks, courses, 2);
  };
  for (const int x : {0, side - tower})
    for (const int z : {0, side - tower}) square({x, z}, tower_bricks, courses + tower_courses);
  square({(side - keep) / 2, (side - keep) / 2}, keep_bricks, courses + keep_courses);

  const int out = tower / 2 - 1;  // how far in from the edge of the plan a wall's outer row is; the inner row is one farther in
  for (const bool across : {false, true})
    for (const bool far : {false, true}) {
      const auto row_at = [&](int in) { return far ? side - 1 - in : in; };
      const auto from = [&](int in) { return across ? Cell{row_at(in), tower} : Cell{tower, row_at(in)}; };
      for (int course = 0; course < courses; ++course)
        for (const int inner : {0, 1}) mason.row(from(out + inner), bricks, course, across, (course + inner) % 2 == 1);
      for (int k = 0; k < bricks; k += 2) {
        const Cell c = from(out);
        mason.lay(across ? Cell{c.x, c.z + 2 * k} : Cell{c.x + 2 * k, c.z}, courses, 2, across);
      }
    }
}

void add_dominoes(World<double>& world, const Kit& kit, int count) {
  for (int i = 0; i < count; ++i) add_body(world, kit, box_of(.1, .5, .25), {.5 * i, .5, 0});
}

void add_pit(World<double>& world, const Kit& kit, Assortment assortment, int count, int across, double from, std::uint64_t seed) {
  const bool with_boxes = assortment == Assortment::boxes || assortment == Assortment::mixed;
  const double spacing = with_boxes ? 1.7 : 1.65, jitter = with_boxes ? .1 : .05;
  // Eleven boxes across make half a width of 10 m, nine hulls one of 8 m, as in the pits that others measure.
  const double half_width = .5 * across * spacing + (with_boxes ? .65 : .575);
  constexpr double height = 40, thickness = 1;
  const auto fixed = [&](const Vector& offset) { begin_body(world, {kit.position + offset, no_rotation, 0}, {}, kit.surface); };
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

void add_soup(World<double>& world, const Kit& kit, Assortment assortment, int count, double overlapping, std::uint64_t seed) {
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
