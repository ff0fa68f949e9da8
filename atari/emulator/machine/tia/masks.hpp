// Sets of the 160 pixels of a line, one bit a pixel, and the shapes of the six objects as such sets.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace atari {

enum Object { kP0, kP1, kM0, kM1, kBL, kPF };
inline constexpr unsigned kAllObjects = 0x3f;  // a bit each

// The collision latches, in pairs as the read registers show them: bit 14 - 2 * register is bit 6 of that register,
// the bit above it is bit 7.
struct Pair {
    uint8_t a, b;
    uint16_t latch;
};
inline constexpr Pair kPairs[15] = {
    {kM0, kP1, 1 << 15}, {kM0, kP0, 1 << 14}, {kM1, kP0, 1 << 13}, {kM1, kP1, 1 << 12}, {kP0, kPF, 1 << 11},
    {kP0, kBL, 1 << 10}, {kP1, kPF, 1 << 9},  {kP1, kBL, 1 << 8},  {kM0, kPF, 1 << 7},  {kM0, kBL, 1 << 6},
    {kM1, kPF, 1 << 5},  {kM1, kBL, 1 << 4},  {kBL, kPF, 1 << 3},  {kP0, kP1, 1 << 1},  {kM0, kM1, 1 << 0},
};

// By set of enabled objects, the collision latches that these objects could set.
inline constexpr auto kPairsOf = [] {
    std::array<uint16_t, 64> table{};
    for (unsigned objects = 0; objects < 64; ++objects)
        for (const Pair& pair : kPairs)
            if ((objects >> pair.a & 1) && (objects >> pair.b & 1)) table[objects] |= pair.latch;
    return table;
}();

// By set of objects, the collision latches of all pairs with one of these objects.
inline constexpr auto kPairsWith = [] {
    std::array<uint16_t, 64> table{};
    for (unsigned objects = 0; objects < 64; ++objects)
        for (const Pair& pair : kPairs)
            if ((objects >> pair.a & 1) || (objects >> pair.b & 1)) table[objects] |= pair.latch;
    return table;
}();

// By latch, its pair of objects.
inline constexpr auto kPairOf = [] {
    std::array<Pair, 16> table{};
    for (const Pair& pair : kPairs) table[static_cast<std::size_t>(std::countr_zero(pair.latch))] = pair;
    return table;
}();

inline const Pair& lowest_pair(unsigned pairs) { return kPairOf[static_cast<std::size_t>(std::countr_zero(pairs))]; }

constexpr unsigned bit_of(unsigned object) { return 1u << object; }

struct Mask {
    uint64_t word[3] = {0, 0, 0};  // pixel x is bit x % 64 of word x / 64; the last word has 32 pixels

    bool any() const { return (word[0] | word[1] | word[2]) != 0; }

    friend Mask operator&(const Mask& a, const Mask& b) {
        return {{a.word[0] & b.word[0], a.word[1] & b.word[1], a.word[2] & b.word[2]}};
    }
    friend Mask operator|(const Mask& a, const Mask& b) {
        return {{a.word[0] | b.word[0], a.word[1] | b.word[1], a.word[2] | b.word[2]}};
    }
    friend Mask without(const Mask& a, const Mask& b) {
        return {{a.word[0] & ~b.word[0], a.word[1] & ~b.word[1], a.word[2] & ~b.word[2]}};
    }
    friend bool meets(const Mask& a, const Mask& b) { return (a & b).any(); }

    // Returns the set of pixels first .. last-1.
    static constexpr Mask range(int first, int last) {
        Mask mask;
        for (int w = 0; w < 3; ++w) {
            const int low = first - 64 * w, high = last - 64 * w;
            if (high <= 0 || low >= 64) continue;
            const uint64_t from = low <= 0 ? ~0ull : ~0ull << low;
            const uint64_t to = high >= 64 ? ~0ull : ~(~0ull << high);
            mask.word[w] = from & to;
        }
        return mask;
    }

    // Adds a run of up to 64 pixels (bit 0 leftmost) at x. The run wraps from pixel 159 to pixel 0.
    void add(uint64_t run, int x) {
        const int room = 160 - x;
        if (room < 64) {
            place(run & ~(~0ull << room), x);
            place(run >> room, 0);
        } else {
            place(run, x);
        }
    }

  private:
    void place(uint64_t run, int x) {
        const int w = x / 64, shift = x % 64;
        word[w] |= run << shift;
        if (shift != 0 && w < 2) word[w + 1] |= run >> (64 - shift);
    }
};

// Returns a byte with its bits in the opposite order.
constexpr uint8_t reversed(uint8_t byte) {
    uint8_t result = 0;
    for (int bit = 0; bit < 8; ++bit)
        if (byte & (1 << bit)) result = static_cast<uint8_t>(result | (0x80 >> bit));
    return result;
}

