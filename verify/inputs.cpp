#include "verify/inputs.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace lockstep::verify {

std::shared_ptr<const void> kept_input(const std::string& key, const std::function<MadeInput()>& make) {
  static std::vector<std::pair<std::string, MadeInput>> kept;  // most recently used last
  const auto found = std::ranges::find(kept, key, &std::pair<std::string, MadeInput>::first);
  if (found != kept.end())
    std::rotate(found, found + 1, kept.end());
  else
    kept.emplace_back(key, make());  // `make` may itself call kept_input

  double bytes = 0;
  for (const auto& [name, made] : kept) bytes += made.bytes;
  while (kept.size() > 1 && bytes > inputs_budget) {
    bytes -= kept.front().second.bytes;
    kept.erase(kept.begin());
  }
  return kept.back().second.input;
}

}  // namespace lockstep::verify
