// Work that does not fit the machine's memory is refused before it starts: Linux would grant the allocation and kill
// the process later.
#pragma once

#include <string>

namespace lockstep {

// Bytes this process may still allocate: what the machine has available, or what is left of this process's limit on
// address space (ulimit -v) or of limit_memory where that is less. Infinite where the system does not say.
double available_memory();

// Caps what available_memory() reports from now on, so that tests and the fuzzer refuse the same work on all machines.
void limit_memory(double bytes);

// Throws InputError unless `bytes` fit in available_memory(). `what` opens the message: who needs them.
void require_memory(double bytes, const std::string& what);

}  // namespace lockstep
