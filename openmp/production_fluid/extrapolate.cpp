// Continues the liquid's velocity into the air.
//
// The algorithm and its serial form stand in serial/production_fluid/extrapolate.cpp. Nothing is sorted: a face needs
// its nearer neighbours to be done, and no other order. Each face near the liquid counts how many of them it waits for.
// The thread that completes a face takes one off the count of each farther neighbour, and where that was the last,
// works on that neighbour next. So threads meet at no barrier while they visit faces, however long the chain from face
// to face: on a surface that slopes a little, it is as long as the box, and levels of faces with a barrier behind each
// would be as many. A face gets the same bits from any thread, at any time (the contract says why).
//
// A thread has a stack of faces that wait for nothing, and takes sixteen at a time.
//
// The contract stands in common/production_fluid/extrapolate.h.
#include "common/production_fluid/extrapolate.h"

#include <algorithm>
#include <atomic>
#include <memory>
#include <vector>

#include "common/levelset/field.h"
#include "common/real.h"
#include "common/simd.h"
#include "openmp/failure.h"
#include "openmp/large_pages.h"

namespace lockstep::production_fluid::openmp {
namespace {

using namespace lockstep::openmp;
using levelset::far;

// The links of a face near the liquid, as bits: one for each nearer neighbour; one for each that is farther, but near
// enough to be waiting; whether the face is known from the start; and the number of nearer neighbours that it waits
// for.
constexpr int nearer_bit = 0, farther_bit = 6, known_bit = 12, waits_bit = 13;

// Of a component, each in the order of its field. A face whose distance is between 0 and the one asked for is in the
// band and has links, known or not.
struct Band {
  Real* distance;  // from the liquid; far of faces that turn out unknown, and beyond the ends of a line
  std::int32_t* links;
  std::vector<std::vector<std::int32_t>> free;  // [z]: faces that wait for nothing
};

// Finds the distances of a line of faces, and sets the velocity of those too far away to 0.
void find_known(const Beside<Real>& line, int count, Real distance, Real* of_faces, Real* velocity) {
  const auto& [a, b] = line;
  of_faces[-1] = far<Real>;
  for (int x = 0; x <= count; x += lanes) {  // with one beyond
    const maskv in_line = first_lanes(count - x);
    const floatv phi_a = load(&a.phi[x]), solid_a = load(&a.solid[x]);
    const floatv phi_b = load(&b.phi[x]), solid_b = load(&b.solid[x]);
    const floatv of_face = distance_of_face(phi_a, solid_a, phi_b, solid_b);
    store(&of_faces[x], select(in_line, of_face, far<Real>));
    const maskv known = is_known(phi_a, solid_a, phi_b, solid_b), beyond = in_line & ~known & (of_face > distance);
    // Most are 0 already: lines of the cache that are not written need not go back to memory.
    if (any(beyond & (bits_of(load(&velocity[x])) != intv(0)))) store(&velocity[x], 0.f, beyond);
  }
}

// Makes the links of a line of faces; calls free(x) for those that wait for nothing. `nothing` is a line of `far`.
template <class Free>
void link(const Beside<Real>& line, const Field<Real>& velocity, int y, int z, Real distance, const Real* nothing,
          const Band& band, const Free& free) {
  const auto at = [&](int y, int z) -> const Real* {
    if (y < 0 || y >= velocity.ny || z < 0 || z >= velocity.nz) return nothing;
    return band.distance + velocity.index(0, y, z);
  };
  const Real* const here = at(y, z);
  const Real* const beside[] = {here - 1, here + 1, at(y - 1, z), at(y + 1, z), at(y, z - 1), at(y, z + 1)};
  const auto in_band = [&](floatv of_face) { return (of_face > 0.f) & (of_face <= distance); };
  for (int x = 0; x < velocity.nx; x += lanes) {
    const floatv of_face = load(&here[x]);
    const maskv linked = first_lanes(velocity.nx - x) & in_band(of_face);
    if (none(linked)) continue;
    const auto& [a, b] = line;
    const maskv known = is_known(load(&a.phi[x]), load(&a.solid[x]), load(&b.phi[x]), load(&b.solid[x]));
    intv links = select(known, intv(1 << known_bit), intv(0));
    for (int n = 0; n < 6; ++n) {
      const floatv other = load(&beside[n][x]);
      const maskv waits = in_band(other);
      where(other < of_face, links) |= intv(1 << (nearer_bit + n));
      where(waits & (other < of_face), links) += intv(1 << waits_bit);
      where(waits & (other > of_face), links) |= intv(1 << (farther_bit + n));
    }
    store(band.links + velocity.index(x, y, z), links, linked);
    const maskv waits_for_nothing = linked & (links < intv(1 << waits_bit));
    for (std::uint32_t rest = bits(waits_for_nothing); rest != 0; rest &= rest - 1) free(x + std::countr_zero(rest));
  }
}

// Computes up to sixteen faces that wait for nothing. Neighbours are read only if they are nearer, which is to say
// done: another thread may be at work on the others.
void complete(const Band& band, const std::int32_t (&step)[6], const std::int32_t* face, int count,
              Field<Real>& velocity) {
  const maskv there = first_lanes(count);
  const intv at = load(face, there), links = gather(band.links, at, there);
  const floatv of_face = gather(band.distance, at, there);
  const auto neighbour = [&](int n) -> Neighbour<floatv> {
    const maskv nearer = there & ((links & intv(1 << (nearer_bit + n))) != intv(0));
    const intv index = at + intv(step[n]);
    return {select(nearer, gather(band.distance, index, nearer), far<Real>),
            gather(velocity.value.data(), index, nearer)};
  };
  Continued<floatv> result;
  for (int axis = 0; axis < 3; ++axis) add_axis(of_face, neighbour(2 * axis), neighbour(2 * axis + 1), result);
  const maskv sought = there & ((links & intv(1 << known_bit)) == intv(0));
  Real found[lanes];
  store(found, result.velocity);
  for (std::uint32_t rest = bits(sought); rest != 0; rest &= rest - 1) {
    const int l = std::countr_zero(rest);
    velocity.value[face[l]] = found[l];  // 0 where no axis counts
  }
  const std::uint32_t unknown = bits(sought & ~(result.weight > 0.f));
  for (std::uint32_t rest = unknown; rest != 0; rest &= rest - 1)
    band.distance[face[std::countr_zero(rest)]] = far<Real>;
}

// Takes one off the number of faces that a face waits for; returns whether that was the last. Each thread releases what
// it wrote, and the thread that takes the last acquires what all of them wrote.
bool take_one_off(std::int32_t& links) {
  const std::atomic_ref waits(links);
  // A thread that finds a count of 1 is the last: no other will touch the count, and it need not be written.
  return waits.load(std::memory_order_acquire) >> waits_bit == 1 ||
         waits.fetch_sub(1 << waits_bit, std::memory_order_acq_rel) >> waits_bit == 1;
}

// Works on a stack of faces that wait for nothing, and on those that then wait for nothing.
void visit(const Band& band, const std::int32_t (&step)[6], std::vector<std::int32_t>& stack, Field<Real>& velocity) {
  while (!stack.empty()) {
    std::int32_t face[lanes];
    const int count = static_cast<int>(std::min<std::size_t>(stack.size(), lanes));
    std::copy_n(stack.end() - count, count, face);
    stack.resize(stack.size() - count);
    complete(band, step, face, count, velocity);
    for (int k = 0; k < count; ++k) {
      const std::uint32_t farther = static_cast<std::uint32_t>(band.links[face[k]]) >> farther_bit & 0x3f;
      for (std::uint32_t rest = farther; rest != 0; rest &= rest - 1) {
        const std::int32_t other = face[k] + step[std::countr_zero(rest)];
        if (take_one_off(band.links[other])) stack.push_back(other);
      }
    }
  }
}

void continue_component(const Fluid<Real>& fluid, const Lines<Real>& lines, int axis, Real distance,
                        Field<Real>& velocity, Band band) {
  const int planes = velocity.nz, along_y = velocity.pitch, along_z = velocity.pitch * velocity.ny;
  const std::int32_t step[] = {-1, 1, -along_y, along_y, -along_z, along_z};
  const std::vector<Real> nothing(velocity.pitch, far<Real>);
  band.free.resize(planes);
  Failure failure;
#pragma omp parallel
  {
    // A line writes its own distances and velocities.
#pragma omp for collapse(2) schedule(static)
    for (int z = 0; z < planes; ++z)
      for (int y = 0; y < velocity.ny; ++y)
        find_known(beside(fluid, lines, axis, y, z), velocity.nx, distance, band.distance + velocity.index(0, y, z),
                   &velocity(0, y, z));
        // A plane writes its own links and list, and reads distances, which are done.
#pragma omp for schedule(static)
    for (int z = 0; z < planes; ++z)
      failure.guard([&] {
        for (int y = 0; y < velocity.ny; ++y)
          link(beside(fluid, lines, axis, y, z), velocity, y, z, distance, nothing.data(), band,
               [&](int x) { band.free[z].push_back(static_cast<std::int32_t>(velocity.index(x, y, z))); });
      });
      // A face is worked on by one thread, after all faces that it reads: by the one with its plane's list or, by an
      // atomic count, by the one that completed the last of those. Planes differ in work, hence dynamic.
#pragma omp for schedule(dynamic)
    for (int z = 0; z < planes; ++z)
      if (!failure.happened()) failure.guard([&] { visit(band, step, band.free[z], velocity); });
  }
  failure.rethrow();
}

}  // namespace

void extrapolate(const Fluid<Real>& fluid, Real distance, Faces<Real>& faces) {
  const Lines<Real> lines(fluid);
  const std::size_t size = std::max({faces.u.value.size(), faces.v.value.size(), faces.w.value.size()});
  const LargePages distances(size);
  // Few pages of the links are ever touched.
  const auto links = std::make_unique_for_overwrite<std::int32_t[]>(size);
  const Band band = {distances.floats(), links.get(), {}};
  continue_component(fluid, lines, 0, distance, faces.u, band);
  continue_component(fluid, lines, 1, distance, faces.v, band);
  continue_component(fluid, lines, 2, distance, faces.w, band);
}

}  // namespace lockstep::production_fluid::openmp
