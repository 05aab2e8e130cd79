#include "common/fluid/file.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <istream>

#include "common/atomic_file.h"
#include "common/fluid/id_order.h"
#include "common/fluid/limits.h"
#include "common/input_error.h"
#include "common/input_file.h"

namespace lockstep::fluid {
namespace {

static_assert(std::endian::native == std::endian::little, "a .fluid file is read and written as it lies in memory");

struct Header {
  float particles_per_metre;
  std::int32_t n;
};
using Record = std::array<float, 9>;

constexpr std::int64_t header_bytes = 8, record_bytes = 36;
static_assert(sizeof(Header) == header_bytes && sizeof(Record) == record_bytes);

constexpr std::array field_names{"position.x",      "position.y", "position.z", "half_velocity.x", "half_velocity.y",
                                 "half_velocity.z", "velocity.x", "velocity.y", "velocity.z"};

// The particles' arrays in the order of a record.
template <class P>
auto fields(P& particles) {
  auto& [count, id, p, hv, v] = particles;
  return std::array{&p.x, &p.y, &p.z, &hv.x, &hv.y, &hv.z, &v.x, &v.y, &v.z};
}

// What is missing shows as a short read only if the file shrinks meanwhile: the size has been checked.
template <class T>
T read(std::istream& in, const std::string& path) {
  T value;
  if (!in.read(reinterpret_cast<char*>(&value), sizeof value)) throw InputError(path + ": cannot be read to its end");
  return value;
}

template <class T>
void write(std::ostream& out, const T& value) {
  out.write(reinterpret_cast<const char*>(&value), sizeof value);
}

}  // namespace

FluidFile read_fluid(const std::string& path) {
  std::ifstream in = open_input(path);
  const std::int64_t size = in.seekg(0, std::ios::end).tellg();
  in.seekg(0);
  const auto bytes = [](std::int64_t count) { return std::to_string(count) + " bytes"; };

  if (size < header_bytes)
    throw InputError(path + ": " + bytes(size) + ", expected at least a header of " + bytes(header_bytes));
  const auto [particles_per_metre, n] = read<Header>(in, path);
  require_resolution(particles_per_metre, path);
  if (n < 0) throw InputError(path + ": the number of particles is " + std::to_string(n) + ", expected 0 or more");
  const std::int64_t expected = header_bytes + record_bytes * n;
  if (size != expected)
    throw InputError(path + ": " + bytes(size) + ", expected " + bytes(expected) + " for the " + std::to_string(n) +
                     " particles that its header announces");
  require_size(make_model(particles_per_metre), n, path);

  FluidFile file{.particles_per_metre = particles_per_metre, .particles = {}};
  file.particles.resize(n);
  const auto arrays = fields(file.particles);
  for (int i = 0; i < n; ++i) {
    const Record record = read<Record>(in, path);
    for (std::size_t f = 0; f < record.size(); ++f) {
      if (!std::isfinite(record[f]))
        throw InputError(path + ": particle " + std::to_string(i) + ": " + field_names[f] + " is " +
                         std::to_string(record[f]) + ", expected a finite number");
      (*arrays[f])[i] = record[f];
    }
    file.particles.id[i] = i;
  }
  return file;
}

void write_fluid(const std::string& path, float particles_per_metre, const Particles<float>& particles) {
  write_file(path, [&](std::ostream& out) {
    write(out, Header{particles_per_metre, particles.count});
    const auto arrays = fields(particles);
    for (const int i : id_order(particles)) {
      Record record;
      for (std::size_t f = 0; f < record.size(); ++f) record[f] = (*arrays[f])[i];
      write(out, record);
    }
  });
}

}  // namespace lockstep::fluid
