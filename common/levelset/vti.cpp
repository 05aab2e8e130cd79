#include "common/levelset/vti.h"

#include <algorithm>
#include <vector>

#include "common/vtk.h"

namespace lockstep::levelset {

void write_image(const std::string& path, const Field<float>& signed_distance, const Grid& grid, float band) {
  std::vector<float> line(signed_distance.nx);  // without padding
  const auto line_at = [&](int y, int z) {
    const float* const first = &signed_distance(0, y, z);
    std::transform(first, first + line.size(), line.begin(), [&](float phi) { return std::clamp(phi, -band, band); });
    return std::span<const float>(line);
  };
  vtk::write(path, vtk::Image{.title = "Lockstep level set",
                              .name = "phi",
                              .points = {signed_distance.nx, signed_distance.ny, signed_distance.nz},
                              .origin = grid.position(0, 0, 0),
                              .spacing = grid.spacing,
                              .line = line_at});
}

}  // namespace lockstep::levelset
