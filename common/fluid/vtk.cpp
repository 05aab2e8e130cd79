#include "common/fluid/vtk.h"

#include <vector>

#include "common/atomic_file.h"
#include "common/fluid/id_order.h"
#include "common/vtk_words.h"

namespace lockstep::fluid {

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
        for (const Array<float>* component : {&v.x, &v.y, &v.z}) append_word(bytes, (*component)[i]);
      });
    };
    out << "# vtk DataFile Version 3.0\nLockstep fluid\nBINARY\nDATASET POLYDATA\n";
    vectors("POINTS " + n + " float", particles.position);
    section("VERTICES " + n + " " + twice_n,
            [&](std::string& bytes, int i) { append_word(bytes, 1), append_word(bytes, particles.id[i]); });
    out << "POINT_DATA " << n << '\n';
    vectors("VECTORS velocity float", particles.velocity);
    section("SCALARS density float 1\nLOOKUP_TABLE default", [&](std::string& bytes, int i) { append_word(bytes, density[i]); });
    section("SCALARS id int 1\nLOOKUP_TABLE default", [&](std::string& bytes, int i) { append_word(bytes, particles.id[i]); });
  });
}

}  // namespace lockstep::fluid
