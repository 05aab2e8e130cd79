// The distance of two convex cores, by the algorithm of Gilbert, Johnson and Keerthi.
//
// The corners b - a, over all vertices a and b of the two cores, span their difference; its point v nearest to the
// origin is the shortest way from a to b. Of up to three corners that v lies between, whatever is nearer is beyond the
// plane through v across v. So the corner farthest that way, towards the origin, is found, and v moves to the nearest
// point between it and the three; at most three of the four are needed for that, unless they enclose the origin: then
// the cores overlap. Where no corner is farther, v is the answer.
//
// Which point is nearest is not decided by signs that tell the regions of space around a simplex apart (Johnson;
// Ericson): near a flat or needle-like one rounding makes them contradict each other. All edges and faces at the newest
// corner, at most six, put forward the nearest point of their own, and the least far from the origin wins. Rounding may
// make it a poor choice but never one that is not of the difference: the distance is never too small. The edges and
// faces between older corners need no test: v was the nearest there, and the newest corner is beyond it. The next
// direction of the support mapping is the normal of the edge or face that won: the point itself, where it is near the
// origin, has lost its direction to rounding, and corners already known would seem to be farther.
//
// Source: as in the contract, common/rigid/gjk.h; the choice by value is ours.
#include "common/rigid/gjk.h"

#include <limits>

#include "common/math.h"
#include "common/real.h"
#include "common/rigid/gjk_cores.h"
#include "common/rigid/simplex.h"

namespace lockstep::rigid::serial {
namespace {

// But for rounding every step comes nearer, so that no simplex comes twice: a million pairs of the test's worst kinds
// take up to 18. Five of these have corners that are in one plane but for rounding, and go round in circles: every turn
// is as good an answer.
constexpr int most_iterations = 32;
constexpr Real epsilon = std::numeric_limits<Real>::epsilon();

// The formulas' types, for one pair.
using Number = Real;
using Index = int;
using Vector = Vector3<Number>;

using Vertices = std::span<const Quad<Real>>;

// The vertex farthest along a direction; the first of equals.
int support(Vertices vertices, const Vector& direction) {
  int farthest = 0;
  Number most = dot(direction, vector_of(vertices[0]));
  for (int k = 1; k < static_cast<int>(vertices.size()); ++k) {
    const Number along = dot(direction, vector_of(vertices[k]));
    if (along > most) most = along, farthest = k;
  }
  return farthest;
}

struct Corner {
  int a, b;         // of which vertices
  Vector position;  // b - a, in a's frame
};

// Two hulls, and how they stand.
struct Problem {
  Vertices a, b;
  Cores<Number> cores;

