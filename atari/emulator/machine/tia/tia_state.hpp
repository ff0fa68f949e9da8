// The state of the TIA, without sound (sound.hpp).
#pragma once

#include <cstdint>

#include "machine/flag.hpp"
#include "machine/raster.hpp"

namespace atari {

inline constexpr int32_t kVsyncIdle = 0x7fffffff;

enum MissileVariant : uint8_t { kPlain, kWide, kOff };  // the shape of missile 0 in the Cosmic Ark effect

// The state at the start of a line that, with the writes in the line, determines its look. Clocks are three a CPU
// cycle.
struct TiaCommon {
    int32_t drawn_to;    // the framebuffer is complete up to this clock
    int32_t pending;     // the present state is valid up to this clock
    uint32_t playfield;  // 20 bits: PF0 high nibble, PF1, PF2
    uint8_t vblank, ctrlpf;
    uint8_t nusiz[2], colour[4];  // colour: P0, P1, PF, BK
    uint8_t grp[2], old_grp[2];
    Flag vdelp[2], enam[2], resmp[2];
    Flag enabl, old_enabl;
    Flag skip_first[2];  // a player's first copy is hidden until the end of the line
    Flag pf_reflect;     // the latched bit, not that of CTRLPF
    MissileVariant m0_variant;
    Flag hmove_blank, cosmic_ark;
    uint8_t ark_counter;
    uint8_t unused;  // always 0, because states are compared byte by byte
};

// Positions, which determine a line's look if their object is visible or is placed in it; see line_cache.hpp.
struct TiaPlaces {
    uint8_t pos[5];  // P0, P1, M0, M1, BL
    Flag refp[2], vdelbl;
    int32_t last_hmove;
};

struct TiaLine : TiaCommon, TiaPlaces {};

struct Tia : TiaLine {
    // frame_start is where line 0 of the current frame begins, 0 or a little before.
    int32_t frame_start, draw_start, draw_stop;
    int32_t to_line_end;  // clocks from drawn_to to the end of its line
    int32_t write_pos;    // next pixel in the current framebuffer
    int32_t vsync_done;   // from this clock on, clearing VSYNC ends the frame
    int32_t dump_off_cycle;
    int32_t last_line_count, current_line;
    uint16_t collisions;  // 15 latches, see collision_bit
    uint8_t hm[5];
    Flag dump_on;
    Flag partial;  // the frame has not ended: the next update continues it
    Flag greyed;
    uint8_t current;  // index of the framebuffer that is being rendered into

    // Returns the number of scan lines since the frame began, and the clocks since the present line began.
    int lines(uint32_t cycles) const { return static_cast<int>(clocks_since(frame_start, cycles) / kClocksPerLine); }
    int line_clock(uint32_t cycles) const {
        return static_cast<int>(clocks_since(frame_start, cycles) % kClocksPerLine);
    }
};

}  // namespace atari
