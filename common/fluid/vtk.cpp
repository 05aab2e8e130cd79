// Legacy VTK, version 3.0: lines of text, and after some of them numbers as big-endian words.
#include "common/fluid/vtk.h"

#include <bit>
#include <cstdint>
#include <vector>

#include "common/atomic_file.h"
#include "common/fluid/id_order.h"

namespace lockstep::fluid {
namespace {

void append(std::string& bytes, std::uint32_t word) {
  for (const int shift : {24, 16, 8, 0}) bytes += static_cast<char>(word >> shift);
}
void append(std::string& bytes, std::int32_t x) { append(bytes, std::bit_cast<std::uint32_t>(x)); }
void append(std::string& bytes, float x) { append(bytes, std::bit_cast<std::uint32_t>(x)); }

}  // namespace

void write_vtk(const std::string& path, const Particles<float>& particles, std::span<const float> density) {
  const std::vector<int> order = id_order(particles);
  const std::string n = std::to_string(particles.count), twice_n = std::to_string(2LL * particles.count);

  write_file(path, [&](std::ostream& out) {
    const auto section = [&](const std::string& heading, auto append_numbers_of) {
      std::string bytes;
      for (const int i : order) append_numbers_of(bytes, i);
      out << heading << '\n' << bytes << '\n';
    };
    const auto vectors = [&](const std::string& heading, const Vectors<float>& v) {
      section(heading, [&](std::string& bytes, int i) {
        for (const Array<float>* component : {&v.x, &v.y, &v.z}) append(bytes, (*component)[i]);
      });
    };
    out << "# vtk DataFile Version 3.0\nLockstep fluid\nBINARY\nDATASET POLYDATA\n";
    vectors("POINTS " + n + " float", particles.position);
    section("VERTICES " + n + " " + twice_n, [&](std::string& bytes, int i) { append(bytes, 1), append(bytes, particles.id[i]); });
    out << "POINT_DATA " << n << '\n';
    vectors("VECTORS velocity float", particles.velocity);
    section("SCALARS density float 1\nLOOKUP_TABLE default", [&](std::string& bytes, int i) { append(bytes, density[i]); });
    section("SCALARS id int 1\nLOOKUP_TABLE default", [&](std::string& bytes, int i) { append(bytes, particles.id[i]); });
  });
}

}  // namespace lockstep::fluid
