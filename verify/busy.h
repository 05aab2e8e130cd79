// What other programs take of the machine's cores.
#pragma once

namespace lockstep::verify {

// How many cores' time is in use while this program sleeps for a tenth of a second. If it is half a core or more, says
// on stderr in one line that times will be disturbed. 0 where the system does not tell (/proc/stat).
double busy_cores();

}  // namespace lockstep::verify
