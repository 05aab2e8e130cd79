// Scenes of the production cloth as the kernels find them.
#pragma once

#include <memory>
#include <string>

#include "common/production_cloth/bvh.h"
#include "common/production_cloth/pairs.h"
#include "common/production_cloth/scene.h"
#include "verify/kernel.h"

namespace lockstep::verify::production_cloth_inputs {

std::shared_ptr<const production_cloth::Scene> inputs(const std::string& path);

// 1/kg, lumped, padded; 0 of a vertex that is held.
Array<float> inverse_masses(const production_cloth::Scene& scene);

// Pairs of elements whose boxes over the way from start to end, larger by `margin` (m), overlap: the serial search.
template <class Real>
production_cloth::ElementPairs pairs_within(const production_cloth::Topology& topology, const Vectors<Real>& start,
                                            const Vectors<Real>& end, Real margin) {
  const production_cloth::Search search = production_cloth::make_search(topology);
  production_cloth::SearchBoxes<Real> boxes;
  production_cloth::serial::refit(search, start, end, margin, boxes);
  production_cloth::ElementPairs pairs;
  production_cloth::serial::find_pairs(search, boxes, pairs);
  return pairs;
}

// Positions at rest, in float.
Vectors<float> rest_positions(const production_cloth::Scene& scene);

// Those that all kernels take.
Scenes all_scenes();

}  // namespace lockstep::verify::production_cloth_inputs
