// What of a run goes on from frame to frame, in a file beside the frames, so that a run that was cut off goes on bit for bit.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace lockstep::verify {

// One array of it: its bytes, and room for as many bytes as a file has of it.
struct Kept {
  std::function<std::span<const std::byte>()> bytes;
  std::function<std::span<std::byte>(std::size_t)> room;
};

// The vector must outlive what is returned.
template <class Vector>
Kept keep(Vector& vector) {
  using T = typename Vector::value_type;
  static_assert(std::is_trivially_copyable_v<T>);
  return {[&vector] { return std::as_bytes(std::span(vector)); },
          [&vector](std::size_t bytes) {
            vector.resize(bytes / sizeof(T));
            return std::as_writable_bytes(std::span(vector));
          }};
}

// `run` says in one line which run it is: scene, variant, form. What one run wrote only the same run reads.
// Writes whole or not at all. Throws InputError where it cannot be written.
void write_state(const std::string& path, const std::string& run, int frame, const std::vector<Kept>& state);

// Fills the arrays and returns the frame they are of. Throws InputError where there is no such file, it is not whole, or of another run:
// the arrays are then as they were.
int read_state(const std::string& path, const std::string& run, const std::vector<Kept>& state);

}  // namespace lockstep::verify
