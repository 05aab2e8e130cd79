// What resists the deformation of a cloth: links between two vertices, membranes, hinges.
//
// A link pulls two vertices along the line between them. The first links are the mesh's edges, in its order; behind
// them stand the far vertices of hinges, in the order of (from, to). An edge is a spring, or has a share of the
// quadratic bending, or both; the others have bending alone. Quadratic bending is a force that is linear in positions,
//
//   f_i = -sum over j of Q_ij x_j = sum over j of w_ij (x_j - x_i),   w_ij = -Q_ij,
//
// as rows of Q sum to 0: springs of length 0, of which some push. So springs and bending load the positions of a link
// once, and a shift of the whole cloth changes no bit where differences of positions are exact.
//
// Made once, by sequential code.
//
// Source: Bridson, Marino and Fedkiw 2003; Bergou, Wardetzky, Harmon, Zorin and Grinspun, A quadratic bending model for
//         inextensible surfaces, SGP 2006.
#pragma once

#include <algorithm>
#include <cstdint>

#include "common/blocked.h"
#include "common/production_cloth/cloth.h"
#include "common/production_cloth/element_forces.h"
#include "common/production_cloth/picks.h"

namespace lockstep::production_cloth {

// Lists of the vertices, sixteen vertices, a slice, side by side. Item k of vertex 16 s + l stands at
// [16 (first[s] + k) + l]. Lists of a slice are filled up to the longest of them.
struct Slices {
  Array<std::int32_t> first;  // [slice]; and the number of items behind the last
  Array<std::int32_t> at;     // a vertex, or a place; what fills up: the vertex itself, or the last place
};

template <class Real>
struct Elements {
  int vertices = 0;

  // Links: in their own order, and again vertex by vertex in slices, where what fills up is 0.
  bool has_springs = false, has_bending = false;
  int edges = 0, links = 0;                          // 0 with neither springs nor bending
  Array<std::int32_t> from, to;                      // [link]: from < to
  Array<Real> rest_length, spring, root_of_damping;  // [edge]: m; N/m; the root of N s/m
  Array<Real> bending;                               // [link]: w, N/m
  Real bend_damping = 0;                             // s, of w
  Slices edges_at, far_at;                           // the other vertex of each link, in the order of links
  Array<Real> spring_at;                             // [16 (3 item + field) + lane]: the three of an edge
  Array<Real> edge_bending_at, far_bending_at;       // [16 item + lane]: w

  // Membranes: the mesh's triangles. The last block is filled up with copies of the last one, in no vertex's list.
  int membranes = 0;
  bool corotated = false;                 // else St. Venant and Kirchhoff's
  Real lambda = 0, mu = 0;                // N/m, of plane stress
  Real membrane_damping = 0;              // s, of them
  Blocked<std::int32_t> membrane_corner;  // 3
  Blocked<Real> membrane;                 // 4: Membrane (element_forces.h)

  // Hinges: the mesh's, likewise.
  int hinges = 0;
  Real hinge_stiffness = 0;            // N m
  Blocked<std::int32_t> hinge_corner;  // 4
  Blocked<Real> hinge;                 // 2: sin(theta / 2) at rest; the root of the damping, in N m s

  // The triangles again, if there are hinges: what hinges do is found triangle by triangle. Side c is opposite to
  // corner c. Filled up likewise, with sides of no hinge. What a triangle has for a corner, or for the side opposite to
  // it, stands at place_of; behind all stands a 0.
  int facets = 0;
  Array<std::int32_t> facet_corner;  // [place]
  Array<std::int32_t> beside;        // [place] of a side: the place of the same side in the triangle beside, or its own
  Array<std::int32_t> facet_beside;  // [place]: the triangle of `beside`
  Blocked<std::int32_t> hinge_side;  // 2: the places of the side that is the hinge; the first is corner 0's triangle's
  Array<Real> rest_sine_at, root_of_damping_at;  // [place] of a side: the two of its hinge; 0 where there is none
  Slices corners_at;             // the places of each vertex's corners, of facets or membranes, in their order
  Array<std::int32_t> facet_at;  // the facet of each corner in corners_at; 0 of what fills up

  // What openmp picks from vectors of vertices, three a slice, whose component c of lane l of slice s stands at
  // 16 (3 s + c) + l: for edges_at and far_at, where the own slice comes first, and for the corners of blocks of facets
  // or membranes. And of numbers by place: for `beside`.
  Picks<1, 2> edge_picks, far_picks;
  Picks<3, 2> corner_picks;
  Picks<1, 3> beside_picks;

  static int place_of(int triangle, int c) { return (triangle / lanes * 3 + c) * lanes + triangle % lanes; }
  static int triangle_of(int place) { return place / (3 * lanes) * lanes + place % lanes; }
  int slices() const { return (vertices + lanes - 1) / lanes; }
  int membrane_corner_blocks() const { return (membranes + lanes - 1) / lanes; }
  int facet_blocks() const { return (facets + lanes - 1) / lanes; }
  int hinge_corner_blocks() const { return (hinges + lanes - 1) / lanes; }
  int last_place() const { return 3 * lanes * std::max(membrane_corner_blocks(), facet_blocks()); }
};

// rest: finite; triangles and edges not degenerate. Springs' rest lengths have the bits of the lengths that forces
// find at `rest`, so that there they pull by 0.
template <class Real>
Elements<Real> make_elements(const Topology& topology, const Vectors<double>& rest, const Material& material);

// What `forces` computes of the present shape for damping.
template <class Real>
struct State {
  // Of springs, the direction times root_of_damping: serial [3 edge + c], openmp [16 (3 item + c) + lane].
  Array<Real> along;
  Blocked<Real> deformation;        // 6: F by columns, of membranes
  Array<Facet<Real>> facets;        // serial: of each triangle
  Array<Real> normals, cotangents;  // openmp: of facets, normal and size, four numbers each; [place]: `at`
  Array<Real> resistance;           // [place] to a rate, of each side's hinge; 0 where there is none
  Array<Real> torque;               // serial's scratch: likewise, what the hinge resists with
  // openmp's scratch: positions by slices, three vectors each; the contrasts' positions, and membranes' parts, four
  // numbers each; [place].
  Array<Real> slices, records, parts, pushes;
};

// --- Shared by the two versions' make_state

template <class Real>
State<Real> make_state_of_blocks(const Elements<Real>& e) {
  State<Real> state;
  state.deformation = {6, e.membrane_corner_blocks()},
  state.resistance.resize(3 * lanes * static_cast<std::size_t>(e.facet_blocks()));
  return state;
}

}  // namespace lockstep::production_cloth
