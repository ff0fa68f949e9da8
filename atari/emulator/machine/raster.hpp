// The raster and its time: scan lines, pixels, cycles of the processor and clocks of the TIA, three a cycle.
#pragma once

#include <cstdint>

namespace atari {

inline constexpr int kScreenWidth = 160;
inline constexpr int kCyclesPerLine = 76;
inline constexpr int kClocksPerLine = 3 * kCyclesPerLine;
inline constexpr int kHblankClocks = kClocksPerLine - kScreenWidth;  // at the start of a line
inline constexpr int kHmoveBlank = 8;                                // pixels that HMOVE makes black
inline constexpr int kFrameRows = 300;
inline constexpr int kFrameBytes = kScreenWidth * kFrameRows;
// A TIA write after this line ends the frame.
constexpr int last_line(bool pal) { return pal ? 342 : 290; }
inline constexpr int kMostLines = last_line(true) + 2;

// Clocks are 32 bits and wrap, as in the reference: a program that never ends a frame gets there.
inline int32_t clock_at(uint32_t cycles, uint32_t later = 0) { return static_cast<int32_t>(3 * cycles + later); }
inline uint32_t clocks_since(int32_t stamp, uint32_t cycles) { return 3 * cycles - static_cast<uint32_t>(stamp); }

// Moves a time stamp, after the count that it belongs to has been reduced by as much.
inline void rebase_stamp(int32_t& stamp, uint32_t by) {
    stamp = static_cast<int32_t>(static_cast<uint32_t>(stamp) - by);
}

}  // namespace atari
