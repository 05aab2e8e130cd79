#include "common/cloth/limits.h"

#include <cmath>
#include <cstdint>

#include "common/digits.h"
#include "common/input_error.h"
#include "common/memory.h"

namespace lockstep::cloth {
namespace {

void require_at_most(double limit, double count, const std::string& what, const std::string& where) {
  if (count > limit)
    throw InputError(where + ": " + digits_of(count) + ' ' + what + ", expected at most " + digits_of(limit));
}

std::string cloths_of(int copies, const char* one, const char* many) {
  return (copies == 1 ? std::string(one) : digits_of(copies) + ' ' + many) + " of ";
}

// As in messages: [row, column] of a sheet, the number in its OBJ file of a mesh.
std::string name(const Sheet& sheet, int i) {
  if (sheet.rows == 0) return std::to_string(i + 1);
  return '[' + std::to_string(i / sheet.pitch) + ", " + std::to_string(i % sheet.pitch) + ']';
}

}  // namespace

double making_bytes(double particles, double constraints, double triangles, double most_constraints_of_a_particle) {
  constexpr double reals = sizeof(double) + sizeof(float);
  // Positions, inverse mass; where its corners begin, while being counted.
  constexpr double particle = 7 * reals + 3 * sizeof(int);
  constexpr double constraint = 2 * (reals + 4 * sizeof(int));  // in both orders
  constexpr double in_making = 2 * sizeof(int) + 64;  // its batch and place; the edge of a mesh that brought it
  constexpr double growing = 2;                       // a list that grows is held twice
  constexpr double triangle = 3 * reals + 2 * 6 * sizeof(int);  // its force; itself, and its corners
  constexpr double first_batches = 2 * sizeof(std::uint64_t);   // of a particle, see make_batches
  // Batches from 64 on are kept constraint by constraint. There are fewer than twice the constraints of a particle.
  const double later_batch = 2 * most_constraints_of_a_particle > 64 ? 100 : 0;
  return particles * (particle + first_batches) + growing * constraints * (constraint + in_making) +
         constraints * later_batch + growing * triangles * triangle;
}

void require_sheet_size(double rows, double columns, int copies, const std::string& where) {
  const double pitch = std::ceil(columns / 16) * 16, particles = rows * pitch;
  if (rows * columns < 2) throw InputError(where + ": a sheet of one particle, expected at least two");
  require_at_most(max_particles, particles, "particles, with rows filled up to whole vectors", where);
  constexpr double constraints = 6;                        // that a particle begins; each ties two
  const double triangles = 2 * (rows + 1) * (pitch + 16);  // as many as Cloth::force has room for
  require_memory(copies * making_bytes(particles, constraints * particles, triangles, 2 * constraints),
                 where + ": " + cloths_of(copies, "a sheet", "sheets") + digits_of(rows * columns) + " particles");
}

void require_mesh_size(double points, double triangles, double triangles_around, int copies, const std::string& where) {
  require_at_most(max_particles, points, "points", where);
  require_at_most(max_triangles, triangles, "triangles", where);
  // A triangle brings at most three edges and three bending ties; of those, at each of its corners two and two.
  require_memory(copies * making_bytes(points, 6 * triangles, triangles, 4 * triangles_around),
                 where + ": " + cloths_of(copies, "a cloth", "cloths") + digits_of(points) + " points and " +
                     digits_of(triangles) + " triangles");
}

void require_lengths(const Cloth<double>& cloth, const std::string& where) {
  const Constraints<double>& list = cloth.constraints;
  for (int k = 0; k < list.count; ++k) {
    const double length = std::sqrt(list.rest_2[k]);
    if (!(length >= smallest && length <= largest))
      throw InputError(where + ": particles " + name(cloth.sheet, list.a[k]) + " and " + name(cloth.sheet, list.b[k]) +
                       " are tied and " + digits_of(length) + " m apart, expected from " + digits_of(smallest) +
                       " to " + digits_of(largest));
  }
}

}  // namespace lockstep::cloth
