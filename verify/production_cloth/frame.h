// A frame of the production cloth by module, for a figure (verify/figures.cpp).
#pragma once

#include <functional>
#include <nlohmann/json.hpp>

namespace lockstep::verify {

using FrameRow = nlohmann::ordered_json;

// Calls add(fields that name a row, measure) for a frame in which the ball pushes the curtain: serially, and by openmp
// on 1, 2, 4 ... threads. measure() runs the frame and returns its other fields: how large it is, what it took, and the
// milliseconds of each module.
void rows_of_cloth_frame(const std::function<void(FrameRow fields, const std::function<FrameRow()>& measure)>& add);

}  // namespace lockstep::verify
