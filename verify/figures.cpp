// The numbers behind the figures: one CSV a figure, which notes/figures/NAME.py draws.
#include <cstdio>
#include <filesystem>
#include <ostream>
#include <string>

#include "common/atomic_file.h"
#include "common/cloth/make.h"
#include "common/input_error.h"
#include "verify/cloth_forms.h"
#include "verify/cloth_run.h"
#include "verify/options.h"
#include "verify/report.h"

namespace lockstep::verify {
namespace {

// Residual over iterations, by the order in which constraints are enforced.
void cloth_convergence(std::ostream& csv) {
  csv << "scene,form,iterations,residual\n";
  for (const std::string scene : {"flag_33", "sheet_on_sphere", "rope", "pulled_edge"}) {
    const cloth::Cloth<float> start = cloth::convert<float>(cloth::load_scene("scenes/cloth/" + scene + ".toml").cloth);
    for (const ClothForm& form : cloth_forms)
      for (const int n : {5, 7, 10, 14, 20, 28, 40, 57, 80, 113, 160}) {
        progress("cloth_convergence: " + scene + ' ' + form.name + ", " + std::to_string(n) + " iterations");
        cloth::Relax<float>* const relax = form.openmp_relax ? form.openmp_relax : form.serial_relax;
        csv << scene << ',' << form.name << ',' << n << ',' << residual_left(start, relax, n) << '\n';
      }
  }
}

struct Figure {
  const char* name;
  void (*write)(std::ostream& csv);
};

constexpr Figure all_figures[] = {{"cloth_convergence", cloth_convergence}};

}  // namespace

int figures(const FigureOptions& options) {
  std::error_code error;
  std::filesystem::create_directories(options.out, error);
  if (error) throw InputError(options.out + ": cannot be made: " + error.message());
  for (const Figure& figure : all_figures) {
    const std::string path = options.out + '/' + figure.name + ".csv";
    write_file(path, figure.write);
    progress("");
    std::printf("%s\n", path.c_str());
  }
  return 0;
}

}  // namespace lockstep::verify
