#include "verify/inputs.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "verify/program.h"

namespace lockstep::verify {

namespace {

struct Kept {
  std::string key;
  MadeInput made;
  double seconds;  // that it took to make
  double seconds_per_byte() const { return seconds / made.bytes; }
};

}  // namespace

std::shared_ptr<const void> kept_input(const std::string& key, const std::function<MadeInput()>& make) {
  static std::vector<Kept> kept;
  const auto found = std::ranges::find(kept, key, &Kept::key);
  if (found != kept.end()) return found->made.input;
  const double start = now();
  const MadeInput made = make();  // may itself call kept_input
  const double seconds = now() - start;

  double bytes = made.bytes;
  for (const Kept& each : kept) bytes += each.made.bytes;
  while (!kept.empty() && bytes > inputs_budget) {
    const auto cheapest = std::ranges::min_element(kept, {}, &Kept::seconds_per_byte);
    bytes -= cheapest->made.bytes;
    kept.erase(cheapest);
  }
  kept.push_back({key, made, seconds});
  return made.input;
}

}  // namespace lockstep::verify
