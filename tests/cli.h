// Tests of the program from outside: starts it with arguments, and checks its exit code and output.
// The environment variable LOCKSTEP names the program (default build/lockstep). Run from the root of the repository.
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <functional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "tests/temporary_folder.h"

namespace lockstep {

inline constexpr int killed = 1000;  // plus the signal
inline constexpr int not_started = 127;

struct Outcome {
  int code;
  std::string out, err;
  long error_lines() const { return std::count(err.begin(), err.end(), '\n'); }
};

// A valid scene, small enough that a step takes almost no time.
inline const std::string good_scene =
    "kind = \"fluid\"\nparticles_per_metre = 204\nframes = 3\n"
    "[[block]]\nmin = [-0.02, -0.08, -0.02]\nmax = [0.02, -0.06, 0.02]\njitter = 0.05\nvelocity = [0.5, 0, -0.3]\n";

// A sheet of 7 x 5 particles, held at a corner so that it swings.
inline const std::string good_cloth =
    "kind = \"cloth\"\nframes = 3\niterations = 4\nwind = [1, 0, 3]\ndrag = 1.2\n"
    "[sheet]\nrows = 7\ncolumns = 5\norigin = [0, 1, 0]\nwidth = [0.2, 0, 0]\nheight = [0, -0.3, 0]\n"
    "mass = 0.01\nbending = true\n"
    "pins = [\"top_left\"]\n";

// A square of two triangles, and a scene with it as a mesh.
inline const std::string good_obj = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n";
inline const std::string good_mesh =
    "kind = \"cloth\"\nframes = 3\niterations = 4\nwind = [1, 0, 3]\ndrag = 1.2\n"
    "[mesh]\nfile = \"cloth.obj\"\nmass = 0.1\nbending = true\npins_above = 0.5\n";

struct Cli : TemporaryFolder {
  std::filesystem::path program;
  std::string captured;  // a folder beside the test's folder, for the program's output

  Cli() {
    const char* named = std::getenv("LOCKSTEP");
    program = std::filesystem::absolute(named ? named : "build/lockstep");
    captured = folder + ".captured";
    std::filesystem::create_directory(captured);
  }
  ~Cli() override { std::filesystem::remove_all(captured); }

  void SetUp() override { ASSERT_TRUE(std::filesystem::exists(program)) << program << ": build it first (make)"; }

  // Starts the program without a shell, which would hide signals and interpret quotes. The child calls `prepare` first.
  pid_t start(
      std::vector<std::string> arguments, const std::function<void()>& prepare = [] {}) const {
    arguments.insert(arguments.begin(), program.string());
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    const pid_t child = fork();
    if (child == 0) {
      const int to_out = open(out_file().c_str(), O_CREAT | O_TRUNC | O_WRONLY, 0644),
                to_err = open(err_file().c_str(), O_CREAT | O_TRUNC | O_WRONLY, 0644);
      dup2(to_out, STDOUT_FILENO), dup2(to_err, STDERR_FILENO);
      prepare();
      execv(argv[0], argv.data());
      _exit(not_started);
    }
    return child;
  }
  // Without the line that warns of other programs, which a test cannot keep away. It is in err_file().
  Outcome end_of(pid_t child) const {
    int status = 0;
    waitpid(child, &status, 0);
    std::string err = read_bytes(err_file());
    if (const std::size_t at = err.find("lockstep: other programs keep"); at != std::string::npos)
      err.erase(at, err.find('\n', at) + 1 - at);
    return {WIFEXITED(status) ? WEXITSTATUS(status) : killed + WTERMSIG(status), read_bytes(out_file()), err};
  }
  // as_nobody: as the user nobody, because permissions do not bind root.
  Outcome run(const std::vector<std::string>& arguments, bool as_nobody = false) const {
    return end_of(start(arguments, [&] {
      if (as_nobody && getuid() == 0 && (setgid(65534) != 0 || setuid(65534) != 0)) _exit(not_started);
    }));
  }
  std::string out_file() const { return captured + "/out"; }
  std::string err_file() const { return captured + "/err"; }

  std::set<std::string> everything() const {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) names.insert(entry.path());
    return names;
  }

  std::string scene(const std::string& text, const std::string& name = "scene.toml") const {
    write_bytes(path(name), text);
    return path(name);
  }

  // Waits until a program that was started has written the file.
  void wait_for(const std::string& file) const {
    const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (!std::filesystem::exists(path(file))) {
      ASSERT_LT(std::chrono::steady_clock::now(), give_up) << file;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }

  // Expects exit code 2, at most `lines` lines of error that contain `about`, and no new file.
  void expect_refused(const std::vector<std::string>& arguments, const std::string& about, int lines = 1,
                      bool as_nobody = false) const {
    std::string command = "lockstep";
    for (const std::string& argument : arguments) command += ' ' + argument;
    SCOPED_TRACE(command);
    const std::set<std::string> before = everything();
    const Outcome outcome = run(arguments, as_nobody);
    if (as_nobody && outcome.code == not_started) GTEST_SKIP() << "nobody may not run " << program;
    EXPECT_EQ(outcome.code, 2) << outcome.err;
    EXPECT_GE(outcome.error_lines(), 1);
    EXPECT_LE(outcome.error_lines(), lines) << outcome.err;
    EXPECT_NE(outcome.err.find(about), std::string::npos) << outcome.err;
    EXPECT_EQ(outcome.err.find("Sanitizer"), std::string::npos) << outcome.err;
    EXPECT_EQ(outcome.out.find("wrote"), std::string::npos) << outcome.out;
    EXPECT_EQ(everything(), before);
  }

  void expect_run_refused(const std::string& scene, const std::string& about) const {
    for (const char* out : {"out.fluid", "frames"})
      expect_refused({"run", "--scene", scene, "--out", path(out)}, about);
  }
};

}  // namespace lockstep
