#include "common/production_fluid/vtk.h"

#include "common/levelset/vti.h"
#include "common/vtk.h"

namespace lockstep::production_fluid {
namespace {

// The first `count` elements: what comes after them is padding.
vtk::Fill first_of(const Array<float>& array, int count) {
  return [&array, count](vtk::Words& words) {
    for (int i = 0; i < count; ++i) words.add(array[i]);
  };
}

vtk::Fill first_of(const Vectors<float>& vectors, int count) {
  return [&vectors, count](vtk::Words& words) {
    for (int i = 0; i < count; ++i) words.add(load(vectors, i));
  };
}

vtk::Cells vertices(int count) {
  return {count, count, [count](vtk::Words& words) {
            for (int i = 0; i < count; ++i) words.add(1), words.add(i);
          }};
}

}  // namespace

void write_vtk(const std::string& path, const Field<float>& field, float band) {
  levelset::write_image(path, field,
                        {.nx = field.nx, .ny = field.ny, .nz = field.nz, .spacing = field.spacing, .origin = {0, 0, 0}},
                        band);
}

void write_vtk(const std::string& path, const Particles<float>& particles) {
  const int n = particles.count;
  vtk::write(path, {.title = "Lockstep particles of a level set",
                    .points = n,
                    .positions = first_of(particles.position, n),
                    .vertices = vertices(n),
                    .point_data = {{"radius", vtk::Type::floats, first_of(particles.radius, n)},
                                   {"sign", vtk::Type::floats, first_of(particles.sign, n)}}});
}

void write_vtk(const std::string& path, const Spray<float>& spray) {
  const int n = spray.count;
  vtk::write(path, {.title = "Lockstep spray",
                    .points = n,
                    .positions = first_of(spray.position, n),
                    .vertices = vertices(n),
                    .point_data = {{"velocity", vtk::Type::vectors, first_of(spray.velocity, n)},
                                   {"radius", vtk::Type::floats, first_of(spray.radius, n)}}});
}

}  // namespace lockstep::production_fluid
