#include "verify/verdicts.h"

#include <algorithm>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "verify/names.h"

namespace lockstep::verify {
namespace {

// A line for each kernel: its rows by verdict, and which came nearest to its bound.
void print_kernels(const nlohmann::ordered_json& rows, bool only_failed) {
  struct OfKernel {
    std::string name;
    int rows = 0, failed = 0;
    std::map<std::string, int> verdicts = {};
    double nearest = 0;  // error over bound
  };
  std::vector<OfKernel> kernels;
  for (const auto& row : rows) {
    if (kernels.empty() || kernels.back().name != row["kernel"]) kernels.push_back({row["kernel"]});
    OfKernel& kernel = kernels.back();
    const double error = row["error"], bound = row["bound"];
    ++kernel.rows;
    kernel.failed += !row["passed"].get<bool>();
    ++kernel.verdicts[row["verdict"]];
    if (bound > 0) kernel.nearest = std::max(kernel.nearest, error / bound);
  }
  if (only_failed) std::erase_if(kernels, [](const OfKernel& kernel) { return kernel.failed == 0; });
  if (!kernels.empty())
    std::printf("\n%-27s %5s %6s  %11s  %s\n", "kernel", "rows", "failed", "error/bound", "verdicts");
  for (const OfKernel& kernel : kernels) {
    std::vector<std::string> verdicts;
    for (const auto& [name, count] : kernel.verdicts) verdicts.push_back(std::to_string(count) + ' ' + name);
    char nearest[16] = "-";
    if (kernel.nearest > 0) std::snprintf(nearest, sizeof nearest, "%.3g", kernel.nearest);
    std::printf("%-27s %5d %6d  %11s  %s\n", kernel.name.c_str(), kernel.rows, kernel.failed, nearest,
                joined(verdicts, ", ").c_str());
  }
}

}  // namespace

void print_head() {
  std::printf("%-19s %-13s %-15s %7s %5s  %-9s %10s %10s %9s %9s  %s\n", "kernel", "form", "scene", "threads", "lanes",
              "verdict", "error", "bound", "serial ms", "openmp ms", "worst at");
}

void print_verdict(const nlohmann::ordered_json& row) {
  const auto text = [&](const char* key) { return row[key].get<std::string>(); };
  const auto number = [&](const char* key) { return row[key].get<double>(); };
  std::printf("%-19s %-13s %-15s %7d %5d  %-9s %10.3g %10.3g %9.2f %9.2f  %s%s\n", text("kernel").c_str(),
              text("form").c_str(), text("scene").c_str(), row["threads"].get<int>(), row["lanes"].get<int>(),
              text("verdict").c_str(), number("error"), number("bound"), number("serial_ms"), number("openmp_ms"),
              row["passed"].get<bool>() ? "" : "FAILED ", text("worst_at").c_str());
  std::fflush(stdout);
}

int sum_up(const nlohmann::ordered_json& rows, bool only_failed) {
  print_kernels(rows, only_failed);
  const auto failed = std::ranges::count_if(rows, [](const auto& row) { return !row["passed"].template get<bool>(); });
  std::printf("%d passed, %d failed\n", static_cast<int>(rows.size() - failed), static_cast<int>(failed));
  return failed == 0 ? 0 : 1;
}

int sum_up_endured(const nlohmann::ordered_json& rows) {
  int passed = 0, refused = 0, failed = 0;
  for (const auto& row : rows) ++(row["fault"] != "" ? failed : row["refusal"] != "" ? refused : passed);
  std::printf("%d passed, %d refused, %d failed\n", passed, refused, failed);
  return failed == 0 ? 0 : 1;
}

}  // namespace lockstep::verify
