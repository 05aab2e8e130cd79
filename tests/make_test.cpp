// The commands of the Makefile that are more than a call of the program: what they refuse, and what they pass on.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdio>
#include <filesystem>
#include <string>

#include "tests/temporary_folder.h"

namespace lockstep {
namespace {

struct Made {
  int code;
  std::string text;  // of both outputs
};

// Runs make as a user does, with more words for env before it; variables of a make around the tests do not count.
Made make(const std::string& arguments, const std::string& environment = "") {
  const std::string command =
      "env -u MAKEFLAGS -u MAKELEVEL -u MAKEOVERRIDES " + environment + " make " + arguments + " 2>&1";
  FILE* const pipe = popen(command.c_str(), "r");
  Made made = {-1, ""};
  for (int letter; pipe && (letter = std::fgetc(pipe)) != EOF;) made.text += static_cast<char>(letter);
  const int status = pipe ? pclose(pipe) : -1;
  if (WIFEXITED(status)) made.code = WEXITSTATUS(status);
  return made;
}

TEST(Make, RefusesVariablesThatItDoesNotKnow) {
  for (const std::string name : {"threads", "KERNELS", "Scene"}) {
    const Made made = make("-n help " + name + "=2");
    EXPECT_EQ(made.code, 2);
    EXPECT_NE(made.text.find("unknown variable " + name), std::string::npos) << made.text;
  }
  EXPECT_EQ(make("-n help THREADS=2 FLAGS='-O1 -DX=1 -fno-y' KERNEL='a b'").code, 0);
}

TEST(Make, DiffFailsWithoutTwoFiles) {
  const Made made = make("diff KERNEL=fluid/density");
  EXPECT_EQ(made.code, 2);
  EXPECT_NE(made.text.find("fluid/densities"), std::string::npos) << made.text;
  EXPECT_EQ(make("diff KERNEL=fluid/advance").code, 0);
}

TEST(Make, PassesOnWhatItIsGiven) {
  const auto has = [](const std::string& arguments, const std::string& part) {
    const std::string text = make("-n -o build/lockstep " + arguments).text;
    EXPECT_NE(text.find(part), std::string::npos) << text;
  };
  has("run SCENE='my scenes/a.toml' FORM=sub_grid", "--scene 'my scenes/a.toml'");
  has("run SCENE=dam_break_5k FORM=sub_grid", "--form sub_grid");
  has("bench QUICK=1", "--quick");
  has("verify KERNEL='*/step'", "--kernel '*/step'");
  has("verify FAILED=1", "--failed");
  has("bench RESUME=1", "--resume");
  has("view SCENE=flag_33", "view.py build/lockstep 'flag_33'");
  has("view SCENE='my scenes/a.toml' FORM=sub_grid VARIANT=openmp FRAMES=9", "'my scenes/a.toml'");
  has("view SCENE=dam_break_5k FORM=sub_grid VARIANT=openmp FRAMES=9", "--variant openmp");
  has("view SCENE=dam_break_5k FORM=sub_grid VARIANT=openmp FRAMES=9", "--form sub_grid");
  has("view SCENE=dam_break_5k FORM=sub_grid VARIANT=openmp FRAMES=9", "--frames 9");
  has("figures", "measure.py build/lockstep build/figures ");
  has("figures FIGURE=sph_locks THREADS=all RESUME=1", "build/figures/sph_locks --figure 'sph_locks'");
  has("figures FIGURE=sph_locks THREADS=all RESUME=1", "--threads all");
  has("figures FIGURE=sph_locks THREADS=all RESUME=1", "--resume");
  has("figures FIGURE=sph_locks", "draw.py build/figures/sph_locks sph_locks");
  has("peers", "compare.py build/peers.json --programs build/");
  has("peers ONLY=ode/castle ADD=rows.json", "--only 'ode/castle' --add 'rows.json'");
}

TEST(Make, DiffShowsAFormAlone) {
  const Made cell_locks = make("-o build/lockstep diff KERNEL=fluid/forces FORM=cell_locks WIDTH=240");
  EXPECT_EQ(cell_locks.code, 0);
  for (const char* part : {"void forces_symmetric(", "void forces_cell_locks(", "Locks locks(grid.cells());"})
    EXPECT_NE(cell_locks.text.find(part), std::string::npos) << cell_locks.text;
  for (const char* part : {"forces_sub_grid", "forces_pair_lists", "forces_owner_gather", "#include"})
    EXPECT_EQ(cell_locks.text.find(part), std::string::npos) << cell_locks.text;
  const auto shows = [](const std::string& arguments, const std::string& part) {
    const Made made = make("-o build/lockstep diff WIDTH=240 " + arguments);
    EXPECT_EQ(made.code, 0);
    EXPECT_NE(made.text.find(part), std::string::npos) << made.text;
  };
  shows("KERNEL=linear/update FORM=axpy", "void axpy(Real a");
  shows("KERNEL=rigid/bvh FORM=refit", "void bvh_refit(");  // its file is in spatial/
  shows("KERNEL=rigid/batches FORM=parallel", "Batches batches_parallel(");
  shows("KERNEL=linear/multiply FORM=block_rows", "void multiply(const BlockRows<Real>& a");
  shows("KERNEL=rigid/contact_solver FORM=batches", "struct Contacts {");
}

TEST(Make, DiffNamesTheFormsOfAKernel) {
  const Made made = make("-o build/lockstep diff KERNEL=fluid/forces FORM=cell_lock");
  EXPECT_EQ(made.code, 2);
  EXPECT_NE(made.text.find("FORM=cell_lock of fluid/forces, expected one of: owner_gather, pair_lists, sub_grid, "
                           "cell_locks\n"),
            std::string::npos) << made.text;
  EXPECT_NE(make("-o build/lockstep diff KERNEL=fluid/advance FORM=x").text.find("expected none"), std::string::npos);
}

struct MakeWithTools : TemporaryFolder {
  // A program of this name, first in the PATH of with_tools().
  void tool(const std::string& name, const std::string& script) const {
    write_bytes(path(name), "#!/bin/sh\n" + script + '\n');
    std::filesystem::permissions(path(name), std::filesystem::perms(0755));
  }
  // The PATH of a system that has these tools only, and what the Makefile reads the machine with.
  std::string with_tools() const {
    for (const std::string name : {"make", "grep", "find", "nproc", "readlink"})
      if (!std::filesystem::exists(path(name))) std::filesystem::create_symlink("/usr/bin/" + name, path(name));
    return "PATH=" + folder;
  }
};

TEST_F(MakeWithTools, UseAllCoresUnlessTold) {
  write_bytes(path("show.mk"), "show first second: ; @echo 'jobs:' $(filter -j%,$(MAKEFLAGS)) of $@; true\n");
  tool("nproc", "echo 7");
  const auto jobs = [&](const std::string& arguments) {
    return make("-f Makefile -f " + path("show.mk") + ' ' + arguments, with_tools()).text;
  };
  EXPECT_EQ(jobs("show"), "jobs: -j7 of show\n");
  EXPECT_EQ(jobs("-j3 show"), "jobs: -j3 of show\n");
}

TEST_F(MakeWithTools, RunsCommandsOneAfterAnother) {
  const std::string text = make("-n deps help clean").text;
  const auto deps = text.find("dpkg-query"), help = text.find("sed -nE"), clean = text.find("rm -rf build");
  EXPECT_TRUE(deps < help && help < clean && clean != std::string::npos) << text;
}

TEST_F(MakeWithTools, DepsInstallsWhatIsMissing) {
  tool("dpkg-query", "case \"$*\" in *libccd-dev | *make) exit 1;; esac; echo install ok installed");
  tool("apt-get", "echo apt-get $*");
  tool("id", "echo 0");
  EXPECT_EQ(make("deps", with_tools()).text, "apt-get update -qq\napt-get install -y -qq make libccd-dev\n");

  tool("id", "echo 1000");
  const std::string line = "make deps: as root, type: apt-get update && apt-get install make libccd-dev\n";
  const Made without_sudo = make("deps", with_tools());
  EXPECT_EQ(without_sudo.code, 2);
  EXPECT_EQ(without_sudo.text.find(line), 0u) << without_sudo.text;

  tool("sudo", "echo sudo $*");
  EXPECT_EQ(make("deps", with_tools()).text,
            "sudo apt-get install make libccd-dev\n"
            "sudo apt-get update -qq\nsudo apt-get install -y -qq make libccd-dev\n");
  tool("sudo", "exit 1");
  const Made refused = make("deps", with_tools());
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.text.find(line), std::string::npos) << refused.text;

