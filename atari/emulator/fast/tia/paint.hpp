// Paints a span of a line from the sets of pixels of each colour.
#pragma once

#include <cstdint>
#include <vector>

#include "machine/tia/masks.hpp"
#include "fast/simd.hpp"

namespace atari {

// The pixels of a line that have the colour of player 0, of player 1 and of the playfield. The rest is background.
struct Layers {
    Mask player0, player1, playfield;  // disjoint sets
};

// Paints pixels first .. last-1 of a row of 160. `colours` are those of player 0, player 1, playfield and background.
using Painter = void (*)(uint8_t* row, const Layers& layers, const uint8_t colours[4], int first, int last);
void paint_scalar(uint8_t* row, const Layers& layers, const uint8_t colours[4], int first, int last);

// The painter of the SIMD level that is used.
Painter chosen_painter();

// The painters of the SIMD levels that this processor supports, by level; for tests.
std::vector<Painter> painters();

}  // namespace atari
