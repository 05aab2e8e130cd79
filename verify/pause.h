// For loops in which a thread waits.
#pragma once

namespace lockstep::verify {

// Tells the processor that this thread waits in a loop.
inline void pause() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#endif
}

}  // namespace lockstep::verify
