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
// The first product of a solve keeps the triangles' normals in the order of vertices. The others read them from there.
//
// The contract stands in common/production_cloth/damping_solve.h.
#include "common/production_cloth/damping_solve.h"

#include <algorithm>
#include <array>
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
      const Vector3<floatv> d = load_records_at(v[p].data(), &elements.edges_at.at[lanes * k]) - own[p];
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
                              (load_records_at(v[p].data(), &elements.far_at.at[lanes * k]) - own[p]);
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
      const auto x = [&](int c) { return load_records_at(v[p].data(), elements.membrane_corner.vector(block, c)); };
      store_parts(damping_of_membrane<floatv>(elements, membrane, f, x(0), x(1), x(2)),
                  &room.membrane_parts[p][membrane_parts(block)]);
    }
  }
}

// What the hinges of triangles push their corners with, along the normals. A team calls it.
template <std::size_t count>
void store_pushes(const Elements<Real>& elements, const State<Real>& state, const Inputs<count>& v,
                  std::span<Array<Real>> rates, DampingRoom& room) {
  // A block writes its own rates.
#pragma omp for schedule(static)
  for (int block = 0; block < elements.facet_blocks(); ++block) {
    const auto at = [&](int c) { return load(&state.cotangents[corner_place(block, c)]); };
    const floatv cotangents[] = {at(0), at(1), at(2)};
    const Vector3<floatv> normal = record(state.normals, block);
    for (std::size_t p = 0; p < count; ++p) {
      const auto x = [&](int c) { return facet_corners(elements, v[p], block, c); };
      const Sides<floatv> rate = rates_of_facet(normal, cotangents, x(0), x(1), x(2));
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
               (load(&rates[p][side]) + load_each(rates[p].data(), &elements.beside[side]));
      };
      const Sides<floatv> push = pushes_of_facet(cotangents, {torque(0), torque(1), torque(2)});
      for (int c = 0; c < 3; ++c) store(&room.pushes[p][corner_place(block, c)], push.of[c]);
    }
  }
}

constexpr int slices_of_block = linear::dot_block / record_floats;
static_assert(linear::dot_block % record_floats == 0);

// Calls f(block, begin, end) for each block of sums, of elements of vectors. All loops over vectors give a thread the
// same blocks, so that they stay with its core. A team calls it, and waits at its end.
template <class F>
void for_each_block(int n, const F& f) {
  // A block writes its own elements and sums.
#pragma omp for schedule(static)
  for (int begin = 0; begin < n; begin += linear::dot_block)
    f(begin / linear::dot_block, begin, std::min(begin + linear::dot_block, n));
}
template <class F>
void for_each_slice(int begin, int end, const F& f) {
  for (int slice = begin / record_floats; slice < end / record_floats; ++slice) f(slice);
}

// Calls row(slice, -D v of its vertices) for every slice, and then sum(block, begin, end) for every block. Vectors are
// multiplied together: what is loaded of an element serves all. is_first: in a solve. A team calls it, and waits at its
// end.
template <bool is_first, std::size_t count, class Row, class Sum>
void damp(const Elements<Real>& elements, const State<Real>& state, const Inputs<count>& v, DampingRoom& room,
          std::span<Array<Real>> rates, const Row& row, const Sum& sum) {
  if (elements.membranes > 0) store_membranes(elements, state, v, room);
  if (elements.facets > 0) store_pushes(elements, state, v, rates, room);
  // Parts of other threads' blocks are read below.
  if (elements.membranes > 0 || elements.facets > 0) {
#pragma omp barrier
  }
  std::array<std::span<const Real>, count> pushes;
  for (std::size_t p = 0; p < count; ++p) pushes[p] = room.pushes[p];
  // A slice's normals are kept by the thread that reads them.
  const auto normals = [&](std::size_t k) { return normals_at<is_first>(elements, state, k, room.normals); };
  with_links_of(elements, [&](auto springs, auto bending) {
    for_each_block(record_floats * elements.slices(), [&](int block, int begin, int end) {
      for_each_slice(begin, end, [&](int slice) {
        Pulls<count> pulls = add_links<decltype(springs), decltype(bending)>(elements, state, v, slice);
        if (elements.membranes > 0)
          for (std::size_t p = 0; p < count; ++p)
            pulls[p] = add_parts(elements.corners_at, room.membrane_parts[p].data(), slice, pulls[p]);
        if (elements.facets > 0) add_pushes(elements.corners_at, pushes, slice, normals, pulls);
        row(slice, pulls);
      });
      sum(block, begin, end);
    });
  });
}