  tool("dpkg-query", "echo install ok installed");
  EXPECT_EQ(make("deps", with_tools()).text, "all packages are installed\n");
}

TEST_F(MakeWithTools, NamesThePackagesThatBuildingLacks) {
  const auto build = [&](const std::string& compiler, const std::string& target) {
    return make("BUILD=" + path("build") + " CXX='" + compiler + "' " + path("build/" + target));
  };
  const std::string these_headers = "g++ -nostdinc -I " + folder;
  for (const std::string header : {"CLI/CLI.hpp", "nlohmann/json.hpp", "libqhull_r/qhull_ra.h", "eigen3/Eigen/Dense",
                                   "Random123/philox.h", "gtest/gtest.h", "suitesparse/cholmod.h"}) {
    std::filesystem::create_directories(std::filesystem::path(path(header)).parent_path());
    write_bytes(path(header), "");
  }
  const Made program = build(these_headers, "common/toml.o"), tests = build(these_headers, "needs_of_tests");
  EXPECT_EQ(program.code, 2);
  EXPECT_EQ(program.text.find("make: libtomlplusplus-dev missing; make deps installs all packages, README.md names "
                              "them\n"),
            0u) << program.text;
  EXPECT_EQ(tests.text.find("make: libccd-dev missing;"), 0u) << tests.text;
  EXPECT_EQ(build("no-such-g++", "needs").text.find("make: the compiler no-such-g++ is missing;"), 0u);
  EXPECT_EQ(build("g++", "needs").code, 0);
}

}  // namespace
}  // namespace lockstep
