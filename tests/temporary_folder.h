// Helpers of tests that read or write files, or limit the process.
#pragma once

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

#include "common/input_error.h"

namespace lockstep {

// A test with a folder of its own, which is removed afterwards.
struct TemporaryFolder : testing::Test {
  std::string folder;

  TemporaryFolder() {
    folder = (std::filesystem::temp_directory_path() / "lockstep_test_XXXXXX").string();
    if (!mkdtemp(folder.data())) throw std::runtime_error("cannot make " + folder);
    std::filesystem::permissions(folder, std::filesystem::perms(0755));  // AsNobody looks inside
  }
  ~TemporaryFolder() override { std::filesystem::remove_all(folder); }

  std::string path(const std::string& name) const { return folder + '/' + name; }
  int files() const {
    return static_cast<int>(
        std::distance(std::filesystem::directory_iterator(folder), std::filesystem::directory_iterator()));
  }
};

inline void write_bytes(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

inline std::string read_bytes(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

// The message of the InputError that `action` throws, which must be one line.
template <class Action>
std::string error_of(Action action) {
  try {
    action();
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    return error.what();
  }
  return "no error";
}

// Permissions do not bind root. If the tests run as root, a test of permissions runs as the user nobody.
struct AsNobody {
  AsNobody() { bound = geteuid() != 0 || seteuid(65534) == 0; }
  ~AsNobody() {
    if (getuid() == 0 && seteuid(0) != 0) std::abort();
  }
  bool bound;
};

// The address space of this process, in bytes.
inline rlim_t address_space() {
  rlim_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * sysconf(_SC_PAGESIZE);
}

// Whether memory that is freed stays taken: the address sanitizer keeps it, to find uses after the end. A limit of the
// address space then says nothing of what is in use.
#ifdef __SANITIZE_ADDRESS__
inline constexpr bool keeps_freed_memory = true;
#else
inline constexpr bool keeps_freed_memory = false;
#endif

// Lowers one of this process's limits until it is destroyed.
struct Limit {
  Limit(int resource, rlim_t value) : resource(resource) {
    getrlimit(resource, &before);
    const rlimit lowered{value, before.rlim_max};
    setrlimit(resource, &lowered);
  }
  ~Limit() { setrlimit(resource, &before); }
  int resource;
  rlimit before;
};

}  // namespace lockstep
