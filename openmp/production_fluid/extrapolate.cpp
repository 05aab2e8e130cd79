// Continues the liquid's velocity into the air.
//
// The algorithm and its serial form stand in serial/production_fluid/extrapolate.cpp. Nothing is sorted: a face needs
// its nearer neighbours to be done, and no other order. Each face that is sought counts how many of them it waits for;
// those that are known from the start are done.
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
#include <array>
#include <atomic>
#include <bit>
#include <cstdint>
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

// The faces of a component that are sought: unknown from the start, and near enough. A bit a face, a word for each
// vector of sixteen; one more word behind each line, and lines around the box, are 0.
class Sought {
 public:
  explicit Sought(const Field<Real>& velocity)
      : vectors_(velocity.nx / lanes + 2),
        lines_(velocity.ny + 2),
        words_(std::size_t(vectors_) * lines_ * (velocity.nz + 2) + 1) {}
  std::uint16_t* line(int y, int z) { return &words_[place(y, z)]; }
  const std::uint16_t* line(int y, int z) const { return &words_[place(y, z)]; }

 private:
  std::size_t place(int y, int z) const { return (std::size_t(lines_) * (z + 1) + y + 1) * vectors_ + 1; }

  int vectors_, lines_;
  std::vector<std::uint16_t> words_;
};

// The lines of a component's words beside a line: itself, and those along -y, +y, -z and +z.
struct Words {
  const std::uint16_t *here, *low_y, *high_y, *low_z, *high_z;

  Words(const Sought& sought, int y, int z)
      : here(sought.line(y, z)),
        low_y(sought.line(y - 1, z)),
        high_y(sought.line(y + 1, z)),
        low_z(sought.line(y, z - 1)),
        high_z(sought.line(y, z + 1)) {}
  // Whether one of vector v's faces is sought, or may be beside one that is.
  bool any_near(int v) const {
    return (here[v - 1] | here[v] | here[v + 1] | low_y[v] | high_y[v] | low_z[v] | high_z[v]) != 0;
  }
  // Which of the neighbours of vector v's faces are sought, in the order of a face's links.
  std::array<maskv, 6> beside(int v) const {
    const std::uint32_t before = std::uint32_t(here[v]) << 1 | here[v - 1] >> (lanes - 1),
                        behind = here[v] >> 1 | std::uint32_t(here[v + 1]) << (lanes - 1);
    return {lanes_of(before & 0xffff), lanes_of(behind & 0xffff), lanes_of(low_y[v]),
            lanes_of(high_y[v]),       lanes_of(low_z[v]),        lanes_of(high_z[v])};
  }
};

// The links of a face that is sought, as bits: one for each nearer neighbour; one for each that is farther and waits;
// and the number of nearer neighbours that it waits for.
constexpr int nearer_bit = 0, farther_bit = 6, waits_bit = 12;

// Of a component, each in the order of its field. Only near faces that are sought is anything written.
struct Band {
  Real* distance;  // from the liquid; far of faces that turn out unknown, and beyond the ends of a line
  std::int32_t* links;
  std::vector<std::vector<std::int32_t>> free;  // [z]: faces that wait for nothing
};

// Finds the faces of a line that are sought, and sets the velocity of those too far away to 0.
void find_sought(const Beside<Real>& line, int count, Real distance, Real* velocity, std::uint16_t* sought) {
  const auto& [a, b] = line;
  for (int x = 0; x < count; x += lanes) {
    const floatv phi_a = load(&a.phi[x]), solid_a = load(&a.solid[x]);
    const floatv phi_b = load(&b.phi[x]), solid_b = load(&b.solid[x]);
    const maskv unknown = first_lanes(count - x) & ~is_known(phi_a, solid_a, phi_b, solid_b);
    if (none(unknown)) continue;
    const maskv near = distance_of_face(phi_a, solid_a, phi_b, solid_b) <= distance, beyond = unknown & ~near;
    sought[x / lanes] = static_cast<std::uint16_t>(bits(unknown & near));
    // Most are 0 already: lines of the cache that are not written need not go back to memory.
    if (any(beyond & (bits_of(load(&velocity[x])) != intv(0)))) store(&velocity[x], 0.f, beyond);
  }
}

// Finds the distances of a line's faces, where one that is sought may need them.
void find_distances(const Beside<Real>& line, int count, const Words& words, Real* of_faces) {
  const auto& [a, b] = line;
  if (words.here[0] != 0) of_faces[-1] = far<Real>;
  for (int x = 0; x <= count; x += lanes) {  // with one beyond
    if (!words.any_near(x / lanes)) continue;
    const floatv of_face = distance_of_face(load(&a.phi[x]), load(&a.solid[x]), load(&b.phi[x]), load(&b.solid[x]));
    store(&of_faces[x], select(first_lanes(count - x), of_face, far<Real>));
  }
}

