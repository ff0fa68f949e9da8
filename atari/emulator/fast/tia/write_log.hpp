// The write log of a frame, and the effects of TIA writes that the renderer (deferred_renderer.cpp) and the collider
// (collider.cpp) share.
#pragma once

#include <array>
#include <cstdint>

#include "machine/state.hpp"
#include "machine/tia/tia_registers.hpp"

namespace atari {

// A TIA write, at the end of a CPU cycle. Writes to motion registers have no entry: the entry of HMOVE holds their
// values.
struct TiaWrite {
    uint32_t cycle;
    uint8_t reg;
    uint8_t value;  // under HMOVE: the motion of the ball
    // Under HMOVE: the motions of the other objects, a nibble each, player 0 lowest. Under GRP0 and GRP1: the new
    // delayed copy of the other player's graphics. Under GRP1, bit 8 is the new delayed copy of ENABL.
    uint16_t beside;
};

// By register, the set of it alone. Loading a set takes fewer instructions than shifting a bit.
inline constexpr auto kSetOf = [] {
    std::array<uint64_t, 64> sets{};
    for (unsigned reg = 0; reg < 64; ++reg) sets[reg] = 1ull << reg;
    return sets;
}();
inline constexpr uint64_t kPlayfieldRegisters = set_of({PF0, PF1, PF2});
// Registers of the objects' looks, not of their positions.
inline constexpr uint64_t kLooks =
    registers_where([](const TiaRegister& reg) { return reg.collides == Collides::kByLook; });
// Writes to these registers always act, because later writes depend on their effects.
inline constexpr uint64_t kAlwaysActing =
    registers_where([](const TiaRegister& reg) { return reg.collides == Collides::kAlways; });

// Returns the clock at which a TIA write shows.
inline int32_t shown_at(const TiaWrite& write, uint32_t first_cycle) {
    return static_cast<int32_t>(3 * write.cycle + kTiaRegisters[write.reg].delay[(write.cycle - first_cycle) & 3]);
}

// Returns the playfield after a write to PF0, PF1 or PF2.
constexpr uint32_t with_playfield(uint32_t playfield, unsigned reg, uint8_t value) {
    switch (reg) {
        case PF0: return (playfield & ~0xfu) | value >> 4;
        case PF1: return (playfield & ~0xff0u) | uint32_t{value} << 4;
        default: return (playfield & ~0xff000u) | uint32_t{value} << 12;
    }
}

constexpr uint8_t moved_by(int position, int distance) {
    position += distance;
    if (position < 0) position += kScreenWidth;
    else if (position >= kScreenWidth) position -= kScreenWidth;
    return static_cast<uint8_t>(position);
}

inline uint8_t colour_of(uint8_t value, bool pal, const Tia& tia) {
    return static_cast<uint8_t>((value & bits_of(COLUP0)) | (pal ? tia.last_line_count & 1 : 0));
}

// Returns the end of the beam's line. If the beam is exactly at an end, that end is returned: the effects of a line's
// end happen only when the beam goes strictly past it.
inline int32_t line_end(const Tia& tia) {
    const int32_t drawn = tia.drawn_to - tia.draw_start;
    const int32_t lines = drawn == 0 ? 1 : (drawn + kClocksPerLine - 1) / kClocksPerLine;
    return tia.draw_start + kClocksPerLine * lines;
}

// The effect of a line's end on missile 0 while the Cosmic Ark effect is active.
inline void step_cosmic_ark(Tia& tia) {
    static constexpr uint8_t kStep[4] = {18, 33, 0, 17};
    tia.ark_counter = (tia.ark_counter + 1) & 3;
    tia.pos[kM0] = moved_by(tia.pos[kM0], -kStep[tia.ark_counter]);
    tia.m0_variant = tia.ark_counter == 1 ? kWide : tia.ark_counter == 2 ? kOff : kPlain;
}

}  // namespace atari
