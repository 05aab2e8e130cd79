// The damping of a cloth, implicit, by conjugate gradients.
//
// The algorithm stands in serial/production_cloth/damping_solve.cpp. In a product, as in `forces`, a vertex goes
// through its links itself, and adds up the parts that membranes and hinges have stored, in the order of the elements:
// the serial bits. Sixteen vertices at once; blocks of vertices, which sum their share of p . A p, are shared among
// threads. The conjugate gradients' own dot products and updates are linear/'s.
//
// The contract stands in common/production_cloth/damping_solve.h.
#include "common/production_cloth/damping_solve.h"

#include <algorithm>

#include "common/linear/dot.h"
#include "common/linear/iterate.h"
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

// The parts of membranes and hinges.
void store_all_parts(const Elements<Real>& elements, const State<Real>& state, std::span<const Real> v,
                     Array<Real>& parts) {
  if (elements.membranes == 0 && elements.hinges == 0) return;
  const auto corner = [&](const Blocked<std::int32_t>& corners, int block, int c) {
    return load_records_at(v.data(), corners.vector(block, c));
  };
#pragma omp parallel
  {
    // A block writes its own parts.
#pragma omp for schedule(static) nowait
    for (int block = 0; block < elements.membrane_corner_blocks(); ++block) {
      const auto field = [&](const Blocked<Real>& array, int k) { return load(array.vector(block, k)); };
      const Columns<floatv> f = {load_fields(state.deformation, block, 0), load_fields(state.deformation, block, 3)};
      store_parts(damping_of_membrane<floatv>(
                      elements, membrane_of<floatv>(elements, field), f, corner(elements.membrane_corner, block, 0),
                      corner(elements.membrane_corner, block, 1), corner(elements.membrane_corner, block, 2)),
                  &parts[membrane_parts(block)]);
    }
    // Likewise.
#pragma omp for schedule(static)
    for (int block = 0; block < elements.hinge_corner_blocks(); ++block) {
      Parts<floatv, 4> slope, of_corners;
      for (int c = 0; c < 4; ++c) {
        slope.of[c] = load_fields(state.fold, block, 3 * c);
        of_corners.of[c] = corner(elements.hinge_corner, block, c);
      }
      store_parts(damping_of_hinge(slope, of_corners), &parts[hinge_parts(elements, block)]);
    }
  }
}

// Calls row(slice, -D v of its vertices) for every slice; returns the sum over blocks of slices, in their order, of
// sum(begin, end), of elements of vectors, after their rows.
template <class Row, class Sum>
double damp(const Elements<Real>& elements, const State<Real>& state, std::span<const Real> v, Array<Real>& parts,
            const Row& row, const Sum& sum) {
  store_all_parts(elements, state, v, parts);
  double total = 0;
  with_links_of(elements, [&](auto springs, auto bending) {
    total = linear::openmp::sum_of_blocks(v.size(), [&](std::size_t begin, std::size_t end) {
      for (int slice = static_cast<int>(begin / record_floats); slice < static_cast<int>(end / record_floats);
           ++slice) {
        const Vector3<floatv> pulls = add_links<decltype(springs), decltype(bending)>(elements, state, v, slice);
        row(slice, add_parts(elements.parts_at, parts.data(), slice, pulls));
      }
      return sum(begin, end);
    });
  });
  return total;
}

}  // namespace

DampingMemory<Real> make_damping_memory(const Elements<Real>& elements) {
  return {make_records(elements), make_records(elements), {}, make_parts(elements)};
}

linear::Solution damping_solve(const Elements<Real>& elements, const State<Real>& state, const Array<Real>& mass,
                               const Array<Real>& inverse_mass, Real half_step, const Vectors<Real>& force,
                               const linear::Stop& stop, Vectors<Real>& velocity, DampingMemory<Real>& memory) {
  const Vector3<floatv> none = {0.f, 0.f, 0.f};
  const Vector3<const Real*> f = pointers(force);
  const Vector3<Real*> v = pointers(velocity);
  const int slices = elements.slices();
  // Padding has no inverse mass, either.
  const auto free = [&](int slice) {
    return (load(&inverse_mass[lanes * slice]) > 0.f) & first_lanes(elements.vertices - lanes * slice);
  };
  const auto no_sum = [](std::size_t, std::size_t) { return 0.; };
  // A slice writes its own records.
#pragma omp parallel for schedule(static)
  for (int i = 0; i < slices; ++i)
    set(memory.x, i, select(first_lanes(elements.vertices - lanes * i), load(v, lanes * i), none));
  damp(
      elements, state, memory.x, memory.parts,
      [&](int i, const Vector3<floatv>& pulls) {
        const Vector3<floatv> rest = half_step * (load(f, lanes * i) + pulls);
        set(memory.b, i, select(free(i), rest, none));
      },
      no_sum);

  const auto multiply = [&](std::span<const Real> p, std::span<Real> q) {
    return damp(
        elements, state, p, memory.parts,
        [&](int i, const Vector3<floatv>& pulls) {
          const Vector3<floatv> row = load(&mass[lanes * i]) * record(p, i) - half_step * pulls;
          set(q, i, select(free(i), row, none));
        },
        [&](std::size_t begin, std::size_t end) {
          doublev sum = 0.;
          for (std::size_t k = begin; k < end; k += lanes)
            sum = linear::openmp::add_products(sum, load(&p[k]), load(&q[k]));
          return reduce_add(sum);
        });
  };
  const auto precondition = [&](std::span<const Real> r, std::span<Real> z) {
  // A slice writes its own records.
#pragma omp parallel for schedule(static)
    for (int i = 0; i < slices; ++i) set(z, i, select(free(i), load(&inverse_mass[lanes * i]) * record(r, i), none));
  };
  const linear::VectorKernels<Real> kernels = {linear::openmp::dot, linear::openmp::axpy, linear::openmp::advance,
                                               linear::openmp::descend};
  const linear::System<Real> system = {multiply, precondition, nullptr, nullptr};
  const linear::Solution solution = linear::iterate<Real>(kernels, system, memory.b, memory.x, stop);

  // A slice writes its own velocities.
#pragma omp parallel for schedule(static)
  for (int i = 0; i < slices; ++i) store(v, lanes * i, load(v, lanes * i) + record(memory.x, i), free(i));
  return solution;
}

}  // namespace lockstep::production_cloth::openmp
