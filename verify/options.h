// The command line's options, for each subcommand.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "verify/shard.h"

namespace lockstep::verify {

// What all commands that write reports take.
struct ReportOptions {
  std::string json;            // file for the rows; none if empty
  bool quick = false;          // one sample, and one size of each form, to see that it works
  bool brief = false;          // fewer samples: as many as a figure needs
  bool resume = false;         // go on from the rows in that file
  std::optional<Shard> shard;  // only this share of the cases; all if absent
  std::string command;         // in words, less what changes no row: what shards of one whole have in common
};

struct Options : ReportOptions {
  std::vector<std::string> kernels;  // only these; all if empty
  std::string form;                  // only this one; all if empty
  std::string scene;                 // only this one: a name that the kernels register, or a user's own file
  std::vector<int> threads;          // thread counts
  bool full = false;                 // all scenes
  bool only_failed = false;          // print failures alone
};

struct ScaleOptions : Options {
  std::vector<int> cores;               // numbers of cores
  std::map<std::string, double> given;  // costs of another machine, by their names in the report
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
  bool watch = false;   // for `endure`: what each step must leave is checked after each, even within a frame
};

struct EndureOptions : ReportOptions {
  std::string scene;  // only this one; all scenes that move if empty
  int steps = 20000;
};

// `kernels` and `threads` are those of the reports `bench` and `scale`; `full` takes the largest scenes.
struct FigureOptions : Options {
  std::string out;                   // a folder
  std::vector<std::string> reports;  // only these, without .json; all if empty
};

struct ListOptions {
  std::string names;  // kernels, forms or scenes: their names alone; a table of all if empty
  bool json = false, markdown = false;
};

struct CompareOptions {
  std::string before, after;  // reports of bench
};

struct MergeOptions {
  std::vector<std::string> reports;  // of all shards of one command, in any order
  std::string out;
};

// Each returns the program's exit code: 0, or 1 if a check failed. Bad input throws InputError.
int list(const ListOptions& options);
int verify(const Options& options);
int bench(const Options& options);
int scale(const ScaleOptions& options);
int run(const RunOptions& options);                     // 128 + the signal's number if a signal stopped it
int endure(const EndureOptions& options, char** argv);  // long runs: memory must not grow, values stay valid
int figures(const FigureOptions& options);              // writes the data of each figure, NAME.json
int compare_reports(const CompareOptions& options);     // times of two reports of bench, row by row
int merge_reports(const MergeOptions& options);         // reports of shards as one; 1 if a row of them failed

}  // namespace lockstep::verify
