#include "common/memory.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <limits>

#include "common/input_error.h"

namespace lockstep {
namespace {

constexpr double unknown = std::numeric_limits<double>::infinity();

double limit = unknown;

double machine_memory() {
  std::ifstream meminfo("/proc/meminfo");
  for (std::string key; meminfo >> key; meminfo.ignore(std::numeric_limits<std::streamsize>::max(), '\n'))
    if (double kibibytes; key == "MemAvailable:" && meminfo >> kibibytes) return kibibytes * 1024;
  return unknown;
}

double address_space() {
  rlimit limit;
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return unknown;
  double pages_used;
  if (!(std::ifstream("/proc/self/statm") >> pages_used)) return unknown;
  return std::max(0.0, static_cast<double>(limit.rlim_cur) - pages_used * static_cast<double>(sysconf(_SC_PAGESIZE)));
}

std::string megabytes(double bytes) {
  char text[64];
  std::snprintf(text, sizeof text, "%.6g MB", std::max(0.1, bytes / 1e6));
  return text;
}

}  // namespace

double available_memory() { return std::min({machine_memory(), address_space(), limit}); }

void limit_memory(double bytes) { limit = bytes; }

void require_memory(double bytes, const std::string& what) {
  const double available = available_memory();
  if (!(bytes <= available))
    throw InputError(what + " needs " + megabytes(bytes) + " of memory, and " + megabytes(available) + " is available");
}

}  // namespace lockstep
