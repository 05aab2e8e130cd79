// The elastic forces of a cloth.
//
// The algorithm stands in serial/production_cloth/forces.cpp. Elements that share a vertex would write to it together.
// So a vertex goes through its links itself, sixteen vertices at once: a link is computed twice, once from either end,
// where it has the same bits but for the sign. Membranes, which would be computed three times, are taken sixteen at a
// time and store their parts; folding triangles store what they push their corners with. A hinge is computed twice,
// from either side, and has the same bits. Vertices add up in the order of the elements: the serial bits. Neighbours
// and corners are picked from the slices that they stand in (picks.h).
//
// Three contrasts. A vertex computes membranes and hinges itself: the same bits, and nothing but facets is stored.
// Elements in colours add to their vertices at once, sixteen together. Or threads add each part under its vertex's lock
// ([ITJ07]).
//
// The contract stands in common/production_cloth/forces.h.
#include "common/production_cloth/forces.h"

#include <algorithm>

#include "common/real.h"
#include "openmp/production_cloth/colours.h"
#include "openmp/production_cloth/facets.h"
#include "openmp/production_cloth/picks.h"
#include "openmp/share.h"

namespace lockstep::production_cloth::openmp {
namespace {

template <class Springs, class Bending>
LOCKSTEP_INLINE Vector3<floatv> add_links(const Elements<Real>& elements, int slice, State<Real>& state) {
  const Real* const slices = state.slices.data();
  const Vector3<floatv> own = load_three(slices + lanes * slice_vectors * std::size_t(slice));
  Vector3<floatv> sum = {0.f, 0.f, 0.f};
  for (std::size_t k = elements.edges_at.first[slice]; k < std::size_t(elements.edges_at.first[slice + 1]); ++k) {
    const Vector3<floatv> d = pick_vectors(elements.edge_picks, k, slices, own)[0] - own;
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
      sum =
          sum + load(&elements.far_bending_at[lanes * k]) * (pick_vectors(elements.far_picks, k, slices, own)[0] - own);
  return sum;
}

// x: positions of corners.
Parts<floatv, 3> parts_of_membranes(const Elements<Real>& elements, const std::array<Vector3<floatv>, 3>& x, int block,
                                    Columns<floatv>& f) {
  const Vector3<floatv> x0 = x[0], x1 = x[1], x2 = x[2];
  const Membrane<floatv> m =
      membrane_of<floatv>(elements, [&](const Blocked<Real>& array, int k) { return load(array.vector(block, k)); });
  f = deformation_of(m, x1 - x0, x2 - x0);
  return parts_of_membrane(m, stress_of_membrane(elements, f));
}

// Facets. Called by all threads of a team, as are the two below.
void set_facets(const Elements<Real>& elements, State<Real>& state) {
  // A block writes its own facets.
#pragma omp for schedule(static)
  for (int block = 0; block < elements.facet_blocks(); ++block) {
    const std::array<Vector3<floatv>, 3> corners = pick_corners(elements, state.slices.data(), block);
    const auto x = [&](int c) { return corners[c]; };
    const Facet<floatv> facet = facet_of(x(0), x(1), x(2));
    store_sixteen(&state.normals[facet_records(block)], facet.normal, facet.size);
    for (int c = 0; c < 3; ++c) store(&state.cotangents[corner_place(block, c)], facet.at[c]);
  }
}

void store_pushes(const Elements<Real>& elements, State<Real>& state) {
  // A block writes its own pushes and resistances; it reads facets, which are all there.
#pragma omp for schedule(static) nowait
  for (int block = 0; block < elements.facet_blocks(); ++block) {
    const Quads own = load_sixteen_quads(&state.normals[facet_records(block)]);
    const auto keep = [&](int c, floatv resistance) { store(&state.resistance[corner_place(block, c)], resistance); };
    const auto x = pick_corners(elements, state.slices.data(), block);
    const Sides<floatv> push = pushes_of_facets(elements, state, x, own, OfBlock{block}, keep);
    for (int c = 0; c < 3; ++c) store(&state.pushes[corner_place(block, c)], push.of[c]);
  }
}

void store_membranes(const Elements<Real>& elements, State<Real>& state) {
  // A block writes its own parts and state.
#pragma omp for schedule(static) nowait
  for (int block = 0; block < elements.membrane_corner_blocks(); ++block) {
    Columns<floatv> f;
    const auto x = pick_corners(elements, state.slices.data(), block);
    store_parts(parts_of_membranes(elements, x, block, f), &state.parts[membrane_parts(block)]);
    store_fields(state.deformation, block, 0, f.x), store_fields(state.deformation, block, 3, f.y);
  }
}

}  // namespace

State<Real> make_state(const Elements<Real>& elements) {
  State<Real> state = make_state_of_blocks(elements);
  if (elements.has_springs) state.along.resize(3 * elements.edges_at.at.size());
  state.normals.resize(4 * lanes * std::size_t(elements.facet_blocks()));
  state.cotangents.resize(state.resistance.size());
  state.slices.resize(lanes * slice_vectors * std::size_t(elements.slices()));
  state.records = make_records(elements), state.parts = make_parts(elements), state.pushes = make_pushes(elements);
  return state;
}

void forces(const Elements<Real>& elements, const Vectors<Real>& position, State<Real>& state, Vectors<Real>& force) {
  const Vector3<Real*> f = pointers(force);
  const auto normals = [&](std::size_t k) { return gather_normals(elements, state, k); };
  with_links_of(elements, [&](auto springs, auto bending) {
#pragma omp parallel
    {
      pack_slices(elements, position, state.slices);
      if (elements.membranes > 0) store_membranes(elements, state);
      if (elements.facets > 0) set_facets(elements, state), store_pushes(elements, state);
      // Parts and pushes of other threads' blocks are read below.
      if (elements.membranes > 0 || elements.facets > 0) {
#pragma omp barrier
      }
      // A slice writes its own vertices' forces, and the directions of its own links.
#pragma omp for schedule(static)
      for (int slice = 0; slice < elements.slices(); ++slice) {
        std::array<Vector3<floatv>, 1> sum = {add_links<decltype(springs), decltype(bending)>(elements, slice, state)};
        if (elements.membranes > 0) sum[0] = add_parts(elements.corners_at, state.parts.data(), slice, sum[0]);
        if (elements.facets > 0) add_pushes<1>(elements.corners_at, {state.pushes}, slice, normals, sum);
        store(f, lanes * slice, sum[0], first_lanes(elements.vertices - lanes * slice));
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

void forces_locks(const Elements<Real>& elements, const Vectors<Real>& position, State<Real>& state,
                  Vectors<Real>& force) {
  for (Array<Real>* component : {&force.x, &force.y, &force.z})
    std::fill_n(component->begin(), elements.vertices, Real(0));
  lockstep::openmp::Locks locks(elements.vertices);
  const Real* const records = state.records.data();
#pragma omp parallel
  {
    pack(elements, position, state.records), pack_slices(elements, position, state.slices);
    set_facets(elements, state), store_pushes(elements, state);
    // A vertex is written under its lock, as below. Threads with whole directions of links would meet at each vertex.
#pragma omp for schedule(static, 256) nowait
    for (int k = 0; k < elements.links; k += lanes) {
      const Vector3<floatv> part = parts_of_links(elements, records, k);
      add_under_locks(&elements.from[k], part, elements.links - k, locks, force);
      add_under_locks(&elements.to[k], -part, elements.links - k, locks, force);
    }
    // See above.
#pragma omp for schedule(static) nowait
    for (int block = 0; block < elements.membrane_corner_blocks(); ++block) {
      Columns<floatv> f;
      const auto x = pick_corners(elements, state.slices.data(), block);
      const Parts<floatv, 3> parts = parts_of_membranes(elements, x, block, f);
      for (int c = 0; c < 3; ++c)
        add_under_locks(elements.membrane_corner.vector(block, c), parts.of[c], elements.membranes - lanes * block,
                        locks, force);
    }
    // See above; a block's pushes are stored by the thread that reads them.
#pragma omp for schedule(static)
    for (int block = 0; block < elements.facet_blocks(); ++block)
      for (int c = 0; c < 3; ++c) {
        const std::size_t place = corner_place(block, c);
        const Vector3<floatv> normals = load_sixteen(&state.normals[facet_records(block)]);
        add_under_locks(&elements.facet_corner[place], load(&state.pushes[place]) * normals,
                        elements.facets - lanes * block, locks, force);
      }
  }
}

namespace {

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

// The parts of sixteen membranes; vertex[c]: their corners.
template <class Index>
Parts<floatv, 3> parts_of_membranes_at(const Elements<Real>& elements, const Index& element, const Real* records,
                                       std::int32_t (*vertex)[lanes]) {
  const auto x = [&](int c) { return corner_of(elements.membrane_corner, element, c, records, vertex[c]); };
  const Vector3<floatv> x0 = x(0), x1 = x(1), x2 = x(2);
  const Membrane<floatv> m =
      membrane_of<floatv>(elements, [&](const Blocked<Real>& array, int k) { return field_of(array, element, k); });
  return parts_of_membrane(m, stress_of_membrane(elements, deformation_of(m, x1 - x0, x2 - x0)));
}
// Adds up what the membranes and hinges at a slice's vertices give to them.
Vector3<floatv> add_elements(const Elements<Real>& elements, const State<Real>& state, int slice, Vector3<floatv> sum) {
  const auto for_each_corner = [&](const auto& f) {
    for (int item = elements.corners_at.first[slice]; item < elements.corners_at.first[slice + 1]; ++item) {
      // What fills up has the last place, and is as triangle 0, which is not meant.
      const std::size_t k = lanes * static_cast<std::size_t>(item);
      const maskv are_meant = load(&elements.corners_at.at[k]) < elements.last_place();
      AtPlaces at;
      std::int32_t corner[lanes];
      for (int l = 0; l < lanes; ++l) {
        const int own = elements.corners_at.at[k + l] < elements.last_place() ? elements.corners_at.at[k + l] : 0;
        corner[l] = own / lanes % 3;
        for (int c = 0; c < 3; ++c) at.place[c][l] = own + lanes * (c - corner[l]);
      }
      f(&elements.facet_at[k], at, load(corner), are_meant);
    }
  };
  if (elements.membranes > 0)
    for_each_corner([&](const std::int32_t* membrane, const AtPlaces&, intv corner, maskv are_meant) {
      std::int32_t vertex[3][lanes];
      const Parts<floatv, 3> parts = parts_of_membranes_at(elements, membrane, state.records.data(), vertex);
      const Vector3<floatv> part = select(corner == 0, parts.of[0], select(corner == 1, parts.of[1], parts.of[2]));
      sum = sum + select(are_meant, part, Vector3<floatv>{0.f, 0.f, 0.f});
    });
  if (elements.facets > 0)
    for_each_corner([&](const std::int32_t* facet, const AtPlaces& at, intv corner, maskv are_meant) {
      const Quads own = load_quads(state.normals.data(), facet);
      const auto x = [&](int c) {
        return load_records_at(state.records.data(), &at.indices(elements.facet_corner, c)[0]);
      };
      const Sides<floatv> all = pushes_of_facets(elements, state, {x(0), x(1), x(2)}, own, at, [](int, floatv) {});
      const floatv push = select(corner == 0, all.of[0], select(corner == 1, all.of[1], all.of[2]));
      sum = sum + select(are_meant, push, floatv(0.f)) * normals_of(own);
    });
  return sum;
}

// Adds sixteen parts to different vertices.
LOCKSTEP_INLINE void add_at(Real* force, const std::int32_t* vertex, const Vector3<floatv>& part, maskv mask) {
  const Vector3<floatv> sum = load_records_at(force, vertex) + part;
  store_quads(force, vertex, {{sum.x, sum.y, sum.z, floatv(0.f)}}, mask);
}

}  // namespace

void forces_recompute(const Elements<Real>& elements, const Vectors<Real>& position, State<Real>& state,
                      Vectors<Real>& force) {
  const Vector3<Real*> f = pointers(force);
  with_links_of(elements, [&](auto springs, auto bending) {
#pragma omp parallel
    {
      pack(elements, position, state.records), pack_slices(elements, position, state.slices);
      set_facets(elements, state);
      // A slice writes its own vertices' forces, and the directions of its own links.
#pragma omp for schedule(static)
      for (int slice = 0; slice < elements.slices(); ++slice) {
        const Vector3<floatv> sum = add_links<decltype(springs), decltype(bending)>(elements, slice, state);
        store(f, lanes * slice, add_elements(elements, state, slice, sum),
              first_lanes(elements.vertices - lanes * slice));
      }
    }
  });
}

void forces_colours(const Elements<Real>& elements, const Colours& colours, const Vectors<Real>& position,
                    State<Real>& state, Vectors<Real>& force) {
  Array<Real> sums = make_records(elements);
  const Real* const records = state.records.data();
  Real* const sum = sums.data();
  const Vector3<Real*> f = pointers(force);
#pragma omp parallel
  {
    pack(elements, position, state.records), pack_slices(elements, position, state.slices);
    set_facets(elements, state), store_pushes(elements, state);
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
    if (elements.membranes > 0)
      for_each_colour(colours.triangles, [&](const std::int32_t* membrane, maskv inside) {
        std::int32_t vertex[3][lanes];
        const Parts<floatv, 3> parts = parts_of_membranes_at(elements, membrane, records, vertex);
        for (int c = 0; c < 3; ++c) add_at(sum, vertex[c], parts.of[c], inside);
      });
    if (elements.facets > 0) {
      // Pushes of other threads' blocks are read below.
#pragma omp barrier
      for_each_colour(colours.triangles, [&](const std::int32_t* facet, maskv inside) {
        const Vector3<floatv> normals = load_records_at(state.normals.data(), facet);
        for (int c = 0; c < 3; ++c) {
          std::int32_t place[lanes], vertex[lanes];
          for (int l = 0; l < lanes; ++l) place[l] = elements.place_of(facet[l], c);
          for (int l = 0; l < lanes; ++l) vertex[l] = elements.facet_corner[place[l]];
          add_at(sum, vertex, load_each(state.pushes.data(), place) * normals, inside);
        }
      });
    }
    // A slice writes its own vertices' forces.
#pragma omp for schedule(static)
    for (int slice = 0; slice < elements.slices(); ++slice)
      store(f, lanes * slice, load_sixteen(sum + 4 * lanes * static_cast<std::size_t>(slice)),
            first_lanes(elements.vertices - lanes * slice));
  }
}

}  // namespace lockstep::production_cloth::openmp
