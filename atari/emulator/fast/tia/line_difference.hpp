// Comparison of frames line by line: the difference between a line's beginning and its beginning in the previous frame,
// for state that does not affect the line itself.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "machine/state.hpp"
#include "write_log.hpp"

namespace atari {

// Returns whether bytes agree. There is no branch for each word, so that the compiler vectorizes the loop.
template <std::size_t size>
bool agree(const void* a, const void* b) {
    static_assert(size >= 8);
    const auto differences = [&](std::size_t at) {
        uint64_t x, y;
        std::memcpy(&x, static_cast<const char*>(a) + at, sizeof x);
        std::memcpy(&y, static_cast<const char*>(b) + at, sizeof y);
        return x ^ y;
    };
    uint64_t any = differences(size - 8);
    for (std::size_t at = 0; at + 8 < size; at += 8) any |= differences(at);
    return any == 0;
}

// Returns how many of the first `count` TIA writes agree.
int agreeing(const TiaWrite* a, const TiaWrite* b, int count);

// In a set of objects: the first of the bits of the four colours.
inline constexpr int kColourBits = 8;

// The difference between two beginnings of a line, in the fields that may differ.
struct Difference {
    unsigned objects;  // objects and colours that differ, a bit each, and kPlacing
    // byte by byte as in TiaPlaces: the distance to subtract from each position, modulo the line's width
    uint64_t positions;
    uint64_t flags;  // bits that change in the bytes after the positions
    int32_t last_hmove;
    uint32_t colours;  // bits that change in TiaCommon::colour
};

Difference difference(const TiaPlaces& now, const TiaPlaces& before);

// Returns the bits in which colours differ; `colours_in` returns the set of colours for such bits.
inline uint32_t colour_changes(const TiaCommon& now, const TiaCommon& before) {
    uint32_t x, y;
    std::memcpy(&x, now.colour, sizeof x);
    std::memcpy(&y, before.colour, sizeof y);
    return x ^ y;
}
unsigned colours_in(uint32_t changes);

inline bool agree_but_for_colours(const TiaCommon& a, const TiaCommon& b) {
    constexpr std::size_t kColours = offsetof(TiaCommon, colour), kAfter = kColours + sizeof a.colour;
    const auto after = [](const TiaCommon& line) { return reinterpret_cast<const char*>(&line) + kAfter; };
    return agree<kColours>(&a, &b) && agree<sizeof a - kAfter>(after(a), after(b));
}

// Applies a difference to the beginnings of lines. Objects that take no part have moved as in the previous frame.
void carry(const Difference& by, TiaPlaces* first, TiaPlaces* last);
void carry_colours(uint32_t changes, TiaCommon* first, TiaCommon* last);

}  // namespace atari
