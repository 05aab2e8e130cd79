// Flags: a thread says how far it has come, and others wait until it is far enough. Where each waits for one or two
// others, this costs less than a barrier of all.
//
// What a thread wrote before it posts, others see after they have awaited the value. The values of a flag only rise.
// An awaited post must not depend on the thread that awaits it, or both wait for ever.
#pragma once

#include "common/waiting.h"

namespace lockstep {

// On a cache line of its own: its owner writes it while others work.
struct alignas(64) Flag : Awaited {};

// C names, so that the linker can send the calls elsewhere (verify/record_wraps.cpp).
extern "C" {
void lockstep_post(lockstep::Flag* flag, int value);
void lockstep_await(const lockstep::Flag* flag, int value);
}

// Sets the flag. Of one thread.
inline void post(Flag& flag, int value) { lockstep_post(&flag, value); }

// Waits until the flag has the value or a greater one.
inline void await(const Flag& flag, int value) { lockstep_await(&flag, value); }

}  // namespace lockstep
