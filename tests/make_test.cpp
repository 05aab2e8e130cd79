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

// Runs make as a user does; variables of a make around the tests do not count.
Made make(const std::string& arguments) {
  FILE* const pipe = popen(("env -u MAKEFLAGS -u MAKELEVEL -u MAKEOVERRIDES make " + arguments + " 2>&1").c_str(), "r");
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
  has("figures", "measure.py build/lockstep build/figures ");
  has("figures FIGURE=sph_locks THREADS=all RESUME=1", "build/figures/sph_locks --figure 'sph_locks'");
  has("figures FIGURE=sph_locks THREADS=all RESUME=1", "--threads all");
  has("figures FIGURE=sph_locks THREADS=all RESUME=1", "--resume");
  has("figures FIGURE=sph_locks", "draw.py build/figures/sph_locks sph_locks");
}

}  // namespace
}  // namespace lockstep