// The sums of a block. Those of one loop are read until the next loop but one, so no two loops in a row share any.
enum Sum { pq, rr, rz, bb, gb, xx = bb, xy, xz, yy, yz, zz };
constexpr std::size_t sums_of_block = 16;  // two cache lines

// A sum of all blocks, added up in their order.
double total(const DampingRoom& room, int which) {
  double sum = 0;
  for (std::size_t k = which; k < room.sums.size(); k += sums_of_block) sum += room.sums[k];
  return sum;
}

}  // namespace

DampingMemory<Real> make_damping_memory(const Elements<Real>& elements) {
  const Array<Real> none = make_records(elements), sides(elements.last_place());
  DampingMemory<Real> memory = {.b = none, .x = none, .guess = none, .rates = {sides, sides}, .pulls = {}};
  DampingRoom& room = memory.room;
  room.q = room.inverse_mass = none;
  for (int p = 0; p < damped_at_once; ++p)
    room.membrane_parts[p] = make_parts(elements), room.pushes[p] = make_pushes(elements);
  if (elements.facets > 0) room.normals.resize(3 * elements.corners_at.at.size());
  room.sums.resize(sums_of_block * ((none.size() + linear::dot_block - 1) / linear::dot_block));
  return memory;
}

linear::Solution damping_solve(const Elements<Real>& elements, const State<Real>& state, const Array<Real>& mass,
                               const Array<Real>& inverse_mass, Real half_step, const Vectors<Real>& force,
                               const linear::Stop& stop, Vectors<Real>& velocity, Changes<Real>& changes,
                               DampingMemory<Real>& memory) {
  using linear::openmp::add_products;
  const Vector3<floatv> none = {0.f, 0.f, 0.f};
  const Vector3<const Real*> f = pointers(force);
  const Vector3<Real*> v = pointers(velocity);
  DampingRoom& room = memory.room;
  const std::span<Real> r = memory.b, x = memory.x, p = memory.guess, q = room.q;
  const int n = static_cast<int>(r.size());
  const auto sums = [&](int block) { return &room.sums[sums_of_block * static_cast<std::size_t>(block)]; };
  // Padding has no inverse mass, either.
  const auto free = [&](int slice) {
    return (load(&inverse_mass[lanes * slice]) > 0.f) & first_lanes(elements.vertices - lanes * slice);
  };
  const auto guess = [&](int k) {
    return floatv(changes.weight[0]) * load(&changes.last[k]) + floatv(changes.weight[1]) * load(&changes.before[k]);
  };
  const auto row = [&](int slice, const Vector3<floatv>& pulls) {
    const Vector3<floatv> row = load(&mass[lanes * slice]) * record(p, slice) - half_step * pulls;
    set(q, slice, select(free(slice), row, none));
  };
  const auto multiply = [&] {
    damp<false, 1>(
        elements, state, {p}, room, memory.rates, [&](int slice, const Pulls<1>& pulls) { row(slice, pulls[0]); },
        [&](int block, int begin, int end) {
          doublev sum = 0.;
          for (int k = begin; k < end; k += lanes) sum = add_products(sum, load(&p[k]), load(&q[k]));
          sums(block)[pq] = reduce_add(sum);
        });
    return total(room, pq);
  };
  // r . r and r . z of a block, z = M^-1 r.
  const auto sum_residual = [&](int block, int begin, int end) {
    doublev of_rr = 0., of_rz = 0.;
    for (int k = begin; k < end; k += lanes) {
      const floatv rest = load(&r[k]);
      of_rr = add_products(of_rr, rest, rest);
      of_rz = add_products(of_rz, rest, load(&room.inverse_mass[k]) * rest);
    }
    sums(block)[rr] = reduce_add(of_rr), sums(block)[rz] = reduce_add(of_rz);
  };
  // r -= step q; |r|.
  const auto descend = [&](Real step) {
    for_each_block(n, [&](int block, int begin, int end) {
      for (int k = begin; k < end; k += lanes) store(&r[k], load(&r[k]) - step * load(&q[k]));
      sum_residual(block, begin, end);
    });
    return std::sqrt(total(room, rr));
  };

  const auto set_right_side = [&](int slice, const Vector3<floatv>& pulls) {
    const Vector3<floatv> rest = half_step * (load(f, lanes * slice) + pulls);
    set(r, slice, select(free(slice), rest, none));
  };
  // The right-hand side, and its norm.
  const auto begin_without_guess = [&] {
    damp<true, 1>(
        elements, state, {x}, room, memory.rates,
        [&](int slice, const Pulls<1>& pulls) { set_right_side(slice, pulls[0]); }, sum_residual);
    return std::sqrt(total(room, rr));
  };
  // The right-hand side, and A times the guess, which is the first direction.
  const auto multiply_guess = [&] {
    damp<true, 2>(
        elements, state, {x, p}, room, memory.rates,
        [&](int slice, const Pulls<2>& pulls) { set_right_side(slice, pulls[0]), row(slice, pulls[1]); },
        [&](int block, int begin, int end) {
          doublev of_bb = 0., of_gb = 0., of_gq = 0.;
          for (int k = begin; k < end; k += lanes) {
            const floatv b = load(&r[k]), g = load(&p[k]);
            of_bb = add_products(of_bb, b, b), of_gb = add_products(of_gb, g, b);
            of_gq = add_products(of_gq, g, load(&q[k]));
          }
          sums(block)[bb] = reduce_add(of_bb), sums(block)[gb] = reduce_add(of_gb), sums(block)[pq] = reduce_add(of_gq);
        });
  };

  const bool is_guessed = has_guess(changes);
  linear::Solution solution;
#pragma omp parallel
  {
    for_each_block(n, [&](int, int begin, int end) {
      for_each_slice(begin, end, [&](int i) {
        const floatv inverse = select(free(i), load(&inverse_mass[lanes * i]), floatv(0.f));
        set(x, i, select(first_lanes(elements.vertices - lanes * i), load(v, lanes * i), none));
        set(room.inverse_mass, i, {inverse, inverse, inverse});
      });
      if (is_guessed)
        for (int k = begin; k < end; k += lanes) store(&p[k], guess(k));
    });
    // As far along the guess as along a direction; the rest is solved for. Every thread has these of its own, with the
    // same bits.
    Real along = 0;
    double norm_of_rest = 0, left = 1;  // |rest| / |b|
    if (is_guessed) {
      multiply_guess();
      const double norm_of_b = std::sqrt(total(room, bb)), gq = total(room, pq);
      along = gq > 0 ? static_cast<Real>(total(room, gb) / gq) : 0;
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
      const double rz_before = std::exchange(of_rz, total(room, rz));
      const bool is_first = mine.iterations == 0;
      const Real share = is_first ? Real(0) : static_cast<Real>(of_rz / rz_before);
      for_each_block(n, [&](int, int begin, int end) {
        for (int k = begin; k < end; k += lanes) {
          const floatv z = load(&room.inverse_mass[k]) * load(&r[k]), direction = load(&p[k]);
          store(&x[k], is_first ? floatv(0.f) : load(&x[k]) + step * direction);
          store(&p[k], is_first ? z : z + share * direction);
        }
      });
      const double product = multiply();
      if (!(product > 0)) break;
      step = static_cast<Real>(of_rz / product);
      mine.recursive_residual = descend(step) / norm_of_rest;
      ++mine.iterations;
    }
    const bool is_there = mine.iterations > 0, is_last_step_due = is_there && done();
    for_each_block(n, [&](int block, int begin, int end) {
      doublev of_xx = 0., of_xy = 0., of_xz = 0., of_yy = 0., of_yz = 0., of_zz = 0.;
      for (int k = begin; k < end; k += lanes) {
        const floatv y = load(&changes.last[k]), z = load(&changes.before[k]);
        floatv change = is_there ? load(&x[k]) : floatv(0.f);
        if (is_last_step_due) change = change + floatv(step) * load(&p[k]);
        if (is_guessed) change = change + along * guess(k);
        of_xx = add_products(of_xx, change, change), of_xy = add_products(of_xy, change, y);
        of_xz = add_products(of_xz, change, z), of_yy = add_products(of_yy, y, y);
        of_yz = add_products(of_yz, y, z), of_zz = add_products(of_zz, z, z);
        store(&changes.before[k], change);
      }
      sums(block)[xx] = reduce_add(of_xx), sums(block)[xy] = reduce_add(of_xy), sums(block)[xz] = reduce_add(of_xz);
      sums(block)[yy] = reduce_add(of_yy), sums(block)[yz] = reduce_add(of_yz), sums(block)[zz] = reduce_add(of_zz);
      for_each_slice(begin, end,
                     [&](int i) { store(v, lanes * i, load(v, lanes * i) + record(changes.before, i), free(i)); });
    });
    // Every thread has the same solution; one writes it.
#pragma omp single nowait
    solution = mine, solution.recursive_residual *= left;
  }
  keep_change(changes, total(room, xx), total(room, xy), total(room, xz), total(room, yy), total(room, yz),
              total(room, zz));
  return solution;
}

}  // namespace lockstep::production_cloth::openmp
