// The command line's options, for each subcommand.
#pragma once

#include <string>
#include <vector>

namespace lockstep::verify {

struct Options {
  std::string kernel, form;  // only this one; all if empty
  std::string scene;         // only this one: a name that the kernels register, or a user's own file
  std::vector<int> threads;  // thread counts
  bool full = false;         // all scenes
  bool quick = false;        // fewer repeats, for a quick test
  std::string json;          // file for the rows; none if empty
};

struct ScaleOptions : Options {
  std::vector<int> cores;  // numbers of cores
};

struct RunOptions {
  std::string scene;
  std::string variant = "openmp";
  std::string form;  // the variant's first form if empty
  int threads = 0;   // OpenMP's choice if 0
  int frames = 0;    // the scene's number if 0
  std::string out;
  bool resume = false;  // from the last frame in `out`
  bool force = false;   // replace the frames of another run in `out`
};

struct EndureOptions {
  std::string scene;  // only this one; all scenes that move if empty
  int steps = 20000;
  std::string json;
};

struct FigureOptions {
  std::string out;     // a folder
  bool quick = false;  // fewer and smaller runs, for a quick test
};

struct ListOptions {
  bool json = false, markdown = false;
};

// Each returns the program's exit code: 0, or 1 if a check failed. Bad input throws InputError.
int list(const ListOptions& options);
int verify(const Options& options);
int bench(const Options& options);
int scale(const ScaleOptions& options);
int run(const RunOptions& options);         // 128 + the signal's number if a signal stopped it
int endure(const EndureOptions& options);   // long runs: memory must not grow, values stay valid
int figures(const FigureOptions& options);  // writes the data of each figure, NAME.json

}  // namespace lockstep::verify
