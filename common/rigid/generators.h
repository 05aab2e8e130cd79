// Makes many bodies by rule: the piles and walls that engines are measured on, and random ones.
//
// Random numbers come from a generator of our own, and from additions, products and square roots (the size of a soup
// alone from a logarithm), so a seed means the same bodies on every machine. For each rule there is a function that
// counts the bodies it adds, as a double, which cannot overflow.
#pragma once

#include <cstdint>

#include "common/rigid/make.h"

namespace lockstep::rigid {

// Parameters that all bodies of a rule share.
struct Kit {
  Vector3<double> position;  // m: the middle of the ground they stand on
  double mass;               // kg, of each body (of a castle: of a whole brick)
  Surface surface;
};

// Cubes of side 1 m, 1.05 m apart, in `layers` square layers: of layers, layers - 1, ..., 1 cubes along each side.
void add_pyramid(World<double>& world, const Kit& kit, int layers);
double pyramid_bodies(double layers);

// Boxes, stacked.
void add_stack(World<double>& world, const Kit& kit, int count, const Vector3<double>& half);

// A wall along x, one brick thick: half sizes .5 .25 .25 m, 1.02 m apart, every other course shifted by half of that.
void add_wall(World<double>& world, const Kit& kit, int courses, int bricks);

// A castle of bricks as above. Its four walls are two bricks thick in English bond and `bricks` long. They stand
// between four square towers, one brick thick, of eight bricks a side and five courses higher. In the middle is a keep
// as thick as the walls, 8 m wide and fourteen courses higher. On top is every other brick of one more course. 10,000
// bricks where bricks = 42 and courses = 16, on a square of 60 m.
void add_castle(World<double>& world, const Kit& kit, int courses, int bricks);
double castle_bodies(double courses, double bricks);

// Slabs of half sizes .1 .5 .25 m, .5 m apart along x, the first at the position.
void add_dominoes(World<double>& world, const Kit& kit, int count);

// Shapes to take in turn, by kind of which there are some:
//   boxes   of half sizes (.5 .5 .5), (.3 .5 .7), (.4 .4 .4), (.6 .3 .4) m
//   rounds  spheres of radius .5 and .35 m, capsules of half .4 and .2 m, radius .3 and .4 m
//   hulls   64 hulls, of 12 to 24 points each, .1 m apart or more, on ellipsoids of half axes from .45 to .75 m
//   mixed   a box, a round, a hull, in turn
enum class Assortment { boxes, rounds, hulls, mixed };
// An upper bound of the triangles of its hulls' faces on one side, for the memory they need (making_bytes,
// common/rigid/scene.h).
double assortment_triangles(Assortment assortment);

// Bodies dropped into a pit, turned at random, in layers of across x across. Boxes and mixed bodies are 1.7 m apart and
// displaced by up to .1 m; rounds and hulls are 1.65 m apart and displaced by up to .05 m. The pit has a plane for a
// floor and four boxes, 40 m high, for walls, where the layers end. The lowest layer is at height `from`, m.
void add_pit(World<double>& world, const Kit& kit, Assortment assortment, int count, int across, double from,
             std::uint64_t seed);
inline constexpr int pit_walls = 5;  // static bodies of a pit: floor and walls

// Bodies anywhere in a cube, turned at random. They are so dense that a body away from the border overlaps another with
// the probability `overlapping`, 0 .. 1. With n bodies in a unit volume, no body overlaps a given one with the
// probability exp(-n E). E is the volume in which the other's centre may be: V1 + V2 + (A1 M2 + A2 M1) / (4 pi) for
// convex bodies turned at random, of volume V, area A and integral of mean curvature M (Isihara, J. Chem. Phys. 18,
// 1950). The position is the middle of the cube.
void add_soup(World<double>& world, const Kit& kit, Assortment assortment, int count, double overlapping,
              std::uint64_t seed);

}  // namespace lockstep::rigid
