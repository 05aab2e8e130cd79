// The damping of a cloth, implicit, by conjugate gradients.
//
// The algorithm stands in serial/production_cloth/damping_solve.cpp. In a product, as in `forces`, a vertex goes
// through its links itself, and adds up what membranes and hinges give it, in the order of the elements: the serial
// bits. Of a hinge it is the slope by the vertex times one number: hinges store these numbers, and each vertex has a
// copy of its slopes, made once a solve. Sixteen vertices at once.
//
// All iterations are one parallel region, in which every thread carries the same scalars along. An iteration waits four
// times: for the numbers of hinges and the parts of membranes; for A p and p . A p; for the residual and its two sums;
// for the next direction. Sums are of blocks of vertices, in the order of linear/'s dot product, and each thread adds
// up all blocks itself.
//
// The contract stands in common/production_cloth/damping_solve.h.
#include "common/production_cloth/damping_solve.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "common/linear/dot.h"
#include "common/real.h"
#include "openmp/linear/block_sums.h"
#include "openmp/production_cloth/records.h"

namespace lockstep::production_cloth::openmp {
namespace {

constexpr int record_floats = 4 * lanes;  // of a slice

Vector3<floatv> record(std::span<const Real> x, int slice) {
  return load_sixteen(&x[record_floats * static_cast<std::size_t>(slice)]);
}
void set(std::span<Real> x, int slice, const Vector3<floatv>& value) {
  store_sixteen(&x[record_floats * static_cast<std::size_t>(slice)], value);
}

template <class Springs, class Bending>
Vector3<floatv> add_links(const Elements<Real>& elements, const State<Real>& state, std::span<const Real> v,
                          int slice) {
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

// Membranes store their parts, hinges what slopes are multiplied by. A team calls it, and waits at its end.
void damp_elements(const Elements<Real>& elements, const State<Real>& state, std::span<const Real> v,
                   DampingRoom& room) {
  if (elements.membranes == 0 && elements.hinges == 0) return;
  const auto corner = [&](const Blocked<std::int32_t>& corners, int block, int c) {
    return load_records_at(v.data(), corners.vector(block, c));
  };
  // A block writes its own parts.
#pragma omp for schedule(static) nowait
  for (int block = 0; block < elements.membrane_corner_blocks(); ++block) {
    const auto field = [&](const Blocked<Real>& array, int k) { return load(array.vector(block, k)); };
    const Columns<floatv> f = {load_fields(state.deformation, block, 0), load_fields(state.deformation, block, 3)};
    store_parts(damping_of_membrane<floatv>(
                    elements, membrane_of<floatv>(elements, field), f, corner(elements.membrane_corner, block, 0),
                    corner(elements.membrane_corner, block, 1), corner(elements.membrane_corner, block, 2)),
                &room.parts[membrane_parts(block)]);
  }
  // A block writes its own numbers.
#pragma omp for schedule(static)
  for (int block = 0; block < elements.hinge_corner_blocks(); ++block) {
    Parts<floatv, 4> slope, of_corners;
    for (int c = 0; c < 4; ++c) {
      slope.of[c] = load_fields(state.fold, block, 3 * c);
      of_corners.of[c] = corner(elements.hinge_corner, block, c);
    }
    store(&room.rate[lanes * static_cast<std::size_t>(block)], rate_of_hinge(slope, of_corners));
  }
}

// What the hinges of a slice's vertices give them, in their order.
LOCKSTEP_INLINE Vector3<floatv> add_hinges(const DampingRoom& room, int slice, Vector3<floatv> sum) {
  for (std::size_t k = room.hinges_at.first[slice]; k < std::size_t(room.hinges_at.first[slice + 1]); ++k) {
    const Real* const slope = &room.slope_at[3 * lanes * k];
    const floatv rate = gather(room.rate.data(), load(&room.hinges_at.at[lanes * k]));
    sum = sum + rate * Vector3<floatv>{load(slope), load(slope + lanes), load(slope + 2 * lanes)};
  }
  return sum;
}

// The slopes of hinges by their vertices, as slices have them. A team calls it.
void copy_slopes(const Elements<Real>& elements, const State<Real>& state, DampingRoom& room) {
  const int none = lanes * elements.hinge_corner_blocks();
  // A slice writes its own slopes.
#pragma omp for schedule(static) nowait
  for (int slice = 0; slice < elements.slices(); ++slice)
    for (std::size_t k = room.hinges_at.first[slice]; k < std::size_t(room.hinges_at.first[slice + 1]); ++k) {
      const maskv is_there = load(&room.hinges_at.at[lanes * k]) < none;
      const intv at = load(&room.fold_at[lanes * k]);
      for (int c = 0; c < 3; ++c)
        store(&room.slope_at[lanes * (3 * k + c)], gather(state.fold.value.data(), at + lanes * c, is_there));
    }
}

constexpr int slices_of_block = linear::dot_block / record_floats;
static_assert(linear::dot_block % record_floats == 0);

// Calls row(slice, -D v of its vertices) for every slice, and then sum(block, begin, end), of elements of vectors, for
// every block of slices. A team calls it, and waits at its end.
template <class Row, class Sum>
void damp(const Elements<Real>& elements, const State<Real>& state, std::span<const Real> v, DampingRoom& room,
          const Row& row, const Sum& sum) {
  damp_elements(elements, state, v, room);
  with_links_of(elements, [&](auto springs, auto bending) {
    const int slices = elements.slices();
    // A block writes its own rows and sums.
#pragma omp for schedule(static)
    for (int begin = 0; begin < slices; begin += slices_of_block) {
      const int end = std::min(begin + slices_of_block, slices);
      for (int slice = begin; slice < end; ++slice) {
        const Vector3<floatv> pulls = add_links<decltype(springs), decltype(bending)>(elements, state, v, slice);
        row(slice, add_hinges(room, slice, add_parts(room.membranes_at, room.parts.data(), slice, pulls)));
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

// A vertex's records of `parts_at` from `first` to `last` - 1, as slices of their own; fill: what fills up.
template <class Item>
Slices slices_between(const Elements<Real>& elements, int first, int last, const Item& item, std::int32_t fill) {
  Slices slices;
  slices.first.push_back(0);
  for (int slice = 0; slice < elements.slices(); ++slice) {
    std::vector<std::int32_t> lists[lanes];
    std::size_t longest = 0;
    for (int k = elements.parts_at.first[slice]; k < elements.parts_at.first[slice + 1]; ++k)
      for (int l = 0; l < lanes; ++l) {
        const std::int32_t record = elements.parts_at.at[lanes * static_cast<std::size_t>(k) + l];
        if (record >= first && record < last) lists[l].push_back(item(record - first));
        longest = std::max(longest, lists[l].size());
      }
    for (std::size_t k = 0; k < longest; ++k)
      for (const std::vector<std::int32_t>& list : lists) slices.at.push_back(k < list.size() ? list[k] : fill);
    slices.first.push_back(static_cast<std::int32_t>(slices.at.size() / lanes));
  }
  return slices;
}

}  // namespace

DampingMemory<Real> make_damping_memory(const Elements<Real>& elements) {
  DampingMemory<Real> memory = {make_records(elements), make_records(elements)};
  DampingRoom& room = memory.room;
  room.p = room.q = room.inverse_mass = make_records(elements), room.parts = make_parts(elements);
  const int first = elements.hinge_record(0, 0), last = elements.last_record();
  const int none = lanes * elements.hinge_corner_blocks();
  room.rate.resize(none + 1);
  room.membranes_at = slices_between(
      elements, 0, first, [](int record) { return record; }, last);
  // Of record (16 (4 block + c) + lane): the hinge; and its slope by corner c, field 3 c of twelve.
  room.hinges_at = slices_between(
      elements, first, last, [](int r) { return r / (4 * lanes) * lanes + r % lanes; }, none);
  room.fold_at = slices_between(
                     elements, first, last,
                     [](int r) { return r / (4 * lanes) * 12 * lanes + r / lanes % 4 * 3 * lanes + r % lanes; }, 0)
                     .at;
  room.slope_at.resize(3 * room.hinges_at.at.size());
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
        elements, state, p, room,
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
    copy_slopes(elements, state, room);
    damp(
        elements, state, x, room,
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
#pragma omp single nowait
    solution = mine;
  }
  return solution;
}

}  // namespace lockstep::production_cloth::openmp
