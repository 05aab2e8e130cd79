// Whether the pairs of a step of rigid bodies fit the memory.
#pragma once

namespace lockstep::rigid {

// Bytes that a step may need for each pair that a broad phase finds, if all of them touch: five copies of the pair
// (found, ordered, merged, sorted by kinds, kept); its place; three manifolds (found, this step's, the last step's);
// the impulses of both steps; the solver's constraint and its place in the batches.
double bytes_per_pair();

// Called when a broad phase has counted `pairs` and the caller's array has room for `room`. Throws InputError if the
// pairs need a larger array and a step with that many may not fit the available memory. A crowd of n bodies in one
// place has n (n - 1) / 2 pairs.
void require_contacts_fit(double pairs, double room);

}  // namespace lockstep::rigid
