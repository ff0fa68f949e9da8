// The axis and the distance of a movement between two screens.
#pragma once

#include <cstdint>
#include <vector>

namespace atari {

// The pixels that differ between two screens of 160 columns.
struct ScreenDifference {
    std::vector<int> places;                           // row by row
    int left = 160, top = 0, right = -1, bottom = -1;  // their box, inclusive
};

struct Shift {
    int distance = 0, score = 0;  // `score`: percentage of the differing pixels that the shift explains
};

// Returns the shift along x or y that best maps the old screen to the new one, if it explains at least 80 % of the
// differing pixels. Among equally good shifts it is the shortest.
Shift find_shift(const ScreenDifference& difference, const uint8_t* old_screen, const uint8_t* new_screen, bool along_x,
                 int height);

// Returns the percentage of differing pixels whose colour on one screen has no counterpart on the other. If something
// moves over a background of its own, the same colours appear on both.
int unbalanced(const ScreenDifference& difference, const uint8_t* old_screen, const uint8_t* new_screen);

}  // namespace atari
