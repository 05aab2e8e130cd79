#include "verify/shard.h"

#include <charconv>

#include "common/input_error.h"

namespace lockstep::verify {

Shard shard_of(const std::string& text) {
  constexpr int most = 100000;
  const char* const end = text.data() + text.size();
  Shard shard = {0, 0};
  const auto [slash, no_number] = std::from_chars(text.data(), end, shard.number);
  const bool has_slash = no_number == std::errc() && slash != end && *slash == '/';
  const auto [rest, no_count] = std::from_chars(has_slash ? slash + 1 : end, end, shard.of);
  if (!has_slash || no_count != std::errc() || rest != end || shard.number < 1 || shard.number > shard.of ||
      shard.of > most)
    throw InputError("--shard " + text + ": expected I/N with 1 <= I <= N <= " + std::to_string(most) +
                     ", such as 2/3");
  return shard;
}

}  // namespace lockstep::verify
