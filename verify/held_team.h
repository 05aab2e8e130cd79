// Teams of threads that wait calmly.
//
// Between two parallel regions, and at barriers, libgomp's threads turn in a loop for milliseconds before they sleep.
// Where another program uses a core, the thread that all wait for is not running, and the thread that turns keeps its
// core from it: two threads became up to a thousand times slower than one. Fewer turns help there, but then idle
// machines pay for sleep at every barrier (notes/waiting.md). A held team waits in its own way: it turns for some
// microseconds, then lets other threads have its core, then sleeps.
#pragma once

#include <functional>

namespace lockstep::verify {

// Runs `work` on this thread, with a team of `threads` threads (at least 1) at hand. The parallel regions that `work`
// opens run on the team, which OpenMP forms once, here. omp_get_max_threads() is `threads`, also afterwards. OpenMP may
// give fewer threads (OMP_THREAD_LIMIT, OMP_DYNAMIC); the regions then have fewer, too. Exceptions of `work` pass
// through. Regions inside regions run on one thread, as everywhere in Lockstep.
//
// The team is not held, and each region forms its own as OpenMP does by default, where `threads` is 1, where the user
// has set OMP_WAIT_POLICY or GOMP_SPINCOUNT, and where OpenMP's runtime is not libgomp.
//
// Not to be called from a parallel region, or from `work`.
void hold_team(int threads, const std::function<void()>& work);

// For how long another program is expected to go on using a core of the held team's, in s: 0 if none does, or no team
// is held. It is known by threads that got their cores back late (verify/crew.cpp).
double cores_shared_for();

// Runs `work` while the other threads of the held team sleep: each region has one thread. omp_get_max_threads() stays
// as it is. Exceptions of `work` pass through. Without a held team it just runs `work`. To be called from hold_team's
// `work`, outside regions.
void rest_team(const std::function<void()>& work);

// How threads wait for one another, for reports: "held team" or "OpenMP's runtime".
const char* way_to_wait();

}  // namespace lockstep::verify
