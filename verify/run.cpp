// Simulates a scene and writes its frames (verify/frames.h), its final state, or a page for a browser.
//
// After each frame, the state that the next one needs is written beside it, so --resume continues bit for bit. Files
// are written under another name and then renamed, so a run that is stopped in any way leaves whole frames only. The
// state is written after its frame, so that no frame is missing. A frame that is newer than the state is removed and
// computed again, with the same bits.
#include <omp.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <functional>
#include <iterator>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/input_error.h"
#include "common/input_file.h"
#include "verify/compare.h"
#include "verify/frames.h"
#include "verify/held_team.h"
#include "verify/names.h"
#include "verify/options.h"
#include "verify/pages.h"
#include "verify/program.h"
#include "verify/simulation.h"
#include "verify/team.h"

namespace lockstep::verify {
namespace {

// Ends this program in favour of the script that makes a page for a browser. The script runs the program anew for the
// frames.
int make_page(const RunOptions& options) {
  const std::string script = std::filesystem::path(scenes_folder()).parent_path() / "notes/views/view.py";
  if (options.resume) throw InputError("--resume: only what writes frames to a folder can go on");
  if (!std::filesystem::exists(script))
    throw InputError("--out " + options.out + ": " + script + ", which makes the page, is not there");
  const std::string program = std::filesystem::canonical("/proc/self/exe");
  std::vector<std::string> words = {"/usr/bin/python3", "-B",        script,      program,
                                    options.scene,      options.out, "--variant", options.variant};
  const auto add = [&](const char* option, const std::string& value) { words.insert(words.end(), {option, value}); };
  if (!options.form.empty()) add("--form", options.form);
  if (options.threads > 0) add("--threads", std::to_string(options.threads));
  if (options.frames > 0) add("--frames", std::to_string(options.frames));
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  execv(arguments[0], arguments.data());
  throw InputError(words[0] + " cannot be started: " + std::strerror(errno));
}

// Whether --out names one file, not a folder of frames.
bool wants_one_file(const std::string& out, const std::vector<std::string>& formats) {
  const std::string extension = std::filesystem::path(out).extension();
  if (std::ranges::find(formats, extension) != formats.end()) return true;
  for (const char* other : {".fluid", ".vti", ".vtk"})
    if (extension == other)
      throw InputError("--out " + out + ": this kind of scene is not written as " + other + "; a folder is for frames");
  return false;
}

// Identifies the run. Another scene, variant or form gives other bits; other threads or lanes do not.
std::string identity(const Simulation& simulation, const RunOptions& options) {
  std::ifstream in = open_input(options.scene);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  char hash[20];
  std::snprintf(hash, sizeof hash, "%016llx", static_cast<unsigned long long>(hash_bytes(std::span<const char>(text))));
  return simulation.name + ' ' + hash + ", " + std::to_string(simulation.elements) + ' ' + simulation.unit + ", " +
         options.variant + ' ' + simulation.form;
}

volatile std::sig_atomic_t stopped_by = 0;

// The first Ctrl-C stops the run after the current frame, the second one at once.
void stop_at_signals() {
  struct sigaction action = {};
  action.sa_handler = [](int signal) { stopped_by = signal; };
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  for (const int signal : {SIGINT, SIGTERM}) sigaction(signal, &action, nullptr);
}

// Takes steps on the held team, or on one thread while that is faster. Where other programs use a core, the threads of
// a team wait for one another through the time slices of those, and many small steps fit into one slice.
class Stepper {
 public:
  explicit Stepper(const std::function<void()>& step) : step_(step) {}

  void step() {
    const double start = now();
    // Whether other programs are expected to use a core for longer than a step takes.
    const bool shared = cores_shared_for() > last_;
    const bool rests = shared && together_ > 0 && (alone_ == 0 || alone_ < together_);
    if (rests)
      rest_team(step_);
    else
      step_();
    last_ = now() - start;
    if (shared) (rests ? alone_ : together_) = last_;
    seconds += last_, steps_alone += rests;
  }

  double seconds = 0;   // of all steps
  int steps_alone = 0;  // how many were taken on one thread

 private:
  const std::function<void()>& step_;
  double last_ = 0;  // seconds of the last step
  // Seconds of the last steps that the team and that one thread took while a core was shared; 0 if there was none yet.
  double together_ = 0, alone_ = 0;
};

int run_frames(const RunOptions& options) {
  const Simulation simulation = [&] {
    const PagesOfTeam near(options.threads > 0 ? options.threads : omp_get_max_threads());
    return make_simulation(options);
  }();
  const int frames = options.frames > 0 ? options.frames : simulation.frames;
  const bool one_file = wants_one_file(options.out, simulation.state_formats),
             keeps_state = !one_file && !simulation.state.empty();
  const std::string who = identity(simulation, options);
  if (options.resume && !keeps_state) throw InputError("--resume: only what writes frames to a folder can go on");

  std::optional<Frames> folder;
  if (!one_file) folder.emplace(options.out, simulation, options.resume);
  const auto write_frame = [&](int frame) {
    if (folder) folder->write(frame);
    if (keeps_state) write_state(folder->state_file(), who, frame, simulation.state);
  };

  int frame = 0;
  if (options.resume) {
    frame = read_state(folder->state_file(), who, simulation.state);
    folder->forget_after(frame);
  } else {
    if (folder) folder->make_room(options.force), folder->write_fixed();
    write_frame(0);
  }
  const int first = frame;
  stop_at_signals();
  Stepper stepper(simulation.step);
  TeamSizes teams = {0, 0};
  take_team_sizes();
  while (frame < frames && !stopped_by) {
    stepper.step();
    if (const TeamSizes now_teams = take_team_sizes(); !now_teams.are(omp_get_max_threads())) teams = now_teams;
    write_frame(++frame);
    progress("frame " + std::to_string(frame) + " of " + std::to_string(frames));
  }
  progress("");
  if (folder) folder->write_series(frame);
  if (!teams.are(omp_get_max_threads()))
    std::fprintf(stderr, "lockstep: %s\n", other_team(teams, omp_get_max_threads()).c_str());
  if (one_file) simulation.write_state(options.out);
  if (stopped_by) {
    std::fprintf(stderr, "lockstep: stopped after frame %d of %d%s\n", frame, frames,
                 keeps_state ? "; --resume goes on from there" : "");
    return 128 + stopped_by;
  }
  const char* unit = simulation.unit.c_str();
  const int made = frame - first;
  std::printf("%s: %d %s, %d frames, %s %s on %d threads: %.2f ms a frame, %.3g %s a second; wrote %s\n",
              simulation.name.c_str(), simulation.elements, unit, made, options.variant.c_str(),
              simulation.form.c_str(), options.variant == "serial" ? 1 : omp_get_max_threads(),
              1e3 * stepper.seconds / std::max(made, 1), made > 0 ? simulation.elements * made / stepper.seconds : 0,
              unit, options.out.c_str());
  if (stepper.steps_alone > 0)
    std::printf("%d of these frames ran on 1 thread, since other programs used the cores\n", stepper.steps_alone);
  if (simulation.summary && made > 0) std::printf("%s\n", simulation.summary().c_str());
  return 0;
}

}  // namespace

int run(const RunOptions& options) {
  if (std::filesystem::path(options.out).extension() == ".html") return make_page(options);
  int code = 0;
  hold_team(options.threads > 0 ? options.threads : omp_get_max_threads(), [&] { code = run_frames(options); });
  return code;
}

}  // namespace lockstep::verify
