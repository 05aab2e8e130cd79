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
  bool quick = false;        // fewer repeats, where times need not be good
  std::string json;          // where the rows go; nowhere if empty
};

struct ScaleOptions : Options {
  std::vector<int> cores;  // on these numbers of cores
};

struct RunOptions {
  std::string scene;
  std::string variant = "openmp";
  std::string form;  // the variant's first where empty
  int threads = 0;   // as OpenMP chooses where 0
  int frames = 0;    // the scene's where 0
  std::string out;
  bool resume = false;  // from the last frame that is in `out`
};

struct EndureOptions {
  std::string scene;  // only this one; all that move where empty
  int steps = 20000;
  std::string json;
};

struct FigureOptions {
  std::string out;     // a folder
  bool quick = false;  // less of everything: to see that it works
};

struct ListOptions {
  bool json = false, markdown = false;
};

// Each returns the program's exit code: 0, or 1 where a check failed. Bad input throws InputError.
int list(const ListOptions& options);
int verify(const Options& options);
int bench(const Options& options);
int scale(const ScaleOptions& options);
int run(const RunOptions& options);         // or 128 + the number of the signal that stopped it
int endure(const EndureOptions& options);   // runs scenes long, to see that nothing grows or breaks
int figures(const FigureOptions& options);  // writes the numbers behind each figure, NAME.json

}  // namespace lockstep::verify
