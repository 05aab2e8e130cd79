// Continues the liquid's velocity into the air.
//
// The algorithm and its serial form stand in serial/production_fluid/extrapolate.cpp. Nothing is sorted: a face needs
// its nearer neighbours to be done, and no other order. Each face that is sought counts how many of them it waits for;
// those that are known from the start are done. When a face is complete, one is taken off the count of each farther
// neighbour, and where that was the last, it is that neighbour's turn. A face gets the same bits whenever its turn
// comes (the contract says why).
//
// In a round, one thread works on a slab of planes, and follows chains of faces as long as they stay there. It lists
// the farther neighbours in the slabs beside. The threads that have those slabs in the next round read the lists,
// behind a barrier. So a count is written by one thread at a time, without atomic operations. There is a round for each
// time that the longest chain crosses from slab to slab. Levels of faces would need a barrier for each face of that
// chain, and on a surface that slopes a little the chain is as long as the box.
//
// A slab has a stack of faces that wait for nothing; sixteen are taken at a time.
//
// The contract stands in common/production_fluid/extrapolate.h.
#include "common/production_fluid/extrapolate.h"

#include <algorithm>
#include <array>
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
};

constexpr int planes_of_slab = 4;

// Faces begin .. end - 1. Aligned, so that threads at work on slabs share no line of the cache.
struct alignas(64) Slab {
  std::int32_t begin, end;
  std::vector<std::int32_t> free;                // faces that wait for nothing
  std::vector<std::int32_t> below[2], above[2];  // [round % 2]: faces of the slabs beside that wait for one less

  bool has_sent(int parity) const { return !below[parity].empty() || !above[parity].empty(); }
};

std::vector<Slab> make_slabs(const Field<Real>& velocity) {
  std::vector<Slab> slabs;
  for (int z = 0; z < velocity.nz; z += planes_of_slab) {
    const auto at = [&](int z) { return static_cast<std::int32_t>(velocity.index(0, 0, std::min(z, velocity.nz))); };
    slabs.push_back({.begin = at(z), .end = at(z + planes_of_slab), .free = {}, .below = {}, .above = {}});
  }
  return slabs;
}

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

// Takes one off the number of faces that a face of the slab waits for.
void take_one_off(const Band& band, std::int32_t face, Slab& slab) {
  std::int32_t& links = band.links[face];
  links -= 1 << waits_bit;
  if (links < 1 << waits_bit) slab.free.push_back(face);
}

// Works on a slab's faces that wait for nothing, and on those that then wait for nothing.
void visit(const Band& band, const std::int32_t (&step)[6], int parity, Slab& slab, Field<Real>& velocity) {
  while (!slab.free.empty()) {
    std::int32_t face[lanes];
    const int count = static_cast<int>(std::min<std::size_t>(slab.free.size(), lanes));
    std::copy_n(slab.free.end() - count, count, face);
    slab.free.resize(slab.free.size() - count);
    complete(band, step, face, count, velocity);
    for (int k = 0; k < count; ++k) {
      const std::uint32_t farther = static_cast<std::uint32_t>(band.links[face[k]]) >> farther_bit & 0x3f;
      for (std::uint32_t rest = farther; rest != 0; rest &= rest - 1) {
        const std::int32_t other = face[k] + step[std::countr_zero(rest)];
        if (other < slab.begin)
          slab.below[parity].push_back(other);
        else if (other >= slab.end)
          slab.above[parity].push_back(other);
        else
          take_one_off(band, other, slab);
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
                        const Band& band, Field<Real>& velocity) {
  const int along_y = velocity.pitch, along_z = velocity.pitch * velocity.ny;
  const std::int32_t step[] = {-1, 1, -along_y, along_y, -along_z, along_z};
  const std::vector<Real> nothing(velocity.pitch, far<Real>);
  std::vector<Slab> slabs = make_slabs(velocity);
  const int count = static_cast<int>(slabs.size());
  Failure failure;
#pragma omp parallel
  {
    // A line writes its own distances.
#pragma omp for collapse(2) schedule(static)
    for (int z = 0; z < velocity.nz; ++z)
      for (int y = 0; y < velocity.ny; ++y)
        find_distances(beside(fluid, lines, axis, y, z), velocity.nx, Words(sought, y, z),
                       band.distance + velocity.index(0, y, z));
        // A slab writes its own links and list, and reads distances, which are done.
#pragma omp for schedule(static)
    for (int s = 0; s < count; ++s)
      failure.guard([&] {
        for (int z = planes_of_slab * s; z < std::min(planes_of_slab * (s + 1), velocity.nz); ++z)
          for (int y = 0; y < velocity.ny; ++y)
            link(Words(sought, y, z), velocity, y, z, nothing.data(), band,
                 [&](int x) { slabs[s].free.push_back(static_cast<std::int32_t>(velocity.index(x, y, z))); });
      });
    bool is_done = false;
    for (int round = 0; !is_done; ++round) {
      const int now = round % 2, before = 1 - now;
      // A slab writes its own faces, links and lists of now. It reads faces of others that were complete before, and
      // their lists of before. Slabs differ in work, hence dynamic.
#pragma omp for schedule(dynamic)
      for (int s = 0; s < count; ++s)
        failure.guard([&] {
          Slab& slab = slabs[s];
          slab.below[now].clear(), slab.above[now].clear();
          if (failure.happened()) return;
          if (s > 0)
            for (const std::int32_t face : slabs[s - 1].above[before]) take_one_off(band, face, slab);
          if (s + 1 < count)
            for (const std::int32_t face : slabs[s + 1].below[before]) take_one_off(band, face, slab);
          visit(band, step, now, slab, velocity);
        });
      // The next round writes no list that is read here. The answer is the same for all threads.
      is_done = std::ranges::none_of(slabs, [&](const Slab& slab) { return slab.has_sent(now); });
    }
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
  const Band band = {distances.floats(), reinterpret_cast<std::int32_t*>(links.floats())};
  for (int axis = 0; axis < 3; ++axis) continue_component(fluid, lines, axis, sought[axis], band, *component[axis]);
}

}  // namespace lockstep::production_fluid::openmp
