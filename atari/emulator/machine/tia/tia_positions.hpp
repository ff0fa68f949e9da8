// Positions of the TIA's objects after they are moved, strobed or released. Both cores share this.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "masks.hpp"
#include "machine/raster.hpp"
#include "tia_registers.hpp"

namespace atari {

// Returns the pixels by which HMOVE moves an object, by the write's cycle in the line and the object's motion nibble.
constexpr int motion(int cycle, int nibble) {
    constexpr int8_t kFloor[17] = {-6, -5, -5, -4, -3, -2, -2, -1, 0, 1, 1, 2, 3, 4, 4, 5, 6};
    constexpr int8_t kOffset[20] = {6, 5, 4, 4, 3, 2, 1, 1, 0, -1, -2, -2, -3, -4, -5, -5, -6, -7, -8, -8};
    const int normal = nibble < 8 ? -nibble : 16 - nibble;
    if (is_ordinary_hmove(static_cast<uint32_t>(cycle))) return normal;
    if (cycle <= 20) return std::max(normal, static_cast<int>(kFloor[cycle - 4]));
    if (cycle <= 54) return 0;
    return std::min(0, normal + kOffset[cycle - 55]);
}

// The values of `motion` as a table.
inline constexpr auto kMotion = [] {
    std::array<std::array<int8_t, 16>, kCyclesPerLine> table{};
    for (int cycle = 0; cycle < kCyclesPerLine; ++cycle)
        for (int nibble = 0; nibble < 16; ++nibble)
            table[static_cast<std::size_t>(cycle)][static_cast<std::size_t>(nibble)] =
                static_cast<int8_t>(motion(cycle, nibble));
    return table;
}();

inline uint8_t wrapped(int position) {
    return static_cast<uint8_t>((position % kScreenWidth + kScreenWidth) % kScreenWidth);
}

// The effect of a strobe of a player's position. The first copy is hidden for this line, unless the old copy was just
// about to start. A copy that is being rendered continues for eleven clocks.
struct PlayerStrobe {
    bool hidden, goes_on;
};

// By the low three bits of NUSIZ, and the distance from the old position to the new one, to the right.
inline constexpr auto kPlayerStrobes = [] {
    std::array<std::array<PlayerStrobe, kScreenWidth>, 8> table{};
    for (std::size_t mode = 0; mode < 8; ++mode) {
        const int width = mode == 5 ? 16 : mode == 7 ? 32 : 8;
        for (int distance = 0; distance < kScreenWidth; ++distance) {
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

inline uint8_t strobe_player(int hpos) {
    return hpos < kHblankClocks ? 3 : static_cast<uint8_t>((hpos - kHblankClocks + 5) % kScreenWidth);
}

inline PlayerStrobe player_strobe(int position, int old_position, int mode) {
    const int distance = position - old_position + (position < old_position ? kScreenWidth : 0);
    return kPlayerStrobes[static_cast<std::size_t>(mode)][static_cast<std::size_t>(distance)];
}

// Returns the position of a missile or the ball after a strobe. At some cycles after HMOVE it is a special case.
inline uint8_t strobe_missile(int missile, int hpos, uint32_t since_hmove) {
    if (missile == 0 && since_hmove == 60 && hpos == 69) return 8;
    if (missile == 1 && since_hmove == 9 && hpos == 18) return 3;
    return hpos < kHblankClocks ? 2 : static_cast<uint8_t>((hpos - kHblankClocks + 4) % kScreenWidth);
}
inline uint8_t strobe_ball(int hpos, uint32_t since_hmove) {
    if (since_hmove == 54 && (hpos == 60 || hpos == 69)) return 10;
    if (since_hmove == 9 && hpos == 18) return 3;
    if (since_hmove == 21 && hpos == 30) return 6;
    if (since_hmove == 18 && hpos == 27) return 5;
    return hpos < kHblankClocks ? 2 : static_cast<uint8_t>((hpos - kHblankClocks + 4) % kScreenWidth);
}

// Returns the position of a missile that is released from its player: the player's middle.
inline uint8_t released_missile(int player_position, int mode) {
    return wrapped(player_position + (mode == 5 ? 8 : mode == 7 ? 16 : 4));
}

}  // namespace atari
