// The distance of two convex cores, by the algorithm of Gilbert, Johnson and Keerthi, as serial/rigid/gjk.cpp has it:
// what the difference of two cores is, how the walk goes on, and why the nearest point is chosen by value, is written
// there.
//
// Sixteen pairs at a time, a pair a lane. All edges and faces of a simplex put forward their nearest points in any
// case, so that lanes do not diverge; corners that a lane does not have repeat others, which never win. The vertices
// of sixteen hulls are brought side by side once: then the support mapping is a loop over whole vectors, with one
// compare and one select a vertex.
//
// Pairs take from 2 to 16 iterations, and lanes that are done wait for the others: among sixteen pairs of hulls, a
// third of the iterations would be idle. So when few lanes are left, a block ends; what is left of a chunk is packed
// into full blocks again, which go on from the simplex at which each pair stands. Within a chunk, pairs are first put
// in order of how many vertices they have, so that a block's hulls are about as large. As each pair takes the same
// steps in any company, the result has the same bits.
//
// Source: as in the contract, common/rigid/gjk.h; bringing records side by side: [LRB08] Figure 12. Packing again what
//         is left is ours.
#include "common/rigid/gjk.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>

#include "common/math.h"
#include "common/real.h"
#include "common/rigid/gjk_cores.h"
#include "common/rigid/simplex.h"
#include "common/simd.h"
#include "openmp/rigid/chunks.h"
#include "openmp/rigid/full_blocks.h"
#include "openmp/rigid/hull_lanes.h"
#include "openmp/rigid/hull_vertices.h"
#include "openmp/rigid/lanes.h"

namespace lockstep::rigid::openmp {
namespace {

constexpr int most_iterations = 32;  // why: serial/rigid/gjk.cpp
constexpr Real epsilon = std::numeric_limits<Real>::epsilon();

// The formulas' types, for sixteen pairs.
using Number = floatv;
using Mask = maskv;
using Index = intv;
using Vector = Vector3<Number>;

// quad[index] in each lane. Without the empty assembly, which may change the indices for all that g++ knows, it would
// not read them back from memory but take the vector apart in registers: two moves a lane, some on the ports that turn
// records round, and 5 % of the time.
LOCKSTEP_INLINE Vector position(const Array<Quad<Real>>& quad, Index index) {
  Indices indices = indices_of(index);
  asm("" : "+m"(indices));
  return vector_of(load_quad(quad, indices));
}

struct Corner {
  Index vertices;   // of which: a's, and 256 times b's
  Vector position;  // b - a, in a's frame

  LOCKSTEP_INLINE Index a() const { return vertices & 255; }
  LOCKSTEP_INLINE Index b() const { return vertices >> 8; }
};

LOCKSTEP_INLINE Corner select(Mask mask, const Corner& c, const Corner& d) {
  return {select(mask, c.vertices, d.vertices), select(mask, c.position, d.position)};
}

// Pairs of hulls, and how they stand.
struct Problem {
  const Hulls<Real>* hulls;
  Indices hull_a, hull_b;
  Vertices a, b;
  Cores<Number> cores;

