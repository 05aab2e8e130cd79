// Shards: shares of a command's cases, for several machines (notes/big_machine.md).
#pragma once

#include <cstddef>
#include <optional>
#include <string>

namespace lockstep::verify {

// One of several shares. Cases go to the shards in turn, by their places in the command's list: shares are disjoint,
// all of them together are the whole, and each has its part of every kernel, large and small.
struct Shard {
  int number, of;  // from 1
  bool has(std::size_t place) const { return place % of == static_cast<std::size_t>(number - 1); }
};

// Of no shard: all.
inline bool in_share(const std::optional<Shard>& shard, std::size_t place) { return !shard || shard->has(place); }

// Reads "2/3", the second of three. Throws InputError for what is no share.
Shard shard_of(const std::string& text);

}  // namespace lockstep::verify
