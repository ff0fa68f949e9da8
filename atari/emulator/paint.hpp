// Colours into pictures: a span of a line from the sets of its pixels, and pictures of palette indices as RGB or gray.
#pragma once

#include <cstdint>
#include <vector>

#include "masks.hpp"
#include "palettes.hpp"
#include "simd.hpp"

namespace atari {

// Which pixels of a line take the colour of player 0, of player 1 and of the playfield; the rest is background.
struct Layers {
    Mask player0, player1, playfield;  // at most one of them has a pixel
};

// Paints pixels first .. last-1 of a row of 160. `colours` are those of player 0, player 1, playfield and background.
using Painter = void (*)(uint8_t* row, const Layers& layers, const uint8_t colours[4], int first, int last);
void paint_plain(uint8_t* row, const Layers& layers, const uint8_t colours[4], int first, int last);

// The fastest way of this processor.
Painter best_painter();

// The ways of this processor, the portable one first, for tests.
std::vector<Painter> painters();

// A picture of palette indices, rows x 160, as red, green and blue bytes, or as luminance.
void to_rgb(const uint8_t* picture, int rows, const Palette& palette, uint8_t* out, Way way = best_way());
void to_gray(const uint8_t* picture, int rows, const Palette& palette, uint8_t* out);

}  // namespace atari