  LOCKSTEP_INLINE Corner corner(Index k, Index l) const {
    return {k | l << 8, vertex_of_b(cores, position(hulls->vertex, b.first + l)) -
                            vertex_of_a(cores, position(hulls->vertex, a.first + k))};
  }
  // The one farthest against v, in a's frame.
  LOCKSTEP_INLINE Corner farthest(const Vector& v) const {
    return corner(support(a, direction_in_a(cores, v)), support(b, direction_in_b(cores, -v)));
  }
};

// One by one: a gather takes as many accesses, and in lanes the hulls would only be taken apart again.
LOCKSTEP_INLINE Indices hulls_of(const Colliders<Real>& colliders, const Indices& collider) {
  Indices hull;
  for (int l = 0; l < lanes; ++l) hull.index[l] = colliders.hull[collider.index[l]];
  return hull;
}

LOCKSTEP_INLINE void make_problem(const Placed<Real>& placed, const PairLanes& pairs, Problem& problem) {
  const auto& [colliders, hulls, unused] = placed;
  problem.hulls = &hulls;
  problem.hull_a = hulls_of(colliders, pairs.a), problem.hull_b = hulls_of(colliders, pairs.b);
  load_vertices(hulls, problem.hull_a, problem.a);
  load_vertices(hulls, problem.hull_b, problem.b);
  problem.cores = load_cores(placed, pairs);
}

// From the middle of a to that of b, in a's frame.
LOCKSTEP_INLINE Vector between_centres(const Problem& problem) {
  const auto centre = [&](const Indices& hull) { return vector_of(load_quad(problem.hulls->centre, hull)); };
  return vertex_of_b(problem.cores, centre(problem.hull_b)) - vertex_of_a(problem.cores, centre(problem.hull_a));
}

// The corners that the nearest point to the origin lies between, the newest first, and their weights: up to three, or
// four around the origin. Unused corners repeat others, so that the count of a lane does not matter.
struct State {
  Index count;
  Corner corner[4];
  Number weight[4];  // of the first, what the others leave
  Vector nearest;
  Number distance_2;  // 0 where the cores overlap
};

// Which of the other corners stay when a new corner comes: j and k, or all if the count is 4.
struct Choice {
  Index count, j, k;
  Number r, s, t;  // weights of the corners after the newest
  Vector nearest;
  Number distance_2;
  Number longest_2;  // of the edges from the newest corner that were tried
};

// The nearest point on the edges and faces from `newest` to the other corners, of which there are up to three.
LOCKSTEP_INLINE Choice nearest(const Corner& newest, const Corner* others, Index count) {
  const Vector& p = newest.position;
  // How many edges from newest the best lies on, or between, and to which of the others: 3 is newest itself.
  Index edges = 0, j = 3, k = 3;
  Candidate<Number> best = {first_lanes(lanes), 0.f, 0.f, dot(p, p), p};
  const auto consider = [&](const Candidate<Number>& candidate, int bounds, int l, int m) {
    const Mask better = candidate.inside & (candidate.distance_2 < best.distance_2);
    where(better, edges) = bounds, where(better, j) = l, where(better, k) = m;
    where(better, best.s) = candidate.s, where(better, best.t) = candidate.t;
    where(better, best.distance_2) = candidate.distance_2;
    best.normal = select(better, candidate.normal, best.normal);
  };

  Edge<Number> e[3];
  Number longest_2 = 0.f;
  for (int l = 0; l < 3 && any(count > l); ++l) {
    e[l] = make_edge(p, others[l].position);
    longest_2 = max(longest_2, e[l].length_2);
    consider(nearest_on_edge(p, e[l]), 1, l, l);
  }
  const auto face = [&](int l, int m) {
    const Candidate<Number> face = nearest_on_face(p, e[l], e[m]);
    consider(face, 2, l, m);
    return face.normal;
  };
  Enclosure<Number> around = {first_lanes(0), 0.f, 0.f, 0.f};
  if (any(count >= 2)) {
    const Vector n_01 = face(0, 1);
    if (any(count == 3)) {
      const Vector n_02 = face(0, 2), n_12 = face(1, 2);
      around = enclosure(p, e[0].along, n_01, n_02, n_12);
    }
  }
  const Mask enclosed = around.inside & (count == 3);

  // A point newest + s e + t f carries rounding of an epsilon or two of its longest term. What is nearer than that is
  // at the origin.
  const Number normal_2 = dot(best.normal, best.normal);
  const Mask away = (best.distance_2 > 16 * epsilon * epsilon * longest_2) & (normal_2 > 0.f) & ~enclosed;
  const Vector v = (dot(p, best.normal) / normal_2) * best.normal, zero = {0.f, 0.f, 0.f};
  return {select(enclosed, Index(4), edges + 1),
          select(enclosed, Index(0), j),
          select(enclosed, Index(1), k),
          select(enclosed, around.r, best.s),
          select(enclosed, around.s, best.t),
          select(enclosed, around.t, 0.f),
          select(away, v, zero),
          select(away, best.distance_2, 0.f),
          longest_2};
}

// `newest` takes its place before the corners that stay.
LOCKSTEP_INLINE void take(Mask mask, const Corner& newest, const Choice& choice, State& state) {
  // Where the mask is not active, 1 and 2 stay what they are.
  const auto stays = [&](Index l) {
    return select(l == 0, state.corner[0], select(l == 1, state.corner[1], select(l == 2, state.corner[2], newest)));
  };
  const Corner first = stays(select(mask, choice.j, 1)), second = stays(select(mask, choice.k, 2));
  state.corner[3] = select(mask, state.corner[2], state.corner[3]);
  state.corner[2] = second;
  state.corner[1] = first;
  state.corner[0] = select(mask, newest, state.corner[0]);
  where(mask, state.count) = choice.count;
  where(mask, state.weight[1]) = choice.r, where(mask, state.weight[2]) = choice.s,
              where(mask, state.weight[3]) = choice.t;
  state.nearest = select(mask, choice.nearest, state.nearest);
  where(mask, state.distance_2) = choice.distance_2;
}

// Whether the simplex has this corner already.
LOCKSTEP_INLINE Mask is_known(const Corner& corner, const State& state) {
  Mask known = first_lanes(0);
  for (int k = 0; k < 3; ++k) known |= corner.vertices == state.corner[k].vertices;
  return known;
}

// Sixteen simplices: vertex k of a corner is byte k of a word.
struct Known {
  Index count, a, b;
};

LOCKSTEP_INLINE Known load_known(std::span<const Simplex> simplex, std::span<const std::int32_t> which) {
  Indices word[3] = {};
  for (std::size_t l = 0; l < which.size(); ++l) {
    const auto words = std::bit_cast<std::array<std::int32_t, 3>>(simplex[which[l]]);
    for (int f = 0; f < 3; ++f) word[f].index[l] = words[f];
  }
  return {load(word[0].index), load(word[1].index), load(word[2].index)};
}

LOCKSTEP_INLINE void store_known(const Known& known, std::span<Simplex> simplex, std::span<const std::int32_t> which) {
  Indices word[3];
  store(word[0].index, known.count), store(word[1].index, known.a), store(word[2].index, known.b);
  for (std::size_t l = 0; l < which.size(); ++l)
    simplex[which[l]] = std::bit_cast<Simplex>(std::array{word[0].index[l], word[1].index[l], word[2].index[l]});
}

// The first simplex: a warm start takes the corners of the last step's simplex, at their new positions. Without any (a
// cold start), the support mapping along the line between the centres gives the first one, which counts as an
// iteration.
LOCKSTEP_INLINE State start(const Problem& problem, const Known& known, Index& iterations) {
  const auto corner = [&](int k) {
    return problem.corner(select(known.count > k, (known.a >> 8 * k) & 255, 0),
                          select(known.count > k, (known.b >> 8 * k) & 255, 0));
  };
  const Mask cold = known.count == 0;
  where(cold, iterations) = 1;
  State state;
  Corner newest;
  if (!all(cold)) newest = corner(0);
  if (any(cold)) newest = select(cold, problem.farthest(between_centres(problem)), newest);
  for (int k = 1; k < 4; ++k) {
    const Corner& last = k == 1 ? newest : state.corner[k - 2];
    state.corner[k - 1] = any(known.count > k) ? select(known.count > k, corner(k), last) : last;
  }
  take(first_lanes(lanes), newest, nearest(newest, state.corner, known.count - 1), state);
  return state;
}

// Iterates until no more than `enough` lanes are active; returns these.
LOCKSTEP_INLINE Mask walk(const Problem& problem, int enough, State& state, Index& iterations, Mask active) {
  while (count(active) > enough) {
    where(active, iterations) += 1;
    const Corner newest = problem.farthest(state.nearest);
    // Ends unless the new corner is beyond the simplex by more than the rounding of a step across: some epsilon of its
    // length.
    const Vector& v = state.nearest;
    const Vector step = state.corner[0].position - newest.position;
    const Number beyond = dot(v, step);
    active &= (beyond > 0.f) & (beyond * beyond > 4 * epsilon * epsilon * (dot(v, v) * dot(step, step)));
    // The corner must be new, and the point not farther by more than its rounding: some epsilon of its terms. Where GJK
    // cannot come nearer although there are corners beyond, its point is at the origin or, as around a needle, a little
    // away from it: the cores overlap.
    const Choice next = nearest(newest, state.corner, state.count);
    const Number farther = next.distance_2 - state.distance_2;
    const Mask stuck =
        active &
        (is_known(newest, state) |
         ((farther > 0.f) &
          (farther * farther > 16 * epsilon * epsilon * (state.distance_2 * (state.distance_2 + next.longest_2)))));
    const Mask there = stuck & (state.distance_2 <= 32 * 32 * epsilon * epsilon * next.longest_2);
    state.nearest = select(there, {0.f, 0.f, 0.f}, state.nearest);
    where(there, state.distance_2) = 0.f;
    active &= ~stuck;
    take(active, newest, next, state);
    active &= (state.distance_2 > 0.f) & (iterations < most_iterations);
  }
  return active;
}

// Writes the result of the iterations into `closest` and `simplex`.
LOCKSTEP_INLINE void finish(const Problem& problem, State& state, Index iterations, std::span<const std::int32_t> which,
                            std::span<Simplex> simplex, std::span<Closest<Real>> closest) {
  const Cores<Number>& cores = problem.cores;
  Vector on_a = {0.f, 0.f, 0.f};
  state.weight[0] = 1.f - (state.weight[1] + state.weight[2] + state.weight[3]);
  Known out = {state.count, 0, 0};
  for (int k = 0; k < 4 && any(state.count > k); ++k) {
    const Index a = state.corner[k].a(), b = state.corner[k].b();
    const Mask there = state.count > k;
    on_a = select(
        there, on_a + state.weight[k] * vertex_of_a(cores, position(problem.hulls->vertex, problem.a.first + a)), on_a);
    where(there, out.a) |= a << 8 * k;
    where(there, out.b) |= b << 8 * k;
  }
  const Vector& v = state.nearest;
  const Number stretch = select(state.distance_2 > 0.f, sqrt(state.distance_2 / dot(v, v)), 0.f);  // 1 but for rounding
  const Vector from = in_world(cores, on_a), to = in_world(cores, on_a + stretch * v);
  alignas(array_alignment) Closest<Real> result[lanes];
  store_records(&result->on_a.x, sixteen(0).index,
                {{from.x, from.y, from.z, to.x, to.y, to.z, sqrt(state.distance_2), float_of_bits(iterations)}});
  for (std::size_t l = 0; l < which.size(); ++l) closest[which[l]] = result[l];
  store_known(out, simplex, which);
}

// Up to sixteen pairs, until no more than `enough` are left; those are put to the front of `which`. Returns how many.
int gjk_of_block(const Placed<Real>& placed, std::span<const Pair> pairs, std::span<std::int32_t> which, int enough,
                 std::span<Simplex> simplex, std::span<Closest<Real>> closest) {
  const int in_use = static_cast<int>(which.size());
  PairLanes pair;
  Indices before;
  for (int l = 0; l < lanes; ++l) {
    const int k = which[l < in_use ? l : 0];
    pair.a.index[l] = pairs[k].a, pair.b.index[l] = pairs[k].b;
    before.index[l] = closest[k].iterations;
  }
  Problem problem;
  make_problem(placed, pair, problem);
  Index iterations = load(before.index);
  State state = start(problem, load_known(simplex, which), iterations);
  const Mask active = walk(problem, enough, state, iterations, first_lanes(in_use) & (state.distance_2 > 0.f));
  finish(problem, state, iterations, which, simplex, closest);
  int left = 0;
  for (std::uint32_t set = bits(active); set != 0; set &= set - 1) which[left++] = which[std::countr_zero(set)];
  return left;
}

// The pairs of a chunk, by how many vertices they have, in fours, which is how they are loaded.
void gjk_of_chunk(const Placed<Real>& placed, std::span<const Pair> pairs, std::span<Simplex> simplex,
                  std::span<Closest<Real>> closest) {
  const int n = static_cast<int>(pairs.size());
  for (int k = 0; k < n; ++k) closest[k].iterations = 0;
  in_full_blocks(
      n, [&](int k) { return size_key(placed, pairs[k]); },
      [&](std::span<std::int32_t> which, int enough) {
        return gjk_of_block(placed, pairs, which, enough, simplex, closest);
      });
}

}  // namespace

void gjk(const Placed<Real>& placed, std::span<const Pair> pairs, std::span<Simplex> simplex,
         std::span<Closest<Real>> closest) {
  const std::size_t size = chunk_of(pairs.size(), chunk_size), chunks = (pairs.size() + size - 1) / size;
  // A chunk reads and writes what belongs to its own pairs alone. Chunks differ in work, hence dynamic.
#pragma omp parallel for schedule(dynamic)
  for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
    const std::size_t first = chunk * size, count = std::min(size, pairs.size() - first);
    gjk_of_chunk(placed, pairs.subspan(first, count), simplex.subspan(first, count), closest.subspan(first, count));
  }
}

}  // namespace lockstep::rigid::openmp
