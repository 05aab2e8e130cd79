// Lists every kernel, its forms and their scenes, as verify/DOMAIN/KERNEL.cpp registers them. Scripts read the JSON:
// tsan, determinism, fuzz, mutants, figures. README's table is the Markdown output.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "verify/domain.h"
#include "verify/kernel.h"
#include "verify/names.h"
#include "verify/options.h"
#include "verify/report.h"

namespace lockstep::verify {
namespace {

std::vector<std::string> names_of(std::vector<std::string> paths) {
  for (std::string& path : paths) path = std::filesystem::path(path).stem();
  return paths;
}

// "`a`, `b`"; "one" for a form without a name.
std::string quoted(const std::vector<std::string>& forms) {
  std::string all;
  for (const std::string& form : forms) all += (all.empty() ? "" : ", ") + (form.empty() ? "one" : '`' + form + '`');
  return all;
}

// One line a kernel: its serial forms, and its openmp forms except those that run another form's code.
void print_markdown(const std::vector<Kernel>& all) {
  std::puts("| kernel | serial forms | openmp forms |\n|---|---|---|");
  for (auto kernel = all.begin(); kernel != all.end();) {
    const auto next = std::find_if(kernel, all.end(), [&](const Kernel& other) { return other.name != kernel->name; });
    std::vector<std::string> forms;
    for (auto form = kernel; form != next; ++form)
      if (form->covered_by.empty()) forms.push_back(form->form);
    std::printf("| `%s` | %s | %s |\n", kernel->name.c_str(), quoted(kernel->serial_forms).c_str(),
                quoted(forms).c_str());
    kernel = next;
  }
}

void print_table(const std::vector<Kernel>& all) {
  std::printf("%-23s %-22s %s\n", "kernel", "form", "scenes; more with FULL=1");
  for (const Kernel& kernel : all)
    std::printf("%-23s %-22s %s; %s\n", kernel.name.c_str(), kernel.form.c_str(),
                joined(names_of(kernel.scenes), " ").c_str(), joined(names_of(kernel.more_scenes), " ").c_str());
}

// One name a line, for loops of a shell: kernels, forms (the kernel, then the form where it has a name), or scenes.
void print_names(const std::string& of, const std::vector<Kernel>& all) {
  std::vector<std::string> names;
  if (of == "scenes")
    for (const Domain& domain : domains()) {
      std::vector<std::string> own;
      for (const auto& entry : std::filesystem::directory_iterator(scenes_folder() + '/' + domain.name))
        if (entry.path().extension() == ".toml") own.push_back(entry.path().stem());
      std::ranges::sort(own);
      names.insert(names.end(), own.begin(), own.end());
    }
  else
    for (const Kernel& kernel : all)
      names.push_back(of == "kernels" || kernel.form.empty() ? kernel.name : kernel.name + ' ' + kernel.form);
  names.erase(std::unique(names.begin(), names.end()), names.end());
  for (const std::string& name : names) std::puts(name.c_str());
}

}  // namespace

int list(const ListOptions& options) {
  const std::vector<Kernel> all = kernels();
  auto of_domains = nlohmann::ordered_json::array(), rows = nlohmann::ordered_json::array();
  for (const Domain& domain : domains())
    of_domains.push_back({{"name", domain.name},
                          {"runs", domain.simulation != nullptr},
                          {"moves", domain.moves},
                          {"determinism", domain.determinism},
                          {"formats", domain.formats}});
  for (const Kernel& kernel : all)
    rows.push_back({{"kernel", kernel.name},
                    {"form", kernel.form},
                    {"covered_by", kernel.covered_by},
                    {"order_dependent", kernel.order_dependent},
                    {"scenes", names_of(kernel.scenes)},
                    {"more_scenes", names_of(kernel.more_scenes)},
                    {"bench_scenes", names_of(kernel.bench_scenes)},
                    {"tsan_scenes", names_of(kernel.tsan_scenes)},
                    {"serial_forms", kernel.serial_forms}});
  const nlohmann::ordered_json report = {
      {"schema", schema}, {"machine", machine()}, {"domains", of_domains}, {"rows", rows}};
  if (options.json)
    std::puts(report.dump(2).c_str());
  else if (options.markdown)
    print_markdown(all);
  else if (!options.names.empty())
    print_names(options.names, all);
  else
    print_table(all);
  return 0;
}

}  // namespace lockstep::verify
