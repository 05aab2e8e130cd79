// The damping of a cloth, implicit, by conjugate gradients.
//
// The algorithm stands in serial/production_cloth/damping_solve.cpp. In a product, as in `forces`, a vertex goes
// through its links itself, and adds up what membranes and folding triangles have stored, in the order of the elements:
// the serial bits. Sixteen vertices at once.
//
// All iterations are one parallel region, in which every thread carries the same scalars along. An iteration waits
// three times: for A p and p . A p; for the residual and its two sums; for the next direction. Where the cloth has
// membranes it waits for their parts, too, and with hinges for rates and parts. Sums are of blocks of vertices, in the
// order of linear/'s dot product, and each thread adds up all blocks itself.
//
// The first product of a solve keeps the triangles' normals, by blocks and again in the order of vertices. The others
// read them from there.
//
// Vectors are three arrays of lanes a slice. Neighbours are picked from the slices that they stand in.
//
// The contract stands in common/production_cloth/damping_solve.h.
#include "common/production_cloth/damping_solve.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "common/linear/dot.h"
#include "common/real.h"
#include "openmp/production_cloth/facets.h"
#include "openmp/production_cloth/picks.h"
#include "openmp/production_cloth/slice_sums.h"

namespace lockstep::production_cloth::openmp {
namespace {

LOCKSTEP_INLINE Vector3<floatv> record(std::span<const Real> x, int slice) {
  const Real* const at = &x[lanes * slice_vectors * static_cast<std::size_t>(slice)];
  return {load(at), load(at + lanes), load(at + 2 * lanes)};
}
LOCKSTEP_INLINE void set(std::span<Real> x, int slice, const Vector3<floatv>& value) {
  Real* const at = &x[lanes * slice_vectors * static_cast<std::size_t>(slice)];
  store(at, value.x), store(at + lanes, value.y), store(at + 2 * lanes, value.z);
}
LOCKSTEP_INLINE Vector3<floatv> of_records(const Array<Real>& records, int slice) {
  return load_sixteen(&records[4 * lanes * static_cast<std::size_t>(slice)]);
}

// Vectors that D is multiplied by, and -D times them in a slice.
template <std::size_t count>
using Inputs = std::array<std::span<const Real>, count>;
template <std::size_t count>
using Pulls = std::array<Vector3<floatv>, count>;

template <class Springs, class Bending, std::size_t count>
LOCKSTEP_INLINE Pulls<count> add_links(const Elements<Real>& elements, const State<Real>& state, const Inputs<count>& v,
                                       int slice) {
  const floatv bend_damping = elements.bend_damping;
  Pulls<count> own, sum;
  for (std::size_t p = 0; p < count; ++p) own[p] = record(v[p], slice), sum[p] = {0.f, 0.f, 0.f};
  for (std::size_t k = elements.edges_at.first[slice]; k < std::size_t(elements.edges_at.first[slice + 1]); ++k)
    for (std::size_t p = 0; p < count; ++p) {
      const Vector3<floatv> d = pick_vectors(elements.edge_picks, k, v[p].data(), own[p])[0] - own[p];
      Vector3<floatv> part = {0.f, 0.f, 0.f};
      if constexpr (Bending::value) part = (bend_damping * load(&elements.edge_bending_at[lanes * k])) * d;
      if constexpr (Springs::value) {
        const Real* const along = &state.along[3 * lanes * k];
        const Vector3<floatv> of_spring =
            damping_of_spring({load(along), load(along + lanes), load(along + 2 * lanes)}, d);
        part = Bending::value ? part + of_spring : of_spring;  // 0 + it is no other sum
      }
      sum[p] = sum[p] + part;
    }
  if constexpr (Bending::value)
    for (std::size_t k = elements.far_at.first[slice]; k < std::size_t(elements.far_at.first[slice + 1]); ++k)
      for (std::size_t p = 0; p < count; ++p)
        sum[p] = sum[p] + (bend_damping * load(&elements.far_bending_at[lanes * k])) *
                              (pick_vectors(elements.far_picks, k, v[p].data(), own[p])[0] - own[p]);
  return sum;
}

// The parts of membranes. A team calls it.
template <std::size_t count>
void store_membranes(const Elements<Real>& elements, const State<Real>& state, const Inputs<count>& v,
                     DampingRoom& room) {
  // A block writes its own parts.
#pragma omp for schedule(static) nowait
  for (int block = 0; block < elements.membrane_corner_blocks(); ++block) {
    const auto field = [&](const Blocked<Real>& array, int k) { return load(array.vector(block, k)); };
    const Membrane<floatv> membrane = membrane_of<floatv>(elements, field);
    const Columns<floatv> f = {load_fields(state.deformation, block, 0), load_fields(state.deformation, block, 3)};
    for (std::size_t p = 0; p < count; ++p) {
      const auto x = pick_corners(elements, v[p].data(), block);
      store_parts(damping_of_membrane<floatv>(elements, membrane, f, x[0], x[1], x[2]),
                  &room.membrane_parts[p][membrane_parts(block)]);
    }
  }
}

// What the hinges of triangles push their corners with, along the normals. A team calls it.
template <bool is_first, std::size_t count>
void store_pushes(const Elements<Real>& elements, const State<Real>& state, const Inputs<count>& v,
                  std::span<Array<Real>> rates, DampingRoom& room) {
  // A block writes its own rates.
#pragma omp for schedule(static)
  for (int block = 0; block < elements.facet_blocks(); ++block) {
    const auto at = [&](int c) { return load(&state.cotangents[corner_place(block, c)]); };
    const floatv cotangents[] = {at(0), at(1), at(2)};
    Real* const kept = &room.facet_normals[corner_place(block, 0)];
    if constexpr (is_first) store_three(kept, load_sixteen(&state.normals[facet_records(block)]));
    const Vector3<floatv> normal = load_three(kept);
    for (std::size_t p = 0; p < count; ++p) {
      const auto x = pick_corners(elements, v[p].data(), block);
      const Sides<floatv> rate = rates_of_facet(normal, cotangents, x[0], x[1], x[2]);
      for (int c = 0; c < 3; ++c) store(&rates[p][corner_place(block, c)], rate.of[c]);
    }
  }
  // A block writes its own pushes; it reads rates, which are all there.
#pragma omp for schedule(static) nowait
  for (int block = 0; block < elements.facet_blocks(); ++block) {
    const auto at = [&](int c) { return load(&state.cotangents[corner_place(block, c)]); };
    const floatv cotangents[] = {at(0), at(1), at(2)};
    for (std::size_t p = 0; p < count; ++p) {
      const auto torque = [&](int c) {
        const std::size_t side = corner_place(block, c);
        return load(&state.resistance[side]) *
               (load(&rates[p][side]) + pick_numbers(elements.beside_picks, side / lanes, rates[p].data()));
      };
      const Sides<floatv> push = pushes_of_facet(cotangents, {torque(0), torque(1), torque(2)});
      for (int c = 0; c < 3; ++c) store(&room.pushes[p][corner_place(block, c)], push.of[c]);
    }
  }
}

// The sums of a block. Those of one loop are read until the next loop but one, so no two loops in a row share any.
enum Sum { pq, rr, rz, bb, gb, xx = bb, xy, xz, yy, yz, zz };

// Calls row(slice, -D v of its vertices, products) for every slice. Vectors are multiplied together: what is loaded of
// an element serves all. is_first: in a solve. A team calls it, and waits at its end.
template <bool is_first, std::size_t count, std::size_t sums, class Row>
void damp(const Elements<Real>& elements, const State<Real>& state, const Inputs<count>& v, DampingRoom& room,
          std::span<Array<Real>> rates, const std::array<int, sums>& which, const Row& row) {
  if (elements.membranes > 0) store_membranes(elements, state, v, room);
  if (elements.facets > 0) store_pushes<is_first>(elements, state, v, rates, room);
  // Parts of other threads' blocks are read below.
  if (elements.membranes > 0 || elements.facets > 0) {
#pragma omp barrier
  }
  std::array<std::span<const Real>, count> pushes;
  for (std::size_t p = 0; p < count; ++p) pushes[p] = room.pushes[p];
  // A slice's normals are kept by the thread that reads them.
  const auto normals = [&](std::size_t k) { return normals_at<is_first>(elements, state, k, room.normals); };
  with_links_of(elements, [&](auto springs, auto bending) {
    for_each_slice(
        elements.slices(), room.sums,
        which, [&](int slice, std::array<Products, sums>& products) __attribute__((always_inline)) {
          Pulls<count> pulls = add_links<decltype(springs), decltype(bending)>(elements, state, v, slice);
          if (elements.membranes > 0)
            for (std::size_t p = 0; p < count; ++p)
              pulls[p] = add_parts(elements.corners_at, room.membrane_parts[p].data(), slice, pulls[p]);
          if (elements.facets > 0) add_pushes(elements.corners_at, pushes, slice, normals, pulls);
          row(slice, pulls, products);
        });
  });
}

}  // namespace

DampingMemory<Real> make_damping_memory(const Elements<Real>& elements) {
  const int slices = elements.slices();
  const Array<Real> none(lanes * slice_vectors * static_cast<std::size_t>(slices)), sides(elements.last_place());
  DampingMemory<Real> memory = {.b = none, .x = none, .guess = none, .rates = {sides, sides}, .pulls = {}};
  DampingRoom& room = memory.room;
  room.q = none, room.inverse_mass.resize(lanes * static_cast<std::size_t>(slices));
  for (int p = 0; p < damped_at_once; ++p)
    room.membrane_parts[p] = make_parts(elements), room.pushes[p] = make_pushes(elements);
  if (elements.facets > 0) room.facet_normals = sides, room.normals.resize(3 * elements.corners_at.at.size());
  room.sums.resize(sums_of_block * blocks_of(slices));
  return memory;
}

linear::Solution damping_solve(const Elements<Real>& elements, const State<Real>& state, const Array<Real>& mass,
                               const Array<Real>& inverse_mass, Real half_step, const Vectors<Real>& force,
                               const linear::Stop& stop, Vectors<Real>& velocity, Changes<Real>& changes,
                               DampingMemory<Real>& memory) {
  const Vector3<floatv> none = {0.f, 0.f, 0.f};
  const Vector3<const Real*> f = pointers(force);
  const Vector3<Real*> v = pointers(velocity);
  DampingRoom& room = memory.room;
  const std::span<Real> r = memory.b, x = memory.x, p = memory.guess, q = room.q;
  const int slices = elements.slices();
  // Padding has no inverse mass, either.
  const auto free = [&](int slice) {
    return (load(&inverse_mass[lanes * slice]) > 0.f) & first_lanes(elements.vertices - lanes * slice);
  };
  const auto guess = [&](int slice) {
    return floatv(changes.weight[0]) * of_records(changes.last, slice) +
           floatv(changes.weight[1]) * of_records(changes.before, slice);
  };
  // A p of a slice, which is also stored. Inlined, as what calls it: else sums go through memory.
  const auto row = [&](int slice, const Vector3<floatv>& pulls) __attribute__((always_inline)) {
    const Vector3<floatv> row = load(&mass[lanes * slice]) * record(p, slice) - half_step * pulls;
    const Vector3<floatv> of_free = select(load(&room.inverse_mass[lanes * slice]) > 0.f, row, none);
    set(q, slice, of_free);
    return of_free;
  };
  const auto multiply = [&] {
    damp<false, 1, 1>(
        elements, state, {p}, room, memory.rates,
        {pq}, [&](int slice, const Pulls<1>& pulls, std::array<Products, 1>& sums) __attribute__((always_inline)) {
          sums[0].add(record(p, slice), row(slice, pulls[0]));
        });
    return total(room.sums, pq);
  };
  // r . r and r . z, z = M^-1 r.
  const auto add_residual = [&](int slice, const Vector3<floatv>& rest, std::array<Products, 2>& sums) {
    sums[0].add(rest, rest), sums[1].add(rest, load(&room.inverse_mass[lanes * slice]) * rest);
  };
  // r -= step q; |r|.
  const auto descend = [&](Real step) {
    for_each_slice<2>(slices, room.sums, {rr, rz}, [&](int slice, std::array<Products, 2>& sums) {
      const Vector3<floatv> rest = record(r, slice) - floatv(step) * record(q, slice);
      set(r, slice, rest);
      add_residual(slice, rest, sums);
    });
    return std::sqrt(total(room.sums, rr));
  };

  // The right-hand side of a slice.
  const auto right_side = [&](int slice, const Vector3<floatv>& pulls) {
    const Vector3<floatv> rest = select(free(slice), half_step * (load(f, lanes * slice) + pulls), none);
    set(r, slice, rest);
    return rest;
  };
  // The right-hand side, and its norm.
  const auto begin_without_guess = [&] {
    damp<true, 1, 2>(elements, state, {x}, room, memory.rates, {rr, rz},
                     [&](int slice, const Pulls<1>& pulls, std::array<Products, 2>& sums) {
                       add_residual(slice, right_side(slice, pulls[0]), sums);
                     });
    return std::sqrt(total(room.sums, rr));
  };
  // The right-hand side, and A times the guess, which is the first direction.
  const auto multiply_guess = [&] {
    damp<true, 2, 3>(elements, state, {x, p}, room, memory.rates, {bb, gb, pq},
                     [&](int slice, const Pulls<2>& pulls, std::array<Products, 3>& sums) {
                       const Vector3<floatv> b = right_side(slice, pulls[0]), g = record(p, slice);
                       sums[0].add(b, b), sums[1].add(g, b), sums[2].add(g, row(slice, pulls[1]));
                     });
  };

  const bool is_guessed = has_guess(changes);
  linear::Solution solution;
#pragma omp parallel
  {
    for_each_slice<0>(slices, room.sums, {}, [&](int i, std::array<Products, 0>&) {
      store(&room.inverse_mass[lanes * i], select(free(i), load(&inverse_mass[lanes * i]), floatv(0.f)));
      set(x, i, select(first_lanes(elements.vertices - lanes * i), load(v, lanes * i), none));
      if (is_guessed) set(p, i, guess(i));
    });
    // As far along the guess as along a direction; the rest is solved for. Every thread has these of its own, with the
    // same bits.
    Real along = 0;
    double norm_of_rest = 0, left = 1;  // |rest| / |b|
    if (is_guessed) {
      multiply_guess();
      const double norm_of_b = std::sqrt(total(room.sums, bb)), gq = total(room.sums, pq);
      along = gq > 0 ? static_cast<Real>(total(room.sums, gb) / gq) : 0;
      norm_of_rest = descend(along), left = norm_of_b > 0 ? norm_of_rest / norm_of_b : 0;
    } else {
      norm_of_rest = begin_without_guess();
    }
    linear::Solution mine;
    if (norm_of_rest != 0) mine = {.iterations = 0, .recursive_residual = 1, .true_residual = std::nan("")};
    double of_rz = 0;
    Real step = 0;
    const double tolerance = stop.tolerance / left;
    const auto done = [&] { return !(mine.recursive_residual > tolerance) || mine.iterations >= stop.iterations; };
    while (!done()) {
      const double rz_before = std::exchange(of_rz, total(room.sums, rz));
      const bool is_first = mine.iterations == 0;
      const Real share = is_first ? Real(0) : static_cast<Real>(of_rz / rz_before);
      for_each_slice<0>(slices, room.sums, {}, [&](int i, std::array<Products, 0>&) {
        const Vector3<floatv> z = load(&room.inverse_mass[lanes * i]) * record(r, i);
        const Vector3<floatv> direction = record(p, i);
        set(x, i, is_first ? none : record(x, i) + floatv(step) * direction);
        set(p, i, is_first ? z : z + floatv(share) * direction);
      });
      const double product = multiply();
      if (!(product > 0)) break;
      step = static_cast<Real>(of_rz / product);
      mine.recursive_residual = descend(step) / norm_of_rest;
      ++mine.iterations;
    }
    const bool is_there = mine.iterations > 0, is_last_step_due = is_there && done();
    for_each_slice<6>(slices, room.sums, {xx, xy, xz, yy, yz, zz}, [&](int i, std::array<Products, 6>& sums) {
      const Vector3<floatv> y = of_records(changes.last, i), z = of_records(changes.before, i);
      Vector3<floatv> change = is_there ? record(x, i) : none;
      if (is_last_step_due) change = change + floatv(step) * record(p, i);
      if (is_guessed) change = change + floatv(along) * guess(i);
      sums[0].add(change, change), sums[1].add(change, y), sums[2].add(change, z);
      sums[3].add(y, y), sums[4].add(y, z), sums[5].add(z, z);
      store_sixteen(&changes.before[4 * lanes * static_cast<std::size_t>(i)], change);
      store(v, lanes * i, load(v, lanes * i) + change, free(i));
    });
    // Every thread has the same solution; one writes it.
#pragma omp single nowait
    solution = mine, solution.recursive_residual *= left;
  }
  keep_change(changes, total(room.sums, xx), total(room.sums, xy), total(room.sums, xz), total(room.sums, yy),
              total(room.sums, yz), total(room.sums, zz));
  return solution;
}

}  // namespace lockstep::production_cloth::openmp
