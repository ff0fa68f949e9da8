// The log of a frame's writes to the TIA, and what they do, as far as the beam (beam.cpp) and the collider
// (collider.cpp) agree on it.
#pragma once

#include <cstdint>
#include <initializer_list>

#include "state.hpp"
#include "tia_registers.hpp"

namespace atari {

// A write to a register of the TIA, at the end of a CPU cycle. Motion registers are not kept: HMOVE brings what they hold
// along.
struct Write {
    uint32_t cycle;
    uint8_t reg;
    uint8_t value;    // under HMOVE: the motion of the ball
    uint16_t beside;  // under HMOVE: of the others, a nibble each, player 0 lowest. Under GRP0 and GRP1: what the delayed
                      // copy of the other player's graphics becomes; under GRP1 bit 8 is what that of ENABL becomes
};

// Registers, as a set of bits.
constexpr uint64_t set_of(std::initializer_list<uint8_t> registers) {
    uint64_t set = 0;
    for (const uint8_t reg : registers) set |= 1ull << reg;
    return set;
}

inline constexpr uint64_t kPlayfieldRegisters = set_of({PF0, PF1, PF2});
// What objects look like, not where they are.
inline constexpr uint64_t kLooks = kPlayfieldRegisters | set_of({GRP0, GRP1, REFP0, REFP1, ENAM0, ENAM1, ENABL});
// Later writes build on what others do, so these act in any case.
inline constexpr uint64_t kAlwaysActing = ~(kLooks | set_of({COLUP0, COLUP1, COLUPF, COLUBK, STILL, PRIORITY}));

// Before this cycle of a line a write to CTRLPF mirrors the playfield at once; later on the line's end does.
inline constexpr uint32_t kMirrorsAtOnce = 49;

// The clock at which a write shows.
inline int32_t shown_at(const Write& write, uint32_t first_cycle) {
    return static_cast<int32_t>(3 * write.cycle + kDelays[write.reg][(write.cycle - first_cycle) & 3]);
}

// The playfield after a write to PF0, PF1 or PF2.
constexpr uint32_t with_playfield(uint32_t playfield, unsigned reg, uint8_t value) {
    switch (reg) {
        case PF0: return (playfield & ~0xfu) | value >> 4;
        case PF1: return (playfield & ~0xff0u) | uint32_t{value} << 4;
        default: return (playfield & ~0xff000u) | uint32_t{value} << 12;
    }
}

constexpr uint8_t moved_by(int position, int distance) {
    position += distance;
    return static_cast<uint8_t>(position < 0 ? position + 160 : position >= 160 ? position - 160 : position);
}

inline uint8_t colour_of(uint8_t value, bool pal, const Tia& tia) {
    return static_cast<uint8_t>((value & 0xfe) | (pal ? tia.last_line_count & 1 : 0));
}

// The end of the line in which the beam is. Exactly at an end it is this end: what a line's end does happens only when
// the beam goes strictly past it.
inline int32_t line_end(const Tia& tia) {
    const int32_t drawn = tia.drawn_to - tia.draw_start;
    return drawn == 0 ? tia.draw_start + 228 : tia.draw_start + (drawn + 227) / 228 * 228;
}

// What the end of a line does to missile 0 while the Cosmic Ark effect lasts.
inline void step_cosmic_ark(Tia& tia) {
    static constexpr uint8_t kStep[4] = {18, 33, 0, 17};
    tia.ark_counter = (tia.ark_counter + 1) & 3;
    tia.pos[kM0] = moved_by(tia.pos[kM0], -kStep[tia.ark_counter]);
    tia.m0_variant = tia.ark_counter == 1 ? kWide : tia.ark_counter == 2 ? kOff : kPlain;
}

}  // namespace atari
