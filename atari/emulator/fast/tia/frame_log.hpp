// `FrameLog`: the write log of one frame, with the TIA's state at its beginning. Rendering the frame needs nothing
// else.
#pragma once

#include <cstdint>

#include "machine/state.hpp"
#include "write_log.hpp"

namespace atari {

// A frame ends with its first TIA write after `last_line`. BRK writes three bytes in 7 cycles, the highest rate, and
// two of them take a second entry, SAME_TIME. A log therefore needs no more entries than this.
inline constexpr int kLogSize = kMostLines * kCyclesPerLine * 5 / 7 + 16;

// The operating system backs only the pages that have been written. The alignment keeps two logs on separate pages.
struct alignas(4096) FrameLog {
    Tia start;
    int32_t reached;  // clock of the frame's end
    int size;         // number of entries, valid once the frame has ended
    int replaced;     // pixels, from the first on, that the frame replaces
    TiaWrite writes[kLogSize];
};

}  // namespace atari
