// When corners above a plane stand above the same place, or in line, for all that rounding lets one tell.
#pragma once

namespace lockstep::rigid {

// Square of the sine of the angle below which a corner stands straight above another. The square of their distance along the plane is a
// difference, good to some 1e-6 of the square of their distance.
inline constexpr float overhead = 1e-5f;

// A corner is in line with two others where it is nearer to their line than this times their distance along the plane.
inline constexpr float in_line = 1e-5f;

}  // namespace lockstep::rigid
