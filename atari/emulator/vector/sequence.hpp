// `Sequence`: the steps that lanes play in one call, each with its own actions, and what their results add to a batch.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace atari {

struct Sequence {
    size_t steps = 1;
    double discount = 1.0;  // the factor of a step's reward, from one step to the next
    bool stops = true;      // whether a lane stops when its episode ends
    bool every = false;  // whether the batch has a row for each step; lane i has rows i * steps .. (i + 1) * steps - 1

    std::vector<int> actions;      // (lanes that play, steps, players), ALE numbers
    std::vector<float> strengths;  // (lanes that play, steps)

    // The results, of all lanes.
    std::vector<double> rewards;  // (lanes, players), the discounted sums
    std::vector<int32_t> played;  // (lanes), steps
    std::vector<uint8_t> rams;    // (lanes, 128), with `every` (lanes, steps, 128)

    size_t rows() const { return every ? steps : 1; }  // of a lane in the batch
};

}  // namespace atari
