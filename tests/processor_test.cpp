// On a processor without the instructions that the program was built for, it says so. glibc can be told that the
// processor has fewer instructions than it has.
#include <cstdlib>

#include "tests/cli.h"

namespace lockstep {
namespace {

struct Processor : Cli {
  Outcome without(const std::string& feature) const {
    const std::string masked = "glibc.cpu.hwcaps=-" + feature;
    return end_of(start({"--version"}, [&] { setenv("GLIBC_TUNABLES", masked.c_str(), 1); }));
  }
  void expect_said(const std::string& feature) const {
    const Outcome outcome = without(feature);
    EXPECT_EQ(outcome.code, 2) << feature;
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(outcome.err.find("lockstep: this processor has no " + feature +
                               ", for which the program was built; "), 0u)
        << outcome.err;
    EXPECT_EQ(outcome.error_lines(), 1);
  }
};

TEST_F(Processor, LacksInstructionsInWords) {
#if defined(LOCKSTEP_ISA_AVX512)
  for (const char* feature : {"AVX512F", "AVX512BW", "AVX512CD", "AVX512DQ", "AVX512VL"}) expect_said(feature);
#endif
#if defined(LOCKSTEP_ISA_AVX512) || defined(LOCKSTEP_ISA_AVX2)
  for (const char* feature : {"AVX2", "FMA", "BMI1", "BMI2", "LZCNT", "MOVBE"}) expect_said(feature);
#endif
}

TEST_F(Processor, MayLackWhatTheProgramDoesNotUse) {
  EXPECT_EQ(without("RTM").code, 0);
#if defined(LOCKSTEP_ISA_PORTABLE)
  EXPECT_EQ(without("AVX2").code, 0);
#endif
}

}  // namespace
}  // namespace lockstep
