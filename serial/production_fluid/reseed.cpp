// Evens out how many particles the blocks beside the surface hold.
//
// Block by block: which particles stay, then which are new. A new particle takes the sign of the side that it is drawn
// on, so what a block gets is a sample of its liquid and its air. If none were removed, memory would grow where the
// flow gathers them, so those nearest to the surface are kept; without new ones, thin sheets would have none that carry
// them.
//
// The contract stands in common/production_fluid/reseed.h.
#include "common/production_fluid/reseed.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "common/real.h"
#include "serial/random.h"

namespace lockstep::production_fluid::serial {
namespace {

using Index = std::int32_t;

// The particles of a block that stay, in order.
void keep(const Block<Real>& block, const Particles<Real>& particles, int begin, int end, int per_block,
          std::vector<Index>& kept) {
  kept.clear();
  std::vector<std::pair<Real, Index>> ranked;
  int escaped = 0;
  for (Index i = begin; i < end; ++i) {
    const Real sign = particles.sign[i], radius = particles.radius[i];
    const Real phi = phi_at(block, load(particles.position, i));
    const bool has_gone = has_escaped(sign, phi, radius);
    if (!has_gone && is_beyond(phi, block.spacing)) continue;
    escaped += has_gone;
    ranked.emplace_back(rank_of(sign, phi, radius), i);
  }
  const std::size_t most = std::max(escaped, per_block);
  if (ranked.size() > most) {
    std::nth_element(ranked.begin(), ranked.begin() + most, ranked.end());
    ranked.resize(most);
  }
  for (const auto& [rank, i] : ranked) kept.push_back(i);
  std::sort(kept.begin(), kept.end());
}

// Whether an attempt brought its seed into the band.
bool attempt(const Block<Real>& block, const FourWords<Index>& random, Seed<Real>& seed) {
  seed = begin_at_random(block, random);
  if (!may_stand(block, seed.position)) return false;
  for (int moves = 0; moves < most_moves && !is_in_band(seed.sign, seed.phi, block.spacing); ++moves) move(block, seed);
  return is_in_band(seed.sign, seed.phi, block.spacing);
}

void add(Particles<Real>& particles, const Vector3<Real>& position, Real radius, Real sign) {
  particles.position.x.push_back(position.x);
  particles.position.y.push_back(position.y);
  particles.position.z.push_back(position.z);
  particles.radius.push_back(radius), particles.sign.push_back(sign);
  ++particles.count;
}

}  // namespace

void reseed(const Fluid<Real>& fluid, const ReseedSettings& settings, const Particles<Real>& particles,
            Particles<Real>& reseeded) {
  const RandomKey key = {{settings.seed, settings.round}};
  const auto load_from = [](const Real* values) { return [values](Index at) { return values[at]; }; };
  std::vector<Index> kept;
  reseeded = {};
  Index number_of_block = 0;
  for (int z = 0; z < fluid.nz; ++z)
    for (int y = 0; y < fluid.ny; ++y)
      for (int x = 0; x < fluid.nx; ++x, ++number_of_block) {
        reseeded.first.push_back(reseeded.count);
        const Block<Real> block = block_at<Real>(fluid, Index(x), Index(y), Index(z), load_from);
        const bool none = particles.count == 0;
        keep(block, particles, none ? 0 : particles.first[number_of_block],
             none ? 0 : particles.first[number_of_block + 1], settings.per_block, kept);
        for (const Index i : kept) add(reseeded, load(particles.position, i), particles.radius[i], particles.sign[i]);
        if (!has_room(block.phi, block.solid, block.spacing)) continue;
        for (Index n = static_cast<Index>(kept.size()); n < settings.per_block; ++n) {
          Seed<Real> seed;
          bool found = false;
          for (Index tried = 0; tried < most_attempts && !found; ++tried)
            found = attempt(block, philox({number_of_block, n, tried, 0}, key), seed);
          if (found) add(reseeded, seed.position, radius_of(seed.sign, seed.phi, block.spacing), seed.sign);
        }
      }
  reseeded.first.push_back(reseeded.count);
  resize(reseeded, reseeded.count);
}

}  // namespace lockstep::production_fluid::serial
