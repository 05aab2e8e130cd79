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
// The contract stands in common/production_cloth/damping_solve.h.
#include "common/production_cloth/damping_solve.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/linear/dot.h"
#include "common/real.h"
#include "openmp/linear/block_sums.h"
#include "openmp/production_cloth/facets.h"

namespace lockstep::production_cloth::openmp {
namespace {

constexpr int record_floats = 4 * lanes;  // of a slice

LOCKSTEP_INLINE Vector3<floatv> record(std::span<const Real> x, int slice) {
  return load_sixteen(&x[record_floats * static_cast<std::size_t>(slice)]);
}
LOCKSTEP_INLINE void set(std::span<Real> x, int slice, const Vector3<floatv>& value) {
  store_sixteen(&x[record_floats * static_cast<std::size_t>(slice)], value);
}

template <class Springs, class Bending>
LOCKSTEP_INLINE Vector3<floatv> add_links(const Elements<Real>& elements, const State<Real>& state,
                                          std::span<const Real> v, int slice) {
  const Vector3<floatv> own = record(v, slice);
  const floatv bend_damping = elements.bend_damping;
  Vector3<floatv> sum = {0.f, 0.f, 0.f};
  for (std::size_t k = elements.edges_at.first[slice]; k < std::size_t(elements.edges_at.first[slice + 1]); ++k) {
    const Vector3<floatv> d = load_records_at(v.data(), &elements.edges_at.at[lanes * k]) - own;
    Vector3<floatv> part = {0.f, 0.f, 0.f};
    if constexpr (Bending::value) part = (bend_damping * load(&elements.edge_bending_at[lanes * k])) * d;
    if constexpr (Springs::value) {
      const Real* const along = &state.along[3 * lanes * k];
      part = part + damping_of_spring({load(along), load(along + lanes), load(along + 2 * lanes)}, d);
    }
    sum = sum + part;
  }
  if constexpr (Bending::value)
    for (std::size_t k = elements.far_at.first[slice]; k < std::size_t(elements.far_at.first[slice + 1]); ++k)
      sum = sum + (bend_damping * load(&elements.far_bending_at[lanes * k])) *
                      (load_records_at(v.data(), &elements.far_at.at[lanes * k]) - own);
  return sum;
}

// The parts of membranes. A team calls it.
void store_membranes(const Elements<Real>& elements, const State<Real>& state, std::span<const Real> v,
                     DampingRoom& room) {
  // A block writes its own parts.
#pragma omp for schedule(static) nowait
  for (int block = 0; block < elements.membrane_corner_blocks(); ++block) {
    const auto field = [&](const Blocked<Real>& array, int k) { return load(array.vector(block, k)); };
    const auto x = [&](int c) { return load_records_at(v.data(), elements.membrane_corner.vector(block, c)); };
    const Columns<floatv> f = {load_fields(state.deformation, block, 0), load_fields(state.deformation, block, 3)};
    store_parts(damping_of_membrane<floatv>(elements, membrane_of<floatv>(elements, field), f, x(0), x(1), x(2)),
                &room.membrane_parts[membrane_parts(block)]);
  }
}

// What the hinges of triangles push their corners with, along the normals. A team calls it.
void store_pushes(const Elements<Real>& elements, const State<Real>& state, std::span<const Real> v,
                  std::span<Real> rates, DampingRoom& room) {
  // A block writes its own rates.
#pragma omp for schedule(static)
  for (int block = 0; block < elements.facet_blocks(); ++block) {
    const auto x = [&](int c) { return facet_corners(elements, v, block, c); };
    const auto at = [&](int c) { return load(&state.cotangents[corner_place(block, c)]); };
    const Sides<floatv> rate = rates_of_facet(record(state.normals, block), {at(0), at(1), at(2)}, x(0), x(1), x(2));
    for (int c = 0; c < 3; ++c) store(&rates[corner_place(block, c)], rate.of[c]);
  }
  // A block writes its own pushes; it reads rates, which are all there.
#pragma omp for schedule(static) nowait
  for (int block = 0; block < elements.facet_blocks(); ++block) {
    const auto torque = [&](int c) {
      const std::size_t side = corner_place(block, c);
      return load(&state.resistance[side]) * (load(&rates[side]) + load_at(rates, &elements.beside[side]));
    };
    const auto at = [&](int c) { return load(&state.cotangents[corner_place(block, c)]); };
    const Sides<floatv> push = pushes_of_facet({at(0), at(1), at(2)}, {torque(0), torque(1), torque(2)});
    for (int c = 0; c < 3; ++c) store(&room.pushes[corner_place(block, c)], push.of[c]);
  }
}

constexpr int slices_of_block = linear::dot_block / record_floats;
static_assert(linear::dot_block % record_floats == 0);

// Calls row(slice, -D v of its vertices) for every slice, and then sum(block, begin, end), of elements of vectors, for
// every block of slices. A team calls it, and waits at its end.
template <class Row, class Sum>
void damp(const Elements<Real>& elements, const State<Real>& state, std::span<const Real> v, DampingRoom& room,
          std::span<Real> rates, const Row& row, const Sum& sum) {
  if (elements.membranes > 0) store_membranes(elements, state, v, room);
  if (elements.facets > 0) store_pushes(elements, state, v, rates, room);
  // Parts of other threads' blocks are read below.
  if (elements.membranes > 0 || elements.facets > 0) {
#pragma omp barrier
  }
  with_links_of(elements, [&](auto springs, auto bending) {
    const int slices = elements.slices();
    // A block writes its own rows and sums.
#pragma omp for schedule(static)
    for (int begin = 0; begin < slices; begin += slices_of_block) {
      const int end = std::min(begin + slices_of_block, slices);
      for (int slice = begin; slice < end; ++slice) {
        Vector3<floatv> pulls = add_links<decltype(springs), decltype(bending)>(elements, state, v, slice);
        if (elements.membranes > 0) pulls = add_parts(elements.corners_at, room.membrane_parts.data(), slice, pulls);
        if (elements.facets > 0) pulls = add_pushes(elements, state, room.pushes, slice, pulls);
        row(slice, pulls);
      }
      sum(begin / slices_of_block, begin * record_floats, end * record_floats);
    }
  });
}

// Sum `which` of all blocks, added up in their order.
double total(const DampingRoom& room, int which) {
  double sum = 0;
  for (std::size_t k = which; k < room.sums.size(); k += 3) sum += room.sums[k];
  return sum;
}

}  // namespace

DampingMemory<Real> make_damping_memory(const Elements<Real>& elements) {
  DampingMemory<Real> memory = {make_records(elements), make_records(elements), Array<Real>(elements.last_place())};
  DampingRoom& room = memory.room;
  room.p = room.q = room.inverse_mass = make_records(elements);
  room.membrane_parts = make_parts(elements), room.pushes = make_pushes(elements);
  room.sums.resize(3 * ((memory.b.size() + linear::dot_block - 1) / linear::dot_block));
  return memory;
}

linear::Solution damping_solve(const Elements<Real>& elements, const State<Real>& state, const Array<Real>& mass,
                               const Array<Real>& inverse_mass, Real half_step, const Vectors<Real>& force,
                               const linear::Stop& stop, Vectors<Real>& velocity, DampingMemory<Real>& memory) {
  const Vector3<floatv> none = {0.f, 0.f, 0.f};
  const Vector3<const Real*> f = pointers(force);
  const Vector3<Real*> v = pointers(velocity);
  const int slices = elements.slices();
  DampingRoom& room = memory.room;
  const std::span<Real> r = memory.b, x = memory.x, p = room.p, q = room.q;
  const int n = static_cast<int>(r.size());
  // Padding has no inverse mass, either.
  const auto free = [&](int slice) {
    return (load(&inverse_mass[lanes * slice]) > 0.f) & first_lanes(elements.vertices - lanes * slice);
  };
  // r . r and r . z of a block, z = M^-1 r.
  const auto sum_residual = [&](int block, int begin, int end) {
    doublev rr = 0., rz = 0.;
    for (int k = begin; k < end; k += lanes) {
      const floatv rest = load(&r[k]);
      rr = linear::openmp::add_products(rr, rest, rest);
      rz = linear::openmp::add_products(rz, rest, load(&room.inverse_mass[k]) * rest);
    }
    room.sums[3 * static_cast<std::size_t>(block) + 1] = reduce_add(rr);
    room.sums[3 * static_cast<std::size_t>(block) + 2] = reduce_add(rz);
  };
  const auto multiply = [&] {
    damp(
        elements, state, p, room, memory.rates,
        [&](int i, const Vector3<floatv>& pulls) {
          const Vector3<floatv> row = load(&mass[lanes * i]) * record(p, i) - half_step * pulls;
          set(q, i, select(free(i), row, none));
        },
        [&](int block, int begin, int end) {
          doublev sum = 0.;
          for (int k = begin; k < end; k += lanes) sum = linear::openmp::add_products(sum, load(&p[k]), load(&q[k]));
          room.sums[3 * static_cast<std::size_t>(block)] = reduce_add(sum);
        });
    return total(room, 0);
  };

  linear::Solution solution;
#pragma omp parallel
  {
    // A slice writes its own records.
#pragma omp for schedule(static)
    for (int i = 0; i < slices; ++i) {
      const floatv inverse = select(free(i), load(&inverse_mass[lanes * i]), floatv(0.f));
      set(x, i, select(first_lanes(elements.vertices - lanes * i), load(v, lanes * i), none));
      set(room.inverse_mass, i, {inverse, inverse, inverse});
    }
    damp(
        elements, state, x, room, memory.rates,
        [&](int i, const Vector3<floatv>& pulls) {
          const Vector3<floatv> rest = half_step * (load(f, lanes * i) + pulls);
          set(r, i, select(free(i), rest, none));
        },
        sum_residual);

    // Every thread has these of its own, with the same bits.
    linear::Solution mine;
    const double norm_of_b = std::sqrt(total(room, 1));
    double rz = 0;
    Real step = 0;
    if (norm_of_b != 0) mine = {.iterations = 0, .recursive_residual = 1, .true_residual = std::nan("")};
    const auto done = [&] { return !(mine.recursive_residual > stop.tolerance) || mine.iterations >= stop.iterations; };
    while (!done()) {
      const double rz_before = std::exchange(rz, total(room, 2));
      const bool is_first = mine.iterations == 0;
      const Real share = is_first ? Real(0) : static_cast<Real>(rz / rz_before);
      // An element is read and written by its own iteration alone.
#pragma omp for schedule(static)
      for (int k = 0; k < n; k += lanes) {
        const floatv z = load(&room.inverse_mass[k]) * load(&r[k]), along = load(&p[k]);
        store(&x[k], is_first ? floatv(0.f) : load(&x[k]) + step * along);
        store(&p[k], is_first ? z : z + share * along);
      }
      const double pq = multiply();
      if (!(pq > 0)) break;
      step = static_cast<Real>(rz / pq);
      // A block writes its own residual and sums.
#pragma omp for schedule(static)
      for (int begin = 0; begin < n; begin += linear::dot_block) {
        const int end = std::min(begin + linear::dot_block, n);
        for (int k = begin; k < end; k += lanes) store(&r[k], load(&r[k]) - step * load(&q[k]));
        sum_residual(begin / linear::dot_block, begin, end);
      }
      mine.recursive_residual = std::sqrt(total(room, 1)) / norm_of_b;
      ++mine.iterations;
    }
    const bool is_there = mine.iterations > 0, is_last_step_due = is_there && done();
    // A slice writes its own velocities.
#pragma omp for schedule(static)
    for (int i = 0; i < slices; ++i) {
      Vector3<floatv> change = is_there ? record(x, i) : none;
      if (is_last_step_due) change = change + floatv(step) * record(p, i);
      store(v, lanes * i, load(v, lanes * i) + change, free(i));
    }
    // Every thread has the same solution; one writes it.
#pragma omp single nowait
    solution = mine;
  }
  return solution;
}

}  // namespace lockstep::production_cloth::openmp
