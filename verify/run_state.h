// The state of a run, saved beside its frames. A run that was interrupted resumes from it, bit for bit.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace lockstep::verify {

// One array of the state: access to its bytes, and a function that resizes it to a number of bytes.
struct Kept {
  std::function<std::span<const std::byte>()> bytes;
  std::function<std::span<std::byte>(std::size_t)> room;
};

// The vector must outlive the result.
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

// A single number, which must outlive the result. Of another number of bytes it stays what it was.
template <class T>
Kept keep_number(T& number) {
  static_assert(std::is_arithmetic_v<T>);
  return {[&number] { return std::as_bytes(std::span(&number, 1)); },
          [&number](std::size_t) { return std::as_writable_bytes(std::span(&number, 1)); }};
}

// `run` is one line that identifies the run: scene, variant, form. Only the same run reads the file. Writes the file
// whole or not at all. Throws InputError if it cannot be written.
void write_state(const std::string& path, const std::string& run, int frame, const std::vector<Kept>& state);

// Fills the arrays and returns the number of their frame. Throws InputError if the file is missing, damaged, of
// another run, or of another number of arrays; the arrays are then unchanged.
int read_state(const std::string& path, const std::string& run, const std::vector<Kept>& state);

// The run that wrote the file, as write_state was told; "" if the file cannot be read.
std::string run_of_state(const std::string& path);

}  // namespace lockstep::verify
