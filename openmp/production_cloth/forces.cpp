// The elastic forces of a cloth.
//
// The algorithm stands in serial/production_cloth/forces.cpp. Elements that share a vertex would write to it together.
// So a vertex goes through its links itself, sixteen vertices at once: a link is computed twice, once from either end,
// where it has the same bits but for the sign. Membranes and hinges, which would be computed three and four times, are
// taken sixteen at a time and store their parts, which vertices add up in the order of the elements: the serial bits.
//
// Three contrasts. A vertex computes membranes and hinges itself: the same bits, and nothing is stored. Elements in
// colours add to their vertices at once, sixteen together. Or threads add each part under its vertex's lock ([ITJ07]).
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

void set_facets(const Elements<Real>& elements, State<Real>& state) {
  // A block writes its own facets.
#pragma omp for schedule(static) nowait
  for (int block = 0; block < elements.facet_blocks(); ++block) {
    const auto x = [&](int c) { return facet_corners(elements, state.records, block, c); };
    const Facet<floatv> facet = facet_of(x(0), x(1), x(2));
    store_sixteen(&state.normals[4 * lanes * static_cast<std::size_t>(block)], facet.normal);
    for (int c = 0; c < 3; ++c) store(state.facet.vector(block, c), facet.at[c]);
  }
}

// The parts of membranes and hinges. Called by all threads of a team, as is set_facets.
void store_all_parts(const Elements<Real>& elements, State<Real>& state) {
  // A block writes its own parts and state.
#pragma omp for schedule(static) nowait
  for (int block = 0; block < elements.membrane_corner_blocks(); ++block) {
    Columns<floatv> f;
    store_parts(parts_of_membranes(elements, state.records.data(), block, f), &state.parts[membrane_parts(block)]);
    store_fields(state.deformation, block, 0, f.x), store_fields(state.deformation, block, 3, f.y);
  }
  // Likewise; a side belongs to one hinge.
#pragma omp for schedule(static)
  for (int block = 0; block < elements.hinge_corner_blocks(); ++block) {
    const Fold<floatv> fold = fold_of_hinges(elements, state.records.data(), block);
    store_parts(parts_of_hinges(elements, block, fold), &state.parts[hinge_parts(elements, block)]);
    const floatv resistance = resistance_of_hinge(load(elements.hinge.vector(block, 1)), fold);
    for (int k = 0; k < 2; ++k) store_at(state.resistance, elements.hinge_side.vector(block, k), resistance);
  }
}

}  // namespace

State<Real> make_state(const Elements<Real>& elements) {
  State<Real> state = make_state_of_blocks(elements);
  if (elements.has_springs) state.along.resize(3 * elements.edges_at.at.size());
  state.facet = {3, elements.facet_blocks()}, state.normals.resize(4 * lanes * std::size_t(elements.facet_blocks()));
  state.records = make_records(elements), state.parts = make_parts(elements);
  return state;
}

