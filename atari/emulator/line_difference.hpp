// Comparing frames line by line: by how much the beginning of a line, or of several, differs from what it was in the
// frame before, where that makes no difference to the line itself.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "state.hpp"
#include "write_log.hpp"

namespace atari {

// Among objects: a missile or the ball is placed, which may depend on when HMOVE was.
inline constexpr unsigned kPlacing = 1u << 6;

// Whether bytes agree, without a branch for each word: the compiler makes vectors of this.
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

// How many writes agree, of `count`.
int agreeing(const Write* a, const Write* b, int count);

// By how much a line's beginning differs in what may differ.
struct Difference {
    unsigned objects;    // a bit each, and kPlacing
    uint64_t positions;  // by bytes as in TiaPlaces: what goes off each, and comes back where it would be less than 0
    uint64_t flags;      // what changes in the bytes behind them
    int32_t last_hmove;
};

Difference difference(const TiaPlaces& now, const TiaPlaces& before);

// Makes these beginnings of lines those of a frame that differs so. Objects that take no part have been moved as before.
void carry(const Difference& by, TiaPlaces* first, TiaPlaces* last);

}  // namespace atari