// Makes the links of a line of faces; calls free(x) for those that wait for nothing. `nothing` is a line of `far`.
template <class Free>
void link(const Words& words, const Field<Real>& velocity, int y, int z, const Real* nothing, const Band& band,
          const Free& free) {
  const auto at = [&](int y, int z) -> const Real* {
    if (y < 0 || y >= velocity.ny || z < 0 || z >= velocity.nz) return nothing;
    return band.distance + velocity.index(0, y, z);
  };
  const Real* const here = at(y, z);
  const Real* const beside[] = {here - 1, here + 1, at(y - 1, z), at(y + 1, z), at(y, z - 1), at(y, z + 1)};
  for (int x = 0; x < velocity.nx; x += lanes) {
    if (words.here[x / lanes] == 0) continue;
    const maskv linked = lanes_of(words.here[x / lanes]);
    const std::array<maskv, 6> sought = words.beside(x / lanes);
    const floatv of_face = load(&here[x]);
    intv links(0);
    for (int n = 0; n < 6; ++n) {
      const floatv other = load(&beside[n][x]);
      where(other < of_face, links) |= intv(1 << (nearer_bit + n));
      where(sought[n] & (other < of_face), links) += intv(1 << waits_bit);
      where(sought[n] & (other > of_face), links) |= intv(1 << (farther_bit + n));
    }
    store(band.links + velocity.index(x, y, z), links, linked);
    const maskv waits_for_nothing = linked & (links < intv(1 << waits_bit));
    for (std::uint32_t rest = bits(waits_for_nothing); rest != 0; rest &= rest - 1) free(x + std::countr_zero(rest));
  }
}

// Computes up to sixteen faces that wait for nothing. load_at(p, step, mask) loads elements of an array, `step` away
// from those of the faces. Neighbours are read only if they are nearer, which is to say done: another thread may be at
// work on the others.
template <class LoadAt>
void complete(const Band& band, const std::int32_t (&step)[6], const std::int32_t* face, maskv there,
              const LoadAt& load_at, Field<Real>& velocity) {
  const intv links = load_at(band.links, 0, there);
  const floatv of_face = load_at(band.distance, 0, there);
  const auto neighbour = [&](int n) -> Neighbour<floatv> {
    const maskv nearer = there & ((links & intv(1 << (nearer_bit + n))) != intv(0));
    return {select(nearer, load_at(band.distance, step[n], nearer), far<Real>),
            load_at(velocity.value.data(), step[n], nearer)};
  };
  Continued<floatv> result;
  for (int axis = 0; axis < 3; ++axis) add_axis(of_face, neighbour(2 * axis), neighbour(2 * axis + 1), result);
  Real found[lanes];
  store(found, result.velocity);
  for (std::uint32_t rest = bits(there); rest != 0; rest &= rest - 1) {
    const int l = std::countr_zero(rest);
    velocity.value[face[l]] = found[l];  // 0 where no axis counts
  }
  const std::uint32_t unknown = bits(there & ~(result.weight > 0.f));
  for (std::uint32_t rest = unknown; rest != 0; rest &= rest - 1)
    band.distance[face[std::countr_zero(rest)]] = far<Real>;
}

// The same. Where faces stand side by side, loads take the place of gathers, which are many times as slow.
void complete(const Band& band, const std::int32_t (&step)[6], const std::int32_t* face, int count,
              Field<Real>& velocity) {
  const maskv there = first_lanes(count);
  const intv at = load(face, there);
  if (none(there & (at != face[0] + lane_index())))
    complete(
        band, step, face, there, [&](auto* p, int away, maskv mask) { return load(p + face[0] + away, mask); },
        velocity);
  else
    complete(
        band, step, face, there, [&](auto* p, int away, maskv mask) { return gather(p, at + away, mask); }, velocity);
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

// Finds the faces that are sought, of all components at once: they read the same cells.
void find_sought(const Fluid<Real>& fluid, const Lines<Real>& lines, Real distance, Field<Real>* const (&component)[3],
                 Sought (&sought)[3]) {
  // A line writes its own velocities and words.
#pragma omp parallel for collapse(2) schedule(static)
  for (int z = 0; z <= fluid.nz; ++z)
    for (int y = 0; y <= fluid.ny; ++y)
      for (int axis = 0; axis < 3; ++axis) {
        Field<Real>& velocity = *component[axis];
        if (y < velocity.ny && z < velocity.nz)
          find_sought(beside(fluid, lines, axis, y, z), velocity.nx, distance, &velocity(0, y, z),
                      sought[axis].line(y, z));
      }
}

void continue_component(const Fluid<Real>& fluid, const Lines<Real>& lines, int axis, const Sought& sought,
                        Field<Real>& velocity, Band band) {
  const int planes = velocity.nz, along_y = velocity.pitch, along_z = velocity.pitch * velocity.ny;
  const std::int32_t step[] = {-1, 1, -along_y, along_y, -along_z, along_z};
  const std::vector<Real> nothing(velocity.pitch, far<Real>);
  band.free.resize(planes);
  Failure failure;
#pragma omp parallel
  {
    // A line writes its own distances.
#pragma omp for collapse(2) schedule(static)
    for (int z = 0; z < planes; ++z)
      for (int y = 0; y < velocity.ny; ++y)
        find_distances(beside(fluid, lines, axis, y, z), velocity.nx, Words(sought, y, z),
                       band.distance + velocity.index(0, y, z));
        // A plane writes its own links and list, and reads distances, which are done.
#pragma omp for schedule(static)
    for (int z = 0; z < planes; ++z)
      failure.guard([&] {
        for (int y = 0; y < velocity.ny; ++y)
          link(Words(sought, y, z), velocity, y, z, nothing.data(), band,
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
  Field<Real>* const component[] = {&faces.u, &faces.v, &faces.w};
  Sought sought[] = {Sought(faces.u), Sought(faces.v), Sought(faces.w)};
  find_sought(fluid, lines, distance, component, sought);
  const std::size_t size = std::max({faces.u.value.size(), faces.v.value.size(), faces.w.value.size()});
  const LargePages distances(size), links(size);
  const Band band = {distances.floats(), reinterpret_cast<std::int32_t*>(links.floats()), {}};
  for (int axis = 0; axis < 3; ++axis) continue_component(fluid, lines, axis, sought[axis], *component[axis], band);
}

}  // namespace lockstep::production_fluid::openmp