void forces(const Elements<Real>& elements, const Vectors<Real>& position, State<Real>& state, Vectors<Real>& force) {
  const Vector3<Real*> f = pointers(force);
  with_links_of(elements, [&](auto springs, auto bending) {
#pragma omp parallel
    {
      pack(elements, position, state.records);
      set_facets(elements, state);
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

namespace {

// An element and one of its corners in each of sixteen lanes.
struct Corners16 {
  std::int32_t element[lanes], corner[lanes];
};

// Fields of elements, and the positions of their corners.
template <class Index>
LOCKSTEP_INLINE floatv field_of(const Blocked<Real>& array, const Index& element, int field) {
  Real of_lanes[lanes];
  for (int l = 0; l < lanes; ++l) of_lanes[l] = array.at(element[l], field);
  return load(of_lanes);
}
template <class Index>
LOCKSTEP_INLINE Vector3<floatv> corner_of(const Blocked<std::int32_t>& corners, const Index& element, int c,
                                          const Real* records, std::int32_t* vertex) {
  for (int l = 0; l < lanes; ++l) vertex[l] = corners.at(element[l], c);
  return load_records_at(records, vertex);
}

// The parts of sixteen membranes, and of sixteen hinges; vertex[c]: their corners.
template <class Index>
Parts<floatv, 3> parts_of_membranes_at(const Elements<Real>& elements, const Index& element, const Real* records,
                                       std::int32_t (*vertex)[lanes]) {
  const auto x = [&](int c) { return corner_of(elements.membrane_corner, element, c, records, vertex[c]); };
  const Vector3<floatv> x0 = x(0), x1 = x(1), x2 = x(2);
  const Membrane<floatv> m =
      membrane_of<floatv>(elements, [&](const Blocked<Real>& array, int k) { return field_of(array, element, k); });
  return parts_of_membrane(m, stress_of_membrane(elements, deformation_of(m, x1 - x0, x2 - x0)));
}
template <class Index>
Parts<floatv, 4> parts_of_hinges_at(const Elements<Real>& elements, const Index& element, const Real* records,
                                    std::int32_t (*vertex)[lanes]) {
  const auto x = [&](int c) { return corner_of(elements.hinge_corner, element, c, records, vertex[c]); };
  const Vector3<floatv> x0 = x(0), x1 = x(1), x2 = x(2), x3 = x(3);
  return parts_of_hinge(floatv(elements.hinge_stiffness), field_of(elements.hinge, element, 0),
                        fold_of(x0, x1, x2, x3));
}

// The part of each lane's corner where `mask` is active, else 0.
template <int corners>
LOCKSTEP_INLINE Vector3<floatv> part_of(const Parts<floatv, corners>& parts, const std::int32_t* corner, maskv mask) {
  Vector3<floatv> part = {0.f, 0.f, 0.f};
  for (int c = 0; c < corners; ++c) part = select(mask & (load(corner) == c), parts.of[c], part);
  return part;
}

// Finds element and corner of each lane's record, and returns which are among records first .. last - 1, of elements
// with `corners` corners. Other lanes get element 0.
template <int corners>
maskv elements_of(const std::int32_t* record, int first, int last, Corners16& at) {
  const intv r = load(record);
  const maskv are_meant = (r >= first) & (r < last);
  for (int l = 0; l < lanes; ++l) {
    const int k = record[l] >= first && record[l] < last ? record[l] - first : 0;
    at.element[l] = k / (corners * lanes) * lanes + k % lanes, at.corner[l] = k / lanes % corners;
  }
  return are_meant;
}

// Adds up what the membranes and hinges at a slice's vertices give to them.
Vector3<floatv> add_elements(const Elements<Real>& elements, const Real* records, int slice, Vector3<floatv> sum) {
  const int first = 3 * lanes * elements.membrane_corner_blocks(), last = elements.last_record();
  std::int32_t vertex[4][lanes];
  for (int item = elements.parts_at.first[slice]; item < elements.parts_at.first[slice + 1]; ++item) {
    const std::int32_t* const record = &elements.parts_at.at[lanes * static_cast<std::size_t>(item)];
    Corners16 at;
    if (const maskv are_meant = elements_of<3>(record, 0, first, at); any(are_meant))
      sum = sum + part_of(parts_of_membranes_at(elements, at.element, records, vertex), at.corner, are_meant);
    if (const maskv are_meant = elements_of<4>(record, first, last, at); any(are_meant))
      sum = sum + part_of(parts_of_hinges_at(elements, at.element, records, vertex), at.corner, are_meant);
  }
  return sum;
}

// Adds sixteen parts to different vertices.
LOCKSTEP_INLINE void add_at(Real* force, const std::int32_t* vertex, const Vector3<floatv>& part, maskv mask) {
  const Vector3<floatv> sum = load_records_at(force, vertex) + part;
  store_quads(force, vertex, {{sum.x, sum.y, sum.z, floatv(0.f)}}, mask);
}

// Calls add(elements of sixteen lanes, which lanes are meant) for all elements, colour after colour; lanes beyond a
// colour's last repeat it, whose vertices no other thread writes. A team calls it.
template <class Add>
void for_each_colour(const Batches& colours, const Add& add) {
  for (int colour = 0; colour < colours.count(); ++colour) {
    const int begin = colours.begin[colour], end = colours.begin[colour + 1];
    // Elements of a colour have no vertex in common. The barrier ends the colour.
#pragma omp for schedule(static)
    for (int k = begin; k < end; k += lanes) {
      std::int32_t element[lanes];
      for (int l = 0; l < lanes; ++l) element[l] = colours.order[std::min(k + l, end - 1)];
      add(element, first_lanes(end - k));
    }
  }
}

}  // namespace

void forces_recompute(const Elements<Real>& elements, const Vectors<Real>& position, State<Real>& state,
                      Vectors<Real>& force) {
  const Vector3<Real*> f = pointers(force);
  with_links_of(elements, [&](auto springs, auto bending) {
#pragma omp parallel
    {
      pack(elements, position, state.records);
      // A slice writes its own vertices' forces, and the directions of its own links.
#pragma omp for schedule(static)
      for (int slice = 0; slice < elements.slices(); ++slice) {
        const Vector3<floatv> sum =
            add_links<decltype(springs), decltype(bending)>(elements, state.records.data(), slice, state);
        store(f, lanes * slice, add_elements(elements, state.records.data(), slice, sum),
              first_lanes(elements.vertices - lanes * slice));
      }
    }
  });
}

void forces_colours(const Elements<Real>& elements, const Colours& colours, const Vectors<Real>& position,
                    Vectors<Real>& force) {
  Array<Real> room = make_records(elements), sums = make_records(elements);
  const Real* const records = room.data();
  Real* const sum = sums.data();
  const Vector3<Real*> f = pointers(force);
#pragma omp parallel
  {
    pack(elements, position, room);
    for_each_colour(colours.links, [&](const std::int32_t* link, maskv inside) {
      const intv k = load(link);
      std::int32_t from[lanes], to[lanes];
      store(from, gather(elements.from.data(), k)), store(to, gather(elements.to.data(), k));
      const Vector3<floatv> d = load_records_at(records, to) - load_records_at(records, from);
      Vector3<floatv> part = {0.f, 0.f, 0.f};
      if (elements.has_bending) part = gather(elements.bending.data(), k) * d;
      if (elements.has_springs) {
        const maskv are_edges = k < elements.edges;
        const auto field = [&](const Array<Real>& array) { return gather(array.data(), k, are_edges); };
        const Pull<floatv> pull =
            pull_of_spring(field(elements.rest_length), field(elements.spring), field(elements.root_of_damping), d);
        part = select(are_edges, part + pull.force, part);
      }
      add_at(sum, from, part, inside), add_at(sum, to, -part, inside);
    });
    for_each_colour(colours.membranes, [&](const std::int32_t* membrane, maskv inside) {
      std::int32_t vertex[3][lanes];
      const Parts<floatv, 3> parts = parts_of_membranes_at(elements, membrane, records, vertex);
      for (int c = 0; c < 3; ++c) add_at(sum, vertex[c], parts.of[c], inside);
    });
    for_each_colour(colours.hinges, [&](const std::int32_t* hinge, maskv inside) {
      std::int32_t vertex[4][lanes];
      const Parts<floatv, 4> parts = parts_of_hinges_at(elements, hinge, records, vertex);
      for (int c = 0; c < 4; ++c) add_at(sum, vertex[c], parts.of[c], inside);
    });
    // A slice writes its own vertices' forces.
#pragma omp for schedule(static)
    for (int slice = 0; slice < elements.slices(); ++slice)
      store(f, lanes * slice, load_sixteen(sum + 4 * lanes * static_cast<std::size_t>(slice)),
            first_lanes(elements.vertices - lanes * slice));
  }
}

}  // namespace lockstep::production_cloth::openmp
