// The names of the TIA's registers, and the timing of writes to them.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "masks.hpp"

namespace atari {

enum Register : uint8_t {
    VSYNC = 0x00, VBLANK, WSYNC, RSYNC, NUSIZ0, NUSIZ1, COLUP0, COLUP1, COLUPF, COLUBK, CTRLPF, REFP0, REFP1,
    PF0, PF1, PF2, RESP0, RESP1, RESM0, RESM1, RESBL, AUDC0, AUDC1, AUDF0, AUDF1, AUDV0, AUDV1,
    GRP0, GRP1, ENAM0, ENAM1, ENABL, HMP0, HMP1, HMM0, HMM1, HMBL, VDELP0, VDELP1, VDELBL, RESMP0, RESMP1,
    HMOVE, HMCLR, CXCLR,
    // Only in logs of writes (write_log.hpp):
    SAME_TIME,  // the next write comes at the same time as the one before
    PRIORITY,   // CTRLPF, but neither the mirroring nor the ball's size changes
    STILL       // HMOVE, at its ordinary place and without a motion
};

// After how many clocks a write shows in the picture.
constexpr uint32_t write_delay(uint8_t reg, uint32_t cycle_in_line) {
    constexpr uint8_t kPlayfield[4] = {4, 5, 2, 3};
    switch (reg) {
        case VBLANK: case REFP0: case REFP1: case GRP0: case GRP1: return 1;
        case NUSIZ0: case NUSIZ1: case RESM0: case RESM1: return 8;
        case PF0: case PF1: case PF2: return kPlayfield[cycle_in_line & 3];
        default: return 0;
    }
}

// The same by the two low bits of the cycle, in a table.
inline constexpr auto kDelays = [] {
    std::array<std::array<uint8_t, 4>, 64> table{};
    for (uint8_t reg = 0; reg < 64; ++reg)
        for (uint32_t cycle = 0; cycle < 4; ++cycle) table[reg][cycle] = static_cast<uint8_t>(write_delay(reg, cycle));
    return table;
}();

// How far HMOVE moves an object, by the cycle of the line it is written in and the object's motion nibble.
constexpr int motion(int cycle, int nibble) {
    constexpr int8_t kFloor[17] = {-6, -5, -5, -4, -3, -2, -2, -1, 0, 1, 1, 2, 3, 4, 4, 5, 6};
    constexpr int8_t kOffset[20] = {6, 5, 4, 4, 3, 2, 1, 1, 0, -1, -2, -2, -3, -4, -5, -5, -6, -7, -8, -8};
    const int normal = nibble < 8 ? -nibble : 16 - nibble;
    if (cycle <= 3 || cycle == 75) return normal;
    if (cycle <= 20) return std::max(normal, static_cast<int>(kFloor[cycle - 4]));
    if (cycle <= 54) return 0;
    return std::min(0, normal + kOffset[cycle - 55]);
}

// The same in a table.
inline constexpr auto kMotion = [] {
    std::array<std::array<int8_t, 16>, 76> table{};
    for (int cycle = 0; cycle < 76; ++cycle)
        for (int nibble = 0; nibble < 16; ++nibble)
            table[static_cast<std::size_t>(cycle)][static_cast<std::size_t>(nibble)] =
                static_cast<int8_t>(motion(cycle, nibble));
    return table;
}();

inline uint8_t wrapped(int position) { return static_cast<uint8_t>((position % 160 + 160) % 160); }

// What strobing a player's position does: its first copy is hidden for this line unless the old one was just about to
// start, and a copy that is being shown goes on for eleven clocks.
struct PlayerStrobe {
    bool hidden, goes_on;
};

// By the low three bits of NUSIZ, and by how far the new position is behind the old one.
inline constexpr auto kPlayerStrobes = [] {
    std::array<std::array<PlayerStrobe, 160>, 8> table{};
    for (std::size_t mode = 0; mode < 8; ++mode) {
        const int width = mode == 5 ? 16 : mode == 7 ? 32 : 8;
        for (int distance = 0; distance < 160; ++distance) {
            bool about_to_start = false, showing = false;
            for (int copy = 0; copy < kCopies[mode].count; ++copy) {
                const int d = distance - kCopies[mode].offset[copy];
                about_to_start |= d >= 0 && d < 4;
                showing |= d >= 4 && d < 4 + width;
            }
            table[mode][static_cast<std::size_t>(distance)] = {!about_to_start, showing && !about_to_start};
        }
    }
    return table;
}();

inline uint8_t strobe_player(int hpos) { return hpos < 68 ? 3 : static_cast<uint8_t>((hpos - 68 + 5) % 160); }

inline PlayerStrobe player_strobe(int position, int old_position, int mode) {
    const int distance = position - old_position;
    return kPlayerStrobes[static_cast<std::size_t>(mode)][static_cast<std::size_t>(distance < 0 ? distance + 160 : distance)];
}

// Where a strobe puts a missile or the ball; a few moments behind HMOVE are special.
inline uint8_t strobe_missile(int missile, int hpos, uint32_t since_hmove) {
    if (missile == 0 && since_hmove == 60 && hpos == 69) return 8;
    if (missile == 1 && since_hmove == 9 && hpos == 18) return 3;
    return hpos < 68 ? 2 : static_cast<uint8_t>((hpos - 68 + 4) % 160);
}
inline uint8_t strobe_ball(int hpos, uint32_t since_hmove) {
    if (since_hmove == 54 && (hpos == 60 || hpos == 69)) return 10;
    if (since_hmove == 9 && hpos == 18) return 3;
    if (since_hmove == 21 && hpos == 30) return 6;
    if (since_hmove == 18 && hpos == 27) return 5;
    return hpos < 68 ? 2 : static_cast<uint8_t>((hpos - 68 + 4) % 160);
}

// A missile that was locked to its player appears at the player's middle.
inline uint8_t released_missile(int player_position, int mode) {
    return wrapped(player_position + (mode == 5 ? 8 : mode == 7 ? 16 : 4));
}

}  // namespace atari