  Corner corner(int k, int l) const {
    return {k, l, vertex_of_b(cores, vector_of(b[l])) - vertex_of_a(cores, vector_of(a[k]))};
  }
  // The one farthest against v, in a's frame.
  Corner farthest(const Vector& v) const {
    return corner(support(a, direction_in_a(cores, v)), support(b, direction_in_b(cores, -v)));
  }
};

Problem make_problem(const Placed<Real>& placed, const Pair& pair) {
  const Colliders<Real>& colliders = placed.colliders;
  const Hulls<Real>& hulls = placed.hulls;
  const auto vertices = [&](int hull) {
    return Vertices(&hulls.vertex[hulls.first_vertex[hull]], hulls.vertices(hull));
  };
  const Pose<Real>&a = placed.pose[pair.a], &b = placed.pose[pair.b];
  return {vertices(colliders.hull[pair.a]), vertices(colliders.hull[pair.b]),
          make_cores(vector_of(colliders.size[pair.a]), vector_of(colliders.size[pair.b]), a.position, b.position,
                     a.orientation, b.orientation)};
}

// From the middle of a to that of b, in a's frame.
Vector between_centres(const Placed<Real>& placed, const Pair& pair, const Cores<Number>& cores) {
  const auto centre = [&](int collider) { return vector_of(placed.hulls.centre[placed.colliders.hull[collider]]); };
  return vertex_of_b(cores, centre(pair.b)) - vertex_of_a(cores, centre(pair.a));
}

// The corners that the nearest point to the origin lies between, the newest first, and their weights: up to three, or
// four around the origin.
struct State {
  int count;
  Corner corner[4];
  Number weight[4];
  Vector nearest;
  Number distance_2;  // 0 where the cores overlap
};

// Which of the other corners stay when a new corner comes: j and k, or all if the count is 4.
struct Choice {
  int count, j, k;
  Number r, s, t;  // weights of the corners after the newest
  Vector nearest;
  Number distance_2;
  Number longest_2;  // of the edges from the newest corner that were tried
};

// The nearest point on the edges and faces from `newest` to the other corners, of which there are up to three.
Choice nearest(const Corner& newest, const Corner* others, int count) {
  const Vector& p = newest.position;
  int edges = 0, j = 0, k = 0;  // how many edges from newest the best lies on, or between, and to which of the others
  Candidate<Number> best = {true, 0, 0, dot(p, p), p};
  const auto consider = [&](const Candidate<Number>& candidate, int bounds, int l, int m) {
    if (candidate.inside && candidate.distance_2 < best.distance_2) best = candidate, edges = bounds, j = l, k = m;
  };

  Edge<Number> e[3];
  Number longest_2 = 0;
  for (int l = 0; l < count; ++l) {
    e[l] = make_edge(p, others[l].position);
    longest_2 = max(longest_2, e[l].length_2);
    consider(nearest_on_edge(p, e[l]), 1, l, l);
  }
  const auto face = [&](int l, int m) {
    const Candidate<Number> face = nearest_on_face(p, e[l], e[m]);
    consider(face, 2, l, m);
    return face.normal;
  };
  if (count >= 2) {
    const Vector n_01 = face(0, 1);
    if (count == 3) {
      const Vector n_02 = face(0, 2), n_12 = face(1, 2);
      const Enclosure<Number> around = enclosure(p, e[0].along, n_01, n_02, n_12);
      if (around.inside) return {4, 0, 1, around.r, around.s, around.t, {0, 0, 0}, 0, longest_2};
    }
  }

  // A point newest + s e + t f carries rounding of an epsilon or two of its longest term. What is nearer than that is
  // at the origin.
  const Number normal_2 = dot(best.normal, best.normal);
  const bool away = best.distance_2 > 16 * epsilon * epsilon * longest_2 && normal_2 > 0;
  const Vector v = (dot(p, best.normal) / normal_2) * best.normal, zero = {0, 0, 0};
  return {edges + 1, j, k, best.s, best.t, 0, away ? v : zero, away ? best.distance_2 : 0, longest_2};
}

// `newest` takes its place before the corners that stay.
void take(const Corner& newest, const Choice& choice, State& state) {
  const Corner first = state.corner[choice.j], second = state.corner[choice.k];
  state.corner[3] = state.corner[2];
  state.corner[2] = second;
  state.corner[1] = first;
  state.corner[0] = newest;
  state.count = choice.count;
  state.weight[1] = choice.r, state.weight[2] = choice.s, state.weight[3] = choice.t;
  state.weight[0] = 1 - (choice.r + choice.s + choice.t);
  state.nearest = choice.nearest;
  state.distance_2 = choice.distance_2;
}

// Whether the simplex has this corner already.
bool is_known(const Corner& corner, const State& state) {
  bool known = false;
  for (int k = 0; k < state.count; ++k) known |= corner.a == state.corner[k].a && corner.b == state.corner[k].b;
  return known;
}

// The first simplex: a warm start takes the corners of the last step's simplex, at their new positions. Without any (a
// cold start), the support mapping along the line between the centres gives the first one, which counts as an
// iteration.
State start(const Problem& problem, const Vector& from_centre_to_centre, const Simplex& known, Index& iterations) {
  const auto corner = [&](int k) { return problem.corner(known.a[k], known.b[k]); };
  iterations = known.count == 0;
  State state{};
  const Corner newest = known.count == 0 ? problem.farthest(from_centre_to_centre) : corner(0);
  for (int k = 1; k < known.count; ++k) state.corner[k - 1] = corner(k);
  take(newest, nearest(newest, state.corner, known.count - 1), state);
  return state;
}

// Iterates until no corner is nearer.
void walk(const Problem& problem, State& state, Index& iterations) {
  while (state.distance_2 > 0 && iterations < most_iterations) {
    ++iterations;
    const Corner newest = problem.farthest(state.nearest);
    // Ends unless the new corner is beyond the simplex by more than the rounding of a step across: some epsilon of its
    // length.
    const Vector &v = state.nearest, step = state.corner[0].position - newest.position;
    const Number beyond = dot(v, step);
    if (!(beyond > 0 && beyond * beyond > 4 * epsilon * epsilon * (dot(v, v) * dot(step, step)))) break;
    // The corner must be new, and the point not farther by more than its rounding: some epsilon of its terms. Where GJK
    // cannot come nearer although there are corners beyond, its point is at the origin or, as around a needle, a little
    // away from it: the cores overlap.
    const Choice next = nearest(newest, state.corner, state.count);
    const Number farther = next.distance_2 - state.distance_2;
    if (is_known(newest, state) ||
        (farther > 0 &&
         farther * farther > 16 * epsilon * epsilon * (state.distance_2 * (state.distance_2 + next.longest_2)))) {
      if (state.distance_2 <= 32 * 32 * epsilon * epsilon * next.longest_2)
        state.nearest = {0, 0, 0}, state.distance_2 = 0;
      break;
    }
    take(newest, next, state);
  }
}

// The result of the iterations, and the simplex for the next step's warm start.
Closest<Real> finish(const Problem& problem, const State& state, Index iterations, Simplex& known) {
  const Cores<Number>& cores = problem.cores;
  Vector on_a = {0, 0, 0};
  known = {state.count, {}, {}};
  for (int k = 0; k < state.count; ++k) {
    const auto& [a, b, unused] = state.corner[k];
    on_a = on_a + state.weight[k] * vertex_of_a(cores, vector_of(problem.a[a]));
    known.a[k] = static_cast<std::uint8_t>(a), known.b[k] = static_cast<std::uint8_t>(b);
  }
  const Vector& v = state.nearest;
  const Number stretch = state.distance_2 > 0 ? sqrt(state.distance_2 / dot(v, v)) : 0;  // 1 but for rounding
  return {in_world(cores, on_a), in_world(cores, on_a + stretch * v), sqrt(state.distance_2), iterations};
}

}  // namespace

void gjk(const Placed<Real>& placed, std::span<const Pair> pairs, std::span<Simplex> simplex,
         std::span<Closest<Real>> closest) {
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const Problem problem = make_problem(placed, pairs[k]);
    Index iterations;
    State state = start(problem, between_centres(placed, pairs[k], problem.cores), simplex[k], iterations);
    walk(problem, state, iterations);
    closest[k] = finish(problem, state, iterations, simplex[k]);
  }
}

}  // namespace lockstep::rigid::serial
