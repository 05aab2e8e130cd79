// What the command line asks of the subcommands.
#pragma once

#include <string>
#include <vector>

namespace lockstep::verify {

struct Options {
  std::string kernel, form;  // only this one; all where empty
  std::string scene;         // only this one: a name that the kernels know, or a file of the user's own
  std::vector<int> threads;  // at these counts
  bool full = false;         // all scenes
  std::string json;          // where the rows go; nowhere if empty
};

struct RunOptions {
  std::string scene;
  std::string variant = "openmp";
  std::string form;  // the variant's first where empty
  int threads = 0;   // as OpenMP chooses where 0
  int frames = 0;    // the scene's where 0
  std::string out;
};

struct FigureOptions {
  std::string out;  // a folder
};

// Each returns the program's exit code: 0, or 1 where a check failed. Bad input throws InputError.
int verify(const Options& options);
int bench(const Options& options);
int run(const RunOptions& options);
int figures(const FigureOptions& options);  // writes the numbers behind each figure, NAME.csv

}  // namespace lockstep::verify
