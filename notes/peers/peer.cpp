#include "notes/peers/peer.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "verify/costs.h"
#include "verify/held_team.h"
#include "verify/program.h"
#include "verify/report.h"
#include "verify/team.h"

namespace lockstep::peers {
namespace {

// libgomp's and TBB's threads turn for some milliseconds after their last work before they sleep.
void let_threads_sleep() { std::this_thread::sleep_for(std::chrono::milliseconds(20)); }

std::vector<std::string> parts_of(const std::string& list) {
  std::vector<std::string> parts;
  std::istringstream in(list);
  for (std::string part; std::getline(in, part, ',');) parts.push_back(part);
  return parts;
}

}  // namespace

Json take_turns(int threads, double items, const Side& peer, const Side& ours) {
  double turns = 0;  // the fewest of a round: iterations per ns of a loop over registers (verify/samples.h)
  const auto timed = [&](const Side& side, bool held) {
    side.prepare();
    let_threads_sleep();
    double seconds = 0;
    const auto time_it = [&] {
      const double start = verify::now();
      side.work();
      seconds = verify::now() - start;
    };
    if (!held) time_it();
    verify::hold_team(threads, [&] {
      verify::wake_team();
      turns = std::min(turns, verify::turns_per_ns(threads));
      if (!held) return;
      verify::take_team_sizes();
      time_it();
      if (const verify::TeamSizes teams = verify::take_team_sizes(); !teams.are(threads))
        throw std::runtime_error(verify::other_team(teams, threads));
      turns = std::min(turns, verify::turns_per_ns(threads));
    });
    return seconds;
  };
  Json samples = Json::array(), ours_samples = samples;
  std::vector<double> turns_of_rounds;
  double spent = 0;
  const auto enough = [&](int rounds) {
    return rounds >= 60 || (rounds >= 9 && spent > 4) || (rounds >= 3 && spent > 12);
  };
  for (int round = -1; !enough(round); ++round) {
    turns = std::numeric_limits<double>::infinity();
    const double peer_s = timed(peer, peer.held), ours_s = timed(ours, true);
    if (round < 0) continue;  // a warm-up: memory, caches, threads
    samples.push_back(peer_s * 1e3 / items), ours_samples.push_back(ours_s * 1e3 / items);
    turns_of_rounds.push_back(turns);
    spent += peer_s + ours_s;
  }
  double most = 0;  // of one thread, alone
  for (int k = 0; k < 20; ++k) most = std::max(most, verify::turns_per_ns(1));
  std::ranges::sort(turns_of_rounds);
  const double cores = turns_of_rounds[turns_of_rounds.size() / 2] / most;
  return {{"threads", threads},
          {"cores", cores},
          {"whole_cores", cores >= .9 * threads},
          {"samples", samples},
          {"ours_samples", ours_samples}};
}

Asked asked(int count, char** words) {
  if (count != 3) throw std::runtime_error("expected SCENE[,SCENE] THREADS[,THREADS]");
  Asked found{.scenes = parts_of(words[1]), .threads = {}};
  for (const std::string& part : parts_of(words[2])) found.threads.push_back(std::stoi(part));
  return found;
}

std::string path_of(const std::string& domain, const std::string& scene) {
  return scene.ends_with(".toml") ? scene : "scenes/" + domain + "/" + scene + ".toml";
}

int report(const std::function<void(Json& rows)>& compare) {
  try {
    Json rows = Json::array();
    compare(rows);
    std::printf("%s\n", Json{{"machine", verify::machine()}, {"rows", rows}}.dump().c_str());
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}

}  // namespace lockstep::peers
