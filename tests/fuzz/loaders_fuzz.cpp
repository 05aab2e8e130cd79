// The loaders under libFuzzer: a file with any bytes is read or refused in one line. LOCKSTEP_LOADER names the loader.
// TMPDIR is the folder where the input is written for the loader to read, best in memory. tests/fuzz/fuzz.sh runs the
// program and defines a finding.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>

#include "tests/fuzz/loaders.h"

namespace lockstep::fuzz {
namespace {

Loader chosen_loader() {
  const char* const name = std::getenv("LOCKSTEP_LOADER");
  const std::vector<Loader> all = loaders();
  const auto found = std::ranges::find(all, std::string(name ? name : ""), &Loader::name);
  if (found != all.end()) return *found;
  std::fputs("LOCKSTEP_LOADER: expected one of:", stderr);
  for (const Loader& loader : all) std::fprintf(stderr, " %s", loader.name.c_str());
  std::fputs("\n", stderr);
  std::exit(2);
}

// A temporary folder of this process.
std::string make_folder() {
  std::string folder = (std::filesystem::temp_directory_path() / "lockstep_fuzz_XXXXXX").string();
  if (!mkdtemp(folder.data())) {
    std::perror(folder.c_str());
    std::exit(2);
  }
  write_neighbours(folder);
  limit_memory(memory);
  return folder;
}

}  // namespace
}  // namespace lockstep::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lockstep::fuzz;
  static const Loader loader = chosen_loader();
  static const std::string folder = make_folder();
  try {
    try_bytes(loader, folder, {reinterpret_cast<const char*>(data), size});
  } catch (const std::exception& error) {
    std::fprintf(stderr, "finding: %s\n", error.what());
    std::abort();
  }
  return 0;
}
