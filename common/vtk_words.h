// Numbers in legacy VTK files, version 3.0: lines of text, and after some of them numbers as big-endian words.
#pragma once

#include <bit>
#include <cstdint>
#include <string>

namespace lockstep {

inline void append_word(std::string& bytes, std::uint32_t word) {
  for (const int shift : {24, 16, 8, 0}) bytes += static_cast<char>(word >> shift);
}
inline void append_word(std::string& bytes, std::int32_t x) { append_word(bytes, std::bit_cast<std::uint32_t>(x)); }
inline void append_word(std::string& bytes, float x) { append_word(bytes, std::bit_cast<std::uint32_t>(x)); }

}  // namespace lockstep
