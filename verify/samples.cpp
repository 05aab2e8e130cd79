#include "verify/samples.h"

#include <algorithm>
#include <iterator>

namespace lockstep::verify {

Counted counted(const std::vector<Sample>& samples, double whole, std::size_t enough) {
  std::vector<Sample> on_whole_cores;
  std::ranges::copy_if(samples, std::back_inserter(on_whole_cores),
                       [&](const Sample& s) { return s.turns >= .9 * whole; });
  if (on_whole_cores.size() < std::min(std::max<std::size_t>(samples.size() / 2, 1), enough)) return {samples, true};
  return {on_whole_cores, false};
}

double quantile(const std::vector<Sample>& samples, double Sample::*of, double q) {
  std::vector<double> sorted;
  for (const Sample& s : samples) sorted.push_back(s.*of);
  std::ranges::sort(sorted);
  return sorted[static_cast<std::size_t>(q * (sorted.size() - 1))];
}

std::optional<double> spread(const std::vector<Sample>& samples) {
  if (samples.size() < 2) return std::nullopt;
  const auto seconds = [&](double q) { return quantile(samples, &Sample::seconds, q); };
  return (seconds(.75) - seconds(.25)) / seconds(.5);
}

}  // namespace lockstep::verify
