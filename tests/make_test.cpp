// The commands of the Makefile that are more than a call of the program: what they refuse, and what they pass on.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdio>
#include <string>

namespace lockstep {
namespace {

struct Made {
  int code;
  std::string text;  // of both outputs
};

// Runs make as a user does, with more words for env before it; variables of a make around the tests do not count.
Made make(const std::string& arguments, const std::string& environment = "") {
  const std::string command = "env -u MAKEFLAGS -u MAKELEVEL -u MAKEOVERRIDES " + environment + " make " + arguments + " 2>&1";
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
  EXPECT_NE(made.text.find("FORM=cell_lock of fluid/forces, expected one of: owner_gather, pair_lists, sub_grid, cell_locks\n"),
            std::string::npos) << made.text;
  EXPECT_NE(make("-o build/lockstep diff KERNEL=fluid/advance FORM=x").text.find("expected none"), std::string::npos);
}

}  // namespace
}  // namespace lockstep
