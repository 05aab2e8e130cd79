// Fluid files, frames for ParaView, and what both stand on: refusals in one line, and files written whole or not at
// all.
#include <gtest/gtest.h>
#include <omp.h>

#include <array>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <limits>

#include "common/atomic_file.h"
#include "common/fluid/file.h"
#include "common/fluid/fluid.h"
#include "common/fluid/limits.h"
#include "common/fluid/vtk.h"
#include "common/memory.h"
#include "openmp/fluid/lists_fit.h"
#include "tests/temporary_folder.h"

namespace lockstep::fluid {
namespace {

using FluidIo = TemporaryFolder;

// A .fluid file's bytes, put together independently of what is tested.
template <class T>
void append(std::string& bytes, T x) {
  bytes.append(reinterpret_cast<const char*>(&x), sizeof x);
}

std::string fluid_bytes(float particles_per_metre, std::int32_t n, int records) {
  std::string bytes;
  append(bytes, particles_per_metre);
  append(bytes, n);
  for (int k = 0; k < 9 * records; ++k) append(bytes, .25f * k - 1);
  return bytes;
}

// Moves the particles about, as sorting them into cells does.
Particles<float> reversed(const Particles<float>& from) {
  Particles<float> to = from;
  for (int i = 0; i < from.count; ++i) {
    const int j = from.count - 1 - i;
    to.id[i] = from.id[j];
    for (const auto vectors :
         {&Particles<float>::position, &Particles<float>::half_velocity, &Particles<float>::velocity})
      for (const auto component : {&Vectors<float>::x, &Vectors<float>::y, &Vectors<float>::z})
        (to.*vectors.*component)[i] = (from.*vectors.*component)[j];
  }
  return to;
}

TEST_F(FluidIo, ReadsWhatTheFormatSays) {
  write_bytes(path("a.fluid"), fluid_bytes(204, 3, 3));
  const auto [particles_per_metre, particles] = read_fluid(path("a.fluid"));
  EXPECT_EQ(particles_per_metre, 204);
  ASSERT_EQ(particles.count, 3);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(particles.id[i], i);
    EXPECT_EQ(particles.position.x[i], .25f * (9 * i) - 1);
    EXPECT_EQ(particles.position.z[i], .25f * (9 * i + 2) - 1);
    EXPECT_EQ(particles.half_velocity.y[i], .25f * (9 * i + 4) - 1);
    EXPECT_EQ(particles.velocity.z[i], .25f * (9 * i + 8) - 1);
  }
}

TEST_F(FluidIo, WritesTheSameBytesWhateverTheOrder) {
  for (const int n : {0, 1, 17}) {
    const std::string bytes = fluid_bytes(392, n, n);
    write_bytes(path("in.fluid"), bytes);
    const FluidFile file = read_fluid(path("in.fluid"));
    write_fluid(path("out.fluid"), file.particles_per_metre, file.particles);
    EXPECT_EQ(read_bytes(path("out.fluid")), bytes);
    write_fluid(path("out.fluid"), file.particles_per_metre, reversed(file.particles));
    EXPECT_EQ(read_bytes(path("out.fluid")), bytes);
  }
  EXPECT_EQ(files(), 2);
}

TEST_F(FluidIo, RefusesWhatIsNoFile) {
  EXPECT_EQ(error_of([&] { read_fluid(path("none.fluid")); }),
            path("none.fluid") + ": cannot be read: No such file or directory");
  EXPECT_EQ(error_of([&] { read_fluid(folder); }), folder + ": is a directory, expected a file");
  EXPECT_EQ(error_of([&] { read_fluid("/dev/null"); }), "/dev/null: is not a regular file");
}

TEST_F(FluidIo, RefusesAFileItMayNotRead) {
  const std::string file = path("a.fluid");
  write_bytes(file, fluid_bytes(204, 1, 1));
  std::filesystem::permissions(file, std::filesystem::perms::none);
  const AsNobody nobody;
  if (!nobody.bound) GTEST_SKIP() << "permissions do not bind root";
  EXPECT_EQ(error_of([&] { read_fluid(file); }), file + ": cannot be read: Permission denied");
}

TEST_F(FluidIo, RefusesBadContent) {
  const std::string file = path("a.fluid");
  const auto error = [&](const std::string& bytes) {
    write_bytes(file, bytes);
    const std::string message = error_of([&] { read_fluid(file); });
    EXPECT_EQ(message.rfind(file + ": ", 0), 0u) << message;
    return message.substr(file.size() + 2);
  };
  constexpr float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();

  EXPECT_EQ(error(""), "0 bytes, expected at least a header of 8 bytes");
  EXPECT_EQ(error("1234567"), "7 bytes, expected at least a header of 8 bytes");
  EXPECT_EQ(error(fluid_bytes(204, 3, 2)),
            "80 bytes, expected 116 bytes for the 3 particles that its header announces");
  EXPECT_EQ(error(fluid_bytes(204, 3, 3) + '\n'),
            "117 bytes, expected 116 bytes for the 3 particles that its header announces");
  EXPECT_EQ(error(fluid_bytes(204, -1, 0)), "the number of particles is -1, expected 0 or more");
  EXPECT_EQ(error(fluid_bytes(204, std::numeric_limits<std::int32_t>::min(), 0)),
            "the number of particles is -2147483648, expected 0 or more");
  EXPECT_EQ(error(fluid_bytes(204, std::numeric_limits<std::int32_t>::max(), 1)),
            "44 bytes, expected 77309411300 bytes for the 2147483647 particles that its header announces");
  EXPECT_EQ(error(fluid_bytes(0, 1, 1)), "particles per metre is 0, expected a number from 1e-06 to 1000000");
  for (const float particles_per_metre : {-204.f, nan, inf, 1e-30f, 1e30f})
    EXPECT_NE(error(fluid_bytes(particles_per_metre, 1, 1)).find("particles per metre is "), std::string::npos);
  EXPECT_EQ(error(fluid_bytes(1e5f, 1, 1)),
            "100000 particles per metre cut the domain into 6.245412043e+11 cells, expected at most 2147483646");

  std::string bytes = fluid_bytes(204, 3, 3);
  std::memcpy(&bytes[8 + 36 * 1 + 4 * 4], &nan, 4);
  EXPECT_EQ(error(bytes), "particle 1: half_velocity.y is nan, expected a finite number");
  bytes = fluid_bytes(204, 3, 3);
  std::memcpy(&bytes[8 + 36 * 2 + 4 * 8], &inf, 4);
  EXPECT_EQ(error(bytes), "particle 2: velocity.z is inf, expected a finite number");
}

// The file is of the right size, but a hole: reading it would take memory that is not there.
TEST_F(FluidIo, RefusesWhatDoesNotFitMemory) {
  const double bytes_per_particle = simulation_bytes<float>(1, 0) - simulation_bytes<float>(0, 0);
  const double n = available_memory() / bytes_per_particle * 1.1 + 1e6;
  if (n > max_particles) GTEST_SKIP() << "as many particles as are allowed fit this machine";
  const std::string file = path("a.fluid");
  write_bytes(file, fluid_bytes(204, static_cast<std::int32_t>(n), 0));
  std::filesystem::resize_file(file, 8 + 36 * static_cast<std::uintmax_t>(n));
  const std::string message = error_of([&] { read_fluid(file); });
  EXPECT_NE(message.find(" cells needs "), std::string::npos) << message;
  EXPECT_NE(message.find(" is available"), std::string::npos) << message;
}

TEST_F(FluidIo, RefusesMoreParticlesThanCanBeCounted) {
  const std::string file = path("a.fluid");
  write_bytes(file, fluid_bytes(204, std::numeric_limits<std::int32_t>::max(), 0));
  std::filesystem::resize_file(file, 8 + 36 * 0x7fffffffULL);
  EXPECT_EQ(error_of([&] { read_fluid(file); }), file + ": 2147483647 particles, expected at most 1073741824");
}

TEST(Memory, CountsWhatAFluidAllocates) {
  Particles<float> particles;
  particles.resize(1000);
  const Model<double> model = make_model(204);
  const auto fluid = make_fluid(convert<float>(model), particles);
  const auto bytes = [](const auto&... arrays) { return (0 + ... + (arrays.size() * sizeof(arrays[0]))); };
  const auto bytes_of = [&](const Particles<float>& p) {
    return bytes(p.id, p.position.x, p.position.y, p.position.z, p.half_velocity.x, p.half_velocity.y,
                 p.half_velocity.z, p.velocity.x, p.velocity.y, p.velocity.z);
  };
  const double allocated = bytes_of(fluid.particles) + bytes_of(fluid.sorted) +
                           bytes(fluid.density, fluid.acceleration.x, fluid.acceleration.y, fluid.acceleration.z) +
                           bytes(fluid.grid.cell_begin) + bytes(fluid.neighbours.end, fluid.neighbours.scratch) +
                           sizeof(std::int32_t) * histogram_entries(1000, fluid.grid.cells());
  EXPECT_LE(allocated, simulation_bytes<float>(1000, fluid.grid.cells()));
  EXPECT_GE(allocated, .95 * simulation_bytes<float>(1000, fluid.grid.cells()));
}

TEST(Memory, RefusesListsOfACrowd) {
  const int before = omp_get_max_threads();
  Grid<float> grid = make_grid(convert<float>(make_model(20)));
  const auto crowd_of = [&](int n) {
    std::fill(grid.cell_begin.begin() + 1, grid.cell_begin.end(), n);  // all in the first cell
    const auto error = error_of([&] { require_lists_fit(grid); });
    for (const int threads : {1, 2, 5}) {
      omp_set_num_threads(threads);
      EXPECT_EQ(error_of([&] { openmp::require_lists_fit_in_parallel(grid); }), error) << threads << " threads";
    }
    omp_set_num_threads(before);
    return error;
  };
  EXPECT_EQ(crowd_of(5'000), "no error");
  EXPECT_EQ(crowd_of(100'000), "up to 100000 particles in a cell: too crowded for lists of neighbours");
}

TEST(Memory, CountsNoFewerCellsThanTheGridHas) {
  for (double particles_per_metre = 5; particles_per_metre < 1000; particles_per_metre *= 1.0123) {
    const Model<double> model = make_model(particles_per_metre);
    EXPECT_LE(make_grid(model).cells(), count_cells(model));
    EXPECT_LE(make_grid(convert<float>(model)).cells(), count_cells(model));
  }
}

TEST(Memory, RespectsTheLimitOnAddressSpace) {
  const Limit limit(RLIMIT_AS, address_space() + 64'000'000);
  EXPECT_LE(available_memory(), 64e6);
  EXPECT_EQ(error_of([] { require_memory(1e3, "this"); }), "no error");
  EXPECT_EQ(error_of([] { require_memory(2e9, "this"); }).rfind("this needs 2000 MB of memory, and ", 0), 0u);
}

TEST_F(FluidIo, RefusesToWriteWhereItCannot) {
  Particles<float> particles;
  particles.resize(0);
  const auto error = [&](const std::string& file) { return error_of([&] { write_fluid(file, 204, particles); }); };
  EXPECT_EQ(error(path("none/a.fluid")), path("none/a.fluid") + ": cannot be written: No such file or directory");
  EXPECT_EQ(error(folder), folder + ": cannot be written: not a regular file");
  EXPECT_EQ(error("/dev/null"), "/dev/null: cannot be written: not a regular file");
  EXPECT_EQ(files(), 0);

  std::filesystem::permissions(folder, std::filesystem::perms(0555));
  const AsNobody nobody;
  if (!nobody.bound) GTEST_SKIP() << "permissions do not bind root";
  EXPECT_EQ(error(path("a.fluid")), path("a.fluid") + ": cannot be written: Permission denied");
  EXPECT_EQ(files(), 0);
}

// A full disk, played by a limit on the size of files.
TEST_F(FluidIo, LeavesNothingBehindOnAFullDisk) {
  const std::string file = path("a.fluid");
  write_bytes(file, "as it was");
  Particles<float> particles;
  particles.resize(10000);
  for (int i = 0; i < particles.count; ++i) particles.id[i] = i;

  const auto signal_before = std::signal(SIGXFSZ, SIG_IGN);
  std::string message;
  {
    const Limit limit(RLIMIT_FSIZE, 4096);
    message = error_of([&] { write_fluid(file, 204, particles); });
  }
  std::signal(SIGXFSZ, signal_before);

  EXPECT_EQ(message, file + ": cannot be written: File too large");
  EXPECT_EQ(read_bytes(file), "as it was");
  EXPECT_EQ(files(), 1);
}

TEST_F(FluidIo, LeavesNothingBehindWhenTheWriterThrows) {
  const auto write = [](std::ostream& out) {
    out << "half a file";
    throw std::runtime_error("no more");
  };
  EXPECT_THROW(write_file(path("a"), write), std::runtime_error);
  EXPECT_EQ(files(), 0);
}

TEST_F(FluidIo, WritesFramesForParaView) {
  write_bytes(path("a.fluid"), fluid_bytes(204, 2, 2));
  const Particles<float> particles = reversed(read_fluid(path("a.fluid")).particles);
  write_vtk(path("a.vtk"), particles, std::array{1001.f, 1000.f});  // of particles 1 and 0

  const auto big_endian = [](auto... numbers) {
    std::string bytes;
    for (const auto x : {numbers...}) {
      std::string word;
      append(word, x);
      bytes.append(word.rbegin(), word.rend());
    }
    return bytes + '\n';
  };
  EXPECT_EQ(read_bytes(path("a.vtk")),
            "# vtk DataFile Version 3.0\nLockstep fluid\nBINARY\nDATASET POLYDATA\n"
            "POINTS 2 float\n" +
                big_endian(-1.f, -.75f, -.5f, 1.25f, 1.5f, 1.75f) + "VERTICES 2 4\n" + big_endian(1, 0, 1, 1) +
                "POINT_DATA 2\n"
                "VECTORS velocity float\n" +
                big_endian(.5f, .75f, 1.f, 2.75f, 3.f, 3.25f) + "SCALARS density float 1\nLOOKUP_TABLE default\n" +
                big_endian(1000.f, 1001.f) + "SCALARS id int 1\nLOOKUP_TABLE default\n" + big_endian(0, 1));
  EXPECT_EQ(error_of([&] {
              write_vtk(path("none/a.vtk"), particles, std::array{1.f, 1.f});
            }),
            path("none/a.vtk") + ": cannot be written: No such file or directory");
  EXPECT_EQ(files(), 2);
}

}  // namespace
}  // namespace lockstep::fluid
