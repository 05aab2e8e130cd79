// Evens out how many particles the blocks beside the surface hold.
//
// The algorithm and its serial form stand in serial/production_fluid/reseed.cpp. A block's particles and seeds are its
// own, so the only question is where they go. It is answered in three passes: which particles stay in each block, and
// how many are new; the new ones, in an array of their own; then all go to their places. Between the passes one thread
// adds up the numbers of the units.
//
// Lanes: sixteen blocks of a line (which have room), sixteen particles of a block (which stay), sixteen new particles
// of any blocks. Lanes that are done wait until the other new particles are in the band, or are given up.
//
// Threads: a unit is some lines of blocks. Units hold about as many particles and blocks as one another. New particles
// are shared as such, since they gather in few blocks.
//
// The contract stands in common/production_fluid/reseed.h.
#include "common/production_fluid/reseed.h"

#include <algorithm>
#include <memory>
#include <vector>

#include "common/real.h"
#include "common/simd.h"
#include "openmp/random.h"

namespace lockstep::production_fluid::openmp {
namespace {

using Index = std::int32_t;

// Lines of blocks begin .. end - 1, and what they hold.
struct Unit {
  int begin, end;
  Index kept = 0, seeds = 0;        // in this unit
  Index first = 0, first_seed = 0;  // in the units before
};

// What a pass leaves to the next.
struct Plan {
  std::vector<Unit> units;
  std::unique_ptr<Index[]> kept, seeds;  // of each block
  // Of the particles that came in: those that stay are the first `kept` from their block's first place on.
  std::unique_ptr<Index[]> from;
  std::unique_ptr<Real[]> rank;
  // Of each new particle: its block's cell, and its number in the block.
  std::unique_ptr<Index[]> x, y, z, number;
  // Then where it is, m. Those that were given up have sign 0.
  std::unique_ptr<Real[]> seed_x, seed_y, seed_z, radius, sign;
};

template <class T>
std::unique_ptr<T[]> room_for(std::size_t count) {
  return std::make_unique_for_overwrite<T[]>(padded(count));
}

// Up to a thousand units, so that threads can balance what blocks differ in.
std::vector<Unit> units_of(const Fluid<Real>& fluid, const Particles<Real>& particles) {
  const int lines = fluid.ny * fluid.nz, count = std::min(lines, 1024);
  // A particle takes about as long as four blocks.
  const auto work = [&](int line) {
    const std::int64_t block = std::int64_t(line) * fluid.nx;
    return block + (particles.count > 0 ? 4 * std::int64_t(particles.first[block]) : 0);
  };
  std::vector<Unit> units(count);
  for (int u = 0, line = 0; u < count; ++u) {
    units[u].begin = line;
    const std::int64_t until = work(lines) / count * (u + 1);
    int least = line, most = lines;  // the first line at which the work before it is enough
    while (least < most) {
      const int middle = (least + most) / 2;
      work(middle) < until ? least = middle + 1 : most = middle;
    }
    units[u].end = line = u + 1 < count ? least : lines;
  }
  return units;
}

// The blocks of a line from x on. Lanes beyond the line read its padding.
Corners<floatv> corners_of_line(const Field<Real>& field, int x, int y, int z) {
  const maskv inside = intv(x) + lane_index() < field.nx - 1;
  const int next_y = std::min(y + 1, field.ny - 1), next_z = std::min(z + 1, field.nz - 1);
  const Real* const line[] = {&field(x, y, z), &field(x, next_y, z), &field(x, y, next_z), &field(x, next_y, next_z)};
  Corners<floatv> corners;
  for (int k = 0; k < 4; ++k) {
    corners.value[2 * k] = load(line[k]);
    corners.value[2 * k + 1] = select(inside, load(line[k] + 1), load(line[k]));
  }
  return corners;
}

// The same block in all lanes.
Block<floatv> wide(const Block<Real>& block) {
  const auto vector = [](const Vector3<Real>& v) { return Vector3<floatv>{v.x, v.y, v.z}; };
  Block<floatv> all = {.low = vector(block.low),
                       .high = vector(block.high),
                       .corner = vector(block.corner),
                       .phi = {},
                       .solid = {},
                       .spacing = block.spacing,
                       .per_metre = block.per_metre};
  for (int k = 0; k < 8; ++k) all.phi.value[k] = block.phi.value[k], all.solid.value[k] = block.solid.value[k];
  return all;
}

// Puts those of a block's particles that stay into plan.from, in order, and returns how many they are.
int keep(const Block<Real>& of_block, const Particles<Real>& particles, int begin, int end, int per_block, Plan& plan) {
  const Block<floatv> block = wide(of_block);
  Index* const kept = &plan.from[begin];
  int count_kept = 0, escaped = 0;
  for (Index i = begin; i < end; i += lanes) {
    const maskv there = first_lanes(end - i);
    const floatv sign = load(&particles.sign[i]), radius = load(&particles.radius[i]);
    const floatv phi =
        phi_at(block, {load(&particles.position.x[i]), load(&particles.position.y[i]), load(&particles.position.z[i])});
    const maskv has_gone = there & has_escaped(sign, phi, radius);
    const maskv stays = there & (has_gone | !is_beyond(phi, block.spacing));
    escaped += count(has_gone);
    store(&plan.rank[i], rank_of(sign, phi, radius), there);
    store(kept + count_kept, compress(stays, i + lane_index()), first_lanes(count(stays)));
    count_kept += count(stays);
  }
  const int most = std::max(escaped, per_block);
  if (count_kept > most) {
    const auto ranks_before = [&](Index a, Index b) {
      return plan.rank[a] < plan.rank[b] || (plan.rank[a] == plan.rank[b] && a < b);
    };
    std::nth_element(kept, kept + most, kept + count_kept, ranks_before);
    std::sort(kept, kept + most);
    count_kept = most;
  }
  return count_kept;
}

// Finds which particles stay in each block of a unit, and how many are new.
void plan_unit(const Fluid<Real>& fluid, const ReseedSettings& settings, const Particles<Real>& particles, Unit& unit,
               Plan& plan) {
  const auto load_from = [](const Real* values) { return [values](Index at) { return values[at]; }; };
  const bool none = particles.count == 0;
  for (int line = unit.begin; line < unit.end; ++line) {
    const int y = line % fluid.ny, z = line / fluid.ny;
    for (int begin = 0; begin < fluid.nx; begin += lanes) {
      const std::uint32_t room = bits(has_room(corners_of_line(fluid.phi, begin, y, z),
                                               corners_of_line(fluid.solid, begin, y, z), floatv(fluid.spacing)));
      for (int x = begin; x < std::min(begin + lanes, fluid.nx); ++x) {
        const std::size_t number_of_block = std::size_t(line) * fluid.nx + x;
        const Index first = none ? 0 : particles.first[number_of_block],
                    last = none ? 0 : particles.first[number_of_block + 1];
        const int kept = first == last ? 0
                                       : keep(block_at<Real>(fluid, Index(x), Index(y), Index(z), load_from), particles,
                                              first, last, settings.per_block, plan);
        const int seeds = room >> (x - begin) & 1 ? std::max(settings.per_block - kept, 0) : 0;
        plan.kept[number_of_block] = kept, plan.seeds[number_of_block] = seeds;
        unit.kept += kept, unit.seeds += seeds;
      }
    }
  }
}

// Lists the new particles of a unit.
void list_seeds(const Fluid<Real>& fluid, const Unit& unit, Plan& plan) {
  Index at = unit.first_seed;
  for (int line = unit.begin; line < unit.end; ++line)
    for (int x = 0; x < fluid.nx; ++x) {
      const std::size_t number_of_block = std::size_t(line) * fluid.nx + x;
      for (int k = 0; k < plan.seeds[number_of_block]; ++k, ++at) {
        plan.x[at] = x, plan.y[at] = line % fluid.ny, plan.z[at] = line / fluid.ny;
        plan.number[at] = plan.kept[number_of_block] + k;
      }
    }
}

// Which of the attempts that count brought their seed into the band.
maskv attempt(const Block<floatv>& block, const FourWords<intv>& random, const maskv& counts, Seed<floatv>& seed) {
  seed = begin_at_random(block, random);
  const maskv stands = counts & may_stand(block, seed.position);
  maskv under_way = stands & !is_in_band(seed.sign, seed.phi, block.spacing);
  for (int moves = 0; moves < most_moves && any(under_way); ++moves) {
    Seed<floatv> moved = seed;
    move(block, moved);
    seed.position = select(under_way, moved.position, seed.position);
    seed.phi = select(under_way, moved.phi, seed.phi);
    seed.share = moved.share;
    under_way = under_way & !is_in_band(seed.sign, seed.phi, block.spacing);
  }
  return stands & !under_way;
}

// Places up to sixteen of the new particles, or gives them up.
void seed_lanes(const Fluid<Real>& fluid, const RandomKey& key, Index at, int count, Plan& plan) {
  const auto load_from = [](const Real* values) { return [values](const intv& at) { return gather(values, at); }; };
  const maskv there = first_lanes(count);
  const intv x = load(&plan.x[at], there), y = load(&plan.y[at], there), z = load(&plan.z[at], there);
  const intv number = load(&plan.number[at], there), number_of_block = (z * fluid.ny + y) * fluid.nx + x;
  const Block<floatv> block = block_at<floatv>(fluid, x, y, z, load_from);
  Seed<floatv> found = {.position = {0, 0, 0}, .phi = 0, .goal = 0, .sign = 0, .share = 0};
  maskv left = there;
  for (Index tried = 0; tried < most_attempts && any(left); ++tried) {
    Seed<floatv> seed;
    const maskv is_found = attempt(block, philox({number_of_block, number, intv(tried), intv(0)}, key), left, seed);
    found.position = select(is_found, seed.position, found.position);
    found.phi = select(is_found, seed.phi, found.phi);
    found.sign = select(is_found, seed.sign, found.sign);
    left = left & !is_found;
  }
  store(&plan.seed_x[at], found.position.x, there);
  store(&plan.seed_y[at], found.position.y, there);
  store(&plan.seed_z[at], found.position.z, there);
  store(&plan.radius[at], radius_of(found.sign, found.phi, block.spacing), there);
  store(&plan.sign[at], found.sign, there);
}

// Writes a unit's particles, block by block: those that stay, then the new ones.
void write(const Fluid<Real>& fluid, const Particles<Real>& particles, const Unit& unit, const Plan& plan,
           Particles<Real>& reseeded) {
  Index to = unit.first, seed = unit.first_seed;
  const auto add = [&](const Vector3<Real>& position, Real radius, Real sign) {
    store(reseeded.position, to, position);
    reseeded.radius[to] = radius, reseeded.sign[to] = sign;
    ++to;
  };
  for (std::size_t block = std::size_t(unit.begin) * fluid.nx; block < std::size_t(unit.end) * fluid.nx; ++block) {
    reseeded.first[block] = to;
    for (int k = 0; k < plan.kept[block]; ++k) {
      const Index i = plan.from[particles.first[block] + k];
      add(load(particles.position, i), particles.radius[i], particles.sign[i]);
    }
    for (int k = 0; k < plan.seeds[block]; ++k, ++seed)
      if (plan.sign[seed] != 0)
        add({plan.seed_x[seed], plan.seed_y[seed], plan.seed_z[seed]}, plan.radius[seed], plan.sign[seed]);
  }
}

}  // namespace

void reseed(const Fluid<Real>& fluid, const ReseedSettings& settings, const Particles<Real>& particles,
            Particles<Real>& reseeded) {
  const RandomKey key = {{settings.seed, settings.round}};
  const std::size_t blocks = std::size_t(fluid.nx) * fluid.ny * fluid.nz;
  Plan plan;
  plan.units = units_of(fluid, particles);
  plan.kept = room_for<Index>(blocks), plan.seeds = room_for<Index>(blocks);
  plan.from = room_for<Index>(particles.count), plan.rank = room_for<Real>(particles.count);
  const int units = static_cast<int>(plan.units.size());
  // A unit writes its own numbers, and what the plan says of its own blocks and particles. Units differ in how many
  // particles must be chosen from, hence dynamic.
#pragma omp parallel for schedule(dynamic)
  for (int u = 0; u < units; ++u) plan_unit(fluid, settings, particles, plan.units[u], plan);

  Index seeds = 0;
  for (Unit& unit : plan.units) unit.first_seed = seeds, seeds += unit.seeds;
  for (auto* of_seeds : {&plan.x, &plan.y, &plan.z, &plan.number}) *of_seeds = room_for<Index>(seeds);
  for (auto* of_seeds : {&plan.seed_x, &plan.seed_y, &plan.seed_z, &plan.radius, &plan.sign})
    *of_seeds = room_for<Real>(seeds);
#pragma omp parallel
  {
    // A unit lists its own seeds.
#pragma omp for schedule(dynamic)
    for (int u = 0; u < units; ++u) list_seeds(fluid, plan.units[u], plan);
      // An iteration writes its own sixteen seeds, all of which are listed by now. How often they are tried depends on
      // what is around them, hence dynamic.
#pragma omp for schedule(dynamic, 8)
    for (Index at = 0; at < seeds; at += lanes) seed_lanes(fluid, key, at, std::min(seeds - at, Index(lanes)), plan);
      // A unit counts its own seeds; the barrier before has completed them.
#pragma omp for schedule(dynamic)
    for (int u = 0; u < units; ++u) {
      Unit& unit = plan.units[u];
      const Real* const sign = &plan.sign[unit.first_seed];
      unit.kept += static_cast<Index>(std::count_if(sign, sign + unit.seeds, [](Real s) { return s != 0; }));
    }
  }

  Index count = 0;
  for (Unit& unit : plan.units) unit.first = count, count += unit.kept;
  resize(reseeded, count);
  reseeded.first.resize(blocks + 1);
  reseeded.first[blocks] = count;
  // A unit writes its own blocks' particles, which begin where those of the units before end.
#pragma omp parallel for schedule(dynamic)
  for (int u = 0; u < units; ++u) write(fluid, particles, plan.units[u], plan, reseeded);
}

}  // namespace lockstep::production_fluid::openmp
