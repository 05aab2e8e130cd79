// Linear algebra: matrices do not move, so that there is nothing to run.
#include <cmath>

#include "common/linear/scene.h"
#include "verify/domain.h"

namespace lockstep::verify {
namespace {

// A matrix that is loaded must have finite values, and no column outside of it.
std::string fault_of_scene(const std::string& path) {
  const linear::Scene scene = linear::load_scene(path);
  const linear::Rows<float>& a = scene.rows;
  for (const float value : a.value)
    if (!std::isfinite(value)) return "a value is not finite";
  for (const std::int32_t column : a.column)
    if (column < 0 || column >= a.columns) return "a column is outside the matrix";
  return "";
}

const RegisterDomain linear_domain{
    {.name = "linear", .moves = false, .determinism = {"poisson_64"}, .fault_of_scene = fault_of_scene}};

}  // namespace
}  // namespace lockstep::verify
