// The elastic forces of a cloth.
//
// The algorithm and its serial form stand in serial/production_cloth/forces.cpp. Elements that share a vertex would
// write to it together. So a vertex goes through its links itself, sixteen vertices at once: a link is computed twice,
// once from either end, where it has the same bits but for the sign, as d = x_to - x_from has. Membranes and hinges,
// which would be computed three and four times, are taken sixteen at a time and store their parts, which vertices then
// add up. Each vertex adds in the order of the elements: the serial bits. Or threads add each part under the vertex's
// lock, as [ITJ07]'s does where several iterations update one datum.
//
// The contract stands in common/production_cloth/forces.h.
#include "common/production_cloth/forces.h"

#include <algorithm>

#include "common/real.h"
#include "openmp/production_cloth/records.h"
#include "openmp/share.h"

namespace lockstep::production_cloth::openmp {
namespace {

template <class Springs, class Bending>
Vector3<floatv> add_links(const Elements<Real>& elements, const Real* records, int slice, State<Real>& state) {
  const Vector3<floatv> own = load_sixteen(records + 4 * lanes * static_cast<std::size_t>(slice));
  Vector3<floatv> sum = {0.f, 0.f, 0.f};
  for (std::size_t k = elements.edges_at.first[slice]; k < std::size_t(elements.edges_at.first[slice + 1]); ++k) {
    const Vector3<floatv> d = load_records_at(records, &elements.edges_at.at[lanes * k]) - own;
    Vector3<floatv> part = {0.f, 0.f, 0.f};
    if constexpr (Bending::value) part = load(&elements.edge_bending_at[lanes * k]) * d;
    if constexpr (Springs::value) {
      const Real* const spring = &elements.spring_at[3 * lanes * k];
      const Pull<floatv> pull = pull_of_spring(load(spring), load(spring + lanes), load(spring + 2 * lanes), d);
      Real* const along = &state.along[3 * lanes * k];
      store(along, pull.along.x), store(along + lanes, pull.along.y), store(along + 2 * lanes, pull.along.z);
      part = part + pull.force;
    }
    sum = sum + part;
  }
  if constexpr (Bending::value)
    for (std::size_t k = elements.far_at.first[slice]; k < std::size_t(elements.far_at.first[slice + 1]); ++k)
      sum = sum + load(&elements.far_bending_at[lanes * k]) *
                      (load_records_at(records, &elements.far_at.at[lanes * k]) - own);
  return sum;
}

Parts<floatv, 3> parts_of_membranes(const Elements<Real>& elements, const Real* records, int block,
                                    Columns<floatv>& f) {
  const auto x = [&](int c) { return load_records_at(records, elements.membrane_corner.vector(block, c)); };
  const Vector3<floatv> x0 = x(0), x1 = x(1), x2 = x(2);
  const Membrane<floatv> m =
      membrane_of<floatv>(elements, [&](const Blocked<Real>& array, int k) { return load(array.vector(block, k)); });
  f = deformation_of(m, x1 - x0, x2 - x0);
  return parts_of_membrane(m, stress_of_membrane(elements, f));
}

Fold<floatv> fold_of_hinges(const Elements<Real>& elements, const Real* records, int block) {
  const auto x = [&](int c) { return load_records_at(records, elements.hinge_corner.vector(block, c)); };
  return fold_of(x(0), x(1), x(2), x(3));
}
Parts<floatv, 4> parts_of_hinges(const Elements<Real>& elements, int block, const Fold<floatv>& fold) {
  return parts_of_hinge(floatv(elements.hinge_stiffness), load(elements.hinge.vector(block, 0)), fold);
}

// Positions as records.
void pack(const Elements<Real>& elements, const Vectors<Real>& position, Array<Real>& records) {
  const Vector3<const Real*> x = pointers(position);
  // A slice writes its own records.
#pragma omp for schedule(static)
  for (int slice = 0; slice < elements.slices(); ++slice)
    store_sixteen(&records[4 * lanes * static_cast<std::size_t>(slice)], load(x, lanes * slice));
}

// The parts of membranes and hinges. Called by all threads of a team.
void store_all_parts(const Elements<Real>& elements, State<Real>& state) {
  // A block writes its own parts and state.
#pragma omp for schedule(static) nowait
  for (int block = 0; block < elements.membrane_corner_blocks(); ++block) {
    Columns<floatv> f;
    store_parts(parts_of_membranes(elements, state.records.data(), block, f), &state.parts[membrane_parts(block)]);
    store_fields(state.deformation, block, 0, f.x), store_fields(state.deformation, block, 3, f.y);
  }
  // Likewise.
#pragma omp for schedule(static)
  for (int block = 0; block < elements.hinge_corner_blocks(); ++block) {
    const Fold<floatv> fold = fold_of_hinges(elements, state.records.data(), block);
    const Parts<floatv, 4> slope = damped_slope(load(elements.hinge.vector(block, 1)), fold);
    for (int c = 0; c < 4; ++c) store_fields(state.fold, block, 3 * c, slope.of[c]);
    store_parts(parts_of_hinges(elements, block, fold), &state.parts[hinge_parts(elements, block)]);
  }
}

}  // namespace

State<Real> make_state(const Elements<Real>& elements) {
  State<Real> state = make_state_of_blocks(elements);
  if (elements.has_springs) state.along.resize(3 * elements.edges_at.at.size());
  state.records = make_records(elements), state.parts = make_parts(elements);
  return state;
}

void forces(const Elements<Real>& elements, const Vectors<Real>& position, State<Real>& state, Vectors<Real>& force) {
  const Vector3<Real*> f = pointers(force);
  with_links_of(elements, [&](auto springs, auto bending) {
#pragma omp parallel
    {
      pack(elements, position, state.records);
      store_all_parts(elements, state);
      // A slice writes its own vertices' forces, and the directions of its own links.
#pragma omp for schedule(static)
      for (int slice = 0; slice < elements.slices(); ++slice) {
        const Vector3<floatv> sum =
            add_links<decltype(springs), decltype(bending)>(elements, state.records.data(), slice, state);
        store(f, lanes * slice, add_parts(elements.parts_at, state.parts.data(), slice, sum),
              first_lanes(elements.vertices - lanes * slice));
      }
    }
  });
}

namespace {

// Adds sixteen parts to vertices, those below `count`, each under its lock.
void add_under_locks(const std::int32_t* vertex, const Vector3<floatv>& part, int count, lockstep::openmp::Locks& locks,
                     Vectors<Real>& force) {
  Real x[lanes], y[lanes], z[lanes];
  store(x, part.x), store(y, part.y), store(z, part.z);
  for (int l = 0; l < std::min(count, lanes); ++l) {
    const lockstep::openmp::Guard guard(locks, vertex[l]);
    store(force, vertex[l], load(force, vertex[l]) + Vector3<Real>{x[l], y[l], z[l]});
  }
}

Vector3<floatv> parts_of_links(const Elements<Real>& elements, const Real* records, int k) {
  const Vector3<floatv> d = load_records_at(records, &elements.to[k]) - load_records_at(records, &elements.from[k]);
  Vector3<floatv> part = {0.f, 0.f, 0.f};
  if (elements.has_bending) part = load(&elements.bending[k]) * d;
  if (elements.has_springs && k < elements.edges) {
    const Pull<floatv> pull = pull_of_spring(load(&elements.rest_length[k]), load(&elements.spring[k]),
                                             load(&elements.root_of_damping[k]), d);
    part = select(first_lanes(elements.edges - k), part + pull.force, part);
  }
  return part;
}

}  // namespace

void forces_locks(const Elements<Real>& elements, const Vectors<Real>& position, Vectors<Real>& force) {
  for (Array<Real>* component : {&force.x, &force.y, &force.z})
    std::fill_n(component->begin(), elements.vertices, Real(0));
  lockstep::openmp::Locks locks(elements.vertices);
  Array<Real> room = make_records(elements);
  const Real* const records = room.data();
#pragma omp parallel
  {
    pack(elements, position, room);
    // A vertex is written under its lock; in the two loops below, too.
#pragma omp for schedule(static) nowait
    for (int k = 0; k < elements.links; k += lanes) {
      const Vector3<floatv> part = parts_of_links(elements, records, k);
      add_under_locks(&elements.from[k], part, elements.links - k, locks, force);
      add_under_locks(&elements.to[k], -part, elements.links - k, locks, force);
    }
    // See above.
#pragma omp for schedule(static) nowait
    for (int block = 0; block < elements.membrane_corner_blocks(); ++block) {
      Columns<floatv> f;
      const Parts<floatv, 3> parts = parts_of_membranes(elements, records, block, f);
      for (int c = 0; c < 3; ++c)
        add_under_locks(elements.membrane_corner.vector(block, c), parts.of[c], elements.membranes - lanes * block,
                        locks, force);
    }
    // See above.
#pragma omp for schedule(static)
    for (int block = 0; block < elements.hinge_corner_blocks(); ++block) {
      const Parts<floatv, 4> parts = parts_of_hinges(elements, block, fold_of_hinges(elements, records, block));
      for (int c = 0; c < 4; ++c)
        add_under_locks(elements.hinge_corner.vector(block, c), parts.of[c], elements.hinges - lanes * block, locks,
                        force);
    }
  }
}

}  // namespace lockstep::production_cloth::openmp
