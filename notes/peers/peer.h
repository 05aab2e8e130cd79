// What the programs of `make peers` share: two ways to do a work take turns, and a row says how they compare.
//
// A program is called as PROGRAM SCENE[,SCENE] THREADS[,THREADS] and prints one JSON object: the machine, and a row for
// each comparison, whose fields stand in notes/peers.md. notes/peers/compare.py adds what the program cannot know.
#pragma once

#include <nlohmann/json.hpp>
#include <functional>
#include <string>
#include <vector>

namespace lockstep::peers {

using Json = nlohmann::ordered_json;

// One way to do the work. `prepare` is not timed; `work` is, and counts as `items` of the row's ms (steps, say).
struct Side {
  std::function<void()> prepare;
  std::function<void()> work;
  bool held = false;  // whether the OpenMP regions of `work` are this program's: they run on a held team then
};

// Lets the peer and ours take turns, on as many threads: three times, up to nine times within 12 s, and up to sixty
// times within 4 s of both together. Ours has a held team, as in `lockstep bench`; a peer in another library has
// whatever threads it was told to use. Threads of the one sleep before the other starts. Returns the fields threads,
// cores, whole_cores, samples (ms an item) and ours_samples.
Json take_turns(int threads, double items, const Side& peer, const Side& ours);

// What this call was asked for.
struct Asked {
  std::vector<std::string> scenes;  // paths or names
  std::vector<int> threads;
};
Asked asked(int count, char** words);

// scenes/DOMAIN/NAME.toml of a name; a path as it is.
std::string path_of(const std::string& domain, const std::string& scene);

// Runs `compare`, which fills rows, and prints the object. Errors are told in a line; returns the program's code.
int report(const std::function<void(Json& rows)>& compare);

}  // namespace lockstep::peers
