// A scene's cloth crumpled into a small ball, in motion: millions of pairs of elements whose boxes overlap, where the
// cloth at rest has its neighbours alone.
#pragma once

#include <memory>
#include <string>

#include "common/production_cloth/search.h"

namespace lockstep::verify::production_cloth_inputs {

struct Crumpled {
  production_cloth::Search search;
  Vectors<float> start, end;  // m
  float margin;               // m
};

std::shared_ptr<const Crumpled> crumpled(const std::string& path);

}  // namespace lockstep::verify::production_cloth_inputs
