#include "common/cloth/vtk.h"

#include <vector>

#include "common/atomic_file.h"
#include "common/vtk_words.h"

namespace lockstep::cloth {
namespace {

// The particles without padding, by index.
std::vector<int> particles_of(const Cloth<float>& cloth) {
  std::vector<int> particles;
  for (int i = 0; i < cloth.count; ++i)
    if (cloth.sheet.rows == 0 || i % cloth.sheet.pitch < cloth.sheet.columns) particles.push_back(i);
  return particles;
}

}  // namespace

void write_vtk(const std::string& path, const Cloth<float>& cloth) {
  const Vectors<float>&p = cloth.position, &q = cloth.previous;
  const float dt = cloth.model.time_step;
  const std::vector<int> particles = particles_of(cloth);
  std::vector<int> number(cloth.count);  // that a particle has in the file
  const int count = static_cast<int>(particles.size()), triangles = static_cast<int>(cloth.triangles.size());
  for (int k = 0; k < count; ++k) number[particles[k]] = k;

  std::string points, velocities, cells;
  for (const int i : particles) {
    for (const float x : {p.x[i], p.y[i], p.z[i]}) append_word(points, x);
    for (const float v : {(p.x[i] - q.x[i]) / dt, (p.y[i] - q.y[i]) / dt, (p.z[i] - q.z[i]) / dt}) append_word(velocities, v);
  }
  std::string heading;
  if (triangles > 0) {
    heading = "POLYGONS " + std::to_string(triangles) + ' ' + std::to_string(4LL * triangles);
    for (const auto& [a, b, c] : cloth.triangles)
      for (const int word : {3, number[a], number[b], number[c]}) append_word(cells, word);
  } else {
    heading = "LINES 1 " + std::to_string(1 + count);
    append_word(cells, count);
    for (int k = 0; k < count; ++k) append_word(cells, k);
  }

  write_file(path, [&](std::ostream& out) {
    out << "# vtk DataFile Version 3.0\nLockstep cloth\nBINARY\nDATASET POLYDATA\n";
    out << "POINTS " << count << " float\n" << points << '\n' << heading << '\n' << cells << '\n';
    out << "POINT_DATA " << count << "\nVECTORS velocity float\n" << velocities << '\n';
  });
}

}  // namespace lockstep::cloth