inline constexpr auto kReversed = [] {
    std::array<uint8_t, 256> table{};
    for (int byte = 0; byte < 256; ++byte) table[static_cast<std::size_t>(byte)] = reversed(static_cast<uint8_t>(byte));
    return table;
}();

static_assert(std::endian::native == std::endian::little, "eight pixels are handled as one little-endian word");

// By byte, its bits as bytes of 0x00 or 0xff, lowest first.
inline constexpr auto kByteMasks = [] {
    std::array<uint64_t, 256> table{};
    for (uint64_t byte = 0; byte < 256; ++byte)
        for (int bit = 0; bit < 8; ++bit)
            if (byte & (1u << bit)) table[byte] |= uint64_t{0xff} << (8 * bit);
    return table;
}();

constexpr uint64_t repeated(uint8_t byte) { return byte * 0x0101010101010101ull; }

// By byte, its bits each repeated `times` times, lowest first.
template <int times>
inline constexpr auto kStretched = [] {
    std::array<uint32_t, 256> table{};
    for (int byte = 0; byte < 256; ++byte)
        for (int bit = 0; bit < 8; ++bit)
            if (byte & (1 << bit)) table[static_cast<std::size_t>(byte)] |= ((1u << times) - 1) << (bit * times);
    return table;
}();

// Offsets of a player's or missile's copies, by the low three bits of NUSIZ. Unused entries are 0.
inline constexpr struct {
    uint8_t count, offset[3];
} kCopies[8] = {{1, {0}},     {2, {0, 16}}, {2, {0, 32}},     {3, {0, 16, 32}},
                {2, {0, 64}}, {1, {0}},     {3, {0, 32, 64}}, {1, {0}}};

// Returns the pixels of `graphics`, whose leftmost pixel is bit 0. Double and quadruple width start a pixel late.
inline Mask player_mask(uint8_t graphics, int position, int mode, bool skip_first) {
    Mask mask;
    if (mode == 5 || mode == 7) {
        if (!skip_first) mask.add(mode == 5 ? kStretched<2>[graphics] : kStretched<4>[graphics], (position + 1) % 160);
        return mask;
    }
    for (int copy = skip_first ? 1 : 0; copy < kCopies[mode].count; ++copy)
        mask.add(graphics, (position + kCopies[mode].offset[copy]) % 160);
    return mask;
}

inline Mask missile_mask(int position, int mode, int size) {
    Mask mask;
    for (int copy = 0; copy < kCopies[mode].count; ++copy)
        mask.add((1u << (1 << size)) - 1, (position + kCopies[mode].offset[copy]) % 160);
    return mask;
}

inline Mask ball_mask(int position, int size) {
    Mask mask;
    mask.add((1u << (1 << size)) - 1, position);
    return mask;
}

// Returns, as a set of bits, which of the 40 cells of four pixels in a line overlap a run of `width` pixels at x. The
// run wraps from pixel 159 to pixel 0.
constexpr uint64_t cells_of_run(int x, int width) {
    const int first = x / 4, last = (x + width - 1) / 4;
    const uint64_t cells = (2ull << last) - (1ull << first);
    return (cells | cells >> 40) & 0xffffffffff;
}

constexpr uint64_t reversed_half(uint64_t cells) {
    return uint64_t{kReversed[cells & 0xff]} << 12 | uint64_t{kReversed[(cells >> 8) & 0xff]} << 4 |
           kReversed[(cells >> 16) & 0xf] >> 4;
}

// `playfield` as in `Tia`: PF0 is rendered lowest bit first, PF1 highest first, PF2 lowest first, in cells of 4 pixels.
inline uint64_t playfield_cells(uint32_t playfield, bool reflect) {
    const uint64_t left = (playfield & 0xff00f) | uint64_t{kReversed[(playfield >> 4) & 0xff]} << 4;
    return left | (reflect ? reversed_half(left) : left) << 20;
}

// Returns the playfield bits that light any of these cells.
constexpr uint32_t playfield_of_cells(uint64_t cells, bool reflect) {
    const uint64_t right = cells >> 20, left = (cells & 0xfffff) | (reflect ? reversed_half(right) : right);
    return static_cast<uint32_t>((left & 0xff00f) | uint64_t{kReversed[(left >> 4) & 0xff]} << 4);
}

inline Mask playfield_mask(uint32_t playfield, bool reflect) {
    const uint64_t cells = playfield_cells(playfield, reflect);
    const auto stretched = [&](int byte) { return uint64_t{kStretched<4>[(cells >> (8 * byte)) & 0xff]}; };
    return {{stretched(0) | stretched(1) << 32, stretched(2) | stretched(3) << 32, stretched(4)}};
}

}  // namespace atari
