// Ends the program in words on a processor that lacks the instructions it was built for, where it would die of SIGILL.
//
// The check runs before the initialisers of all other files. The Makefile compiles this file for any x86-64 processor,
// so it includes no header with inline functions: the linker keeps one copy of such a function, perhaps another file's.
#define _Bool bool  // the header is written for C
#include <sys/platform/x86.h>
#undef _Bool
#include <unistd.h>

#include <cstring>

namespace {

#define FEATURE(name) {#name, x86_cpu_##name}
constexpr struct Feature {
  const char* name;
  unsigned place;  // as x86_cpu_active() takes it
} needed[] = {
#if defined(LOCKSTEP_ISA_AVX512) || defined(LOCKSTEP_ISA_AVX2)  // x86-64-v3
    FEATURE(CMPXCHG16B), FEATURE(LAHF64_SAHF64), FEATURE(POPCNT), FEATURE(SSE3), FEATURE(SSSE3), FEATURE(SSE4_1),
    FEATURE(SSE4_2), FEATURE(AVX), FEATURE(AVX2), FEATURE(BMI1), FEATURE(BMI2), FEATURE(F16C), FEATURE(FMA),
    FEATURE(LZCNT), FEATURE(MOVBE),
#endif
#if defined(LOCKSTEP_ISA_AVX512)  // x86-64-v4
    FEATURE(AVX512F), FEATURE(AVX512BW), FEATURE(AVX512CD), FEATURE(AVX512DQ), FEATURE(AVX512VL),
#endif
    FEATURE(SSE2)};

void say(const char* text) { [[maybe_unused]] const auto written = write(STDERR_FILENO, text, strlen(text)); }

// 101 is the first priority that a program may use; initialisers of C++ come at 65535.
[[gnu::constructor(101)]] void require_instructions() {
  for (const Feature& feature : needed) {
    if (x86_cpu_active(feature.place)) continue;
    say("lockstep: this processor has no "), say(feature.name);
    say(", for which the program was built; build it here with `make`, or for any processor with ");
    say("`make ISA=portable`\n");
    _exit(2);
  }
}

}  // namespace
