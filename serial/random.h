// Philox4x32 with ten rounds, by Random123, its authors' library.
#pragma once

#include <Random123/philox.h>

#include <cstdint>

#include "common/random.h"

namespace lockstep {

inline FourWords<std::int32_t> philox(const FourWords<std::int32_t>& counter, const RandomKey& key) {
  const auto word = [&](int k) { return static_cast<std::uint32_t>(counter.word[k]); };
  const auto random = r123::Philox4x32()({{word(0), word(1), word(2), word(3)}}, {{key.word[0], key.word[1]}});
  const auto signed_word = [&](int k) { return static_cast<std::int32_t>(random[k]); };
  return {signed_word(0), signed_word(1), signed_word(2), signed_word(3)};
}

}  // namespace lockstep
