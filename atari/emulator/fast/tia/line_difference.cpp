#include "line_difference.hpp"

#include <bit>

namespace atari {

int agreeing(const TiaWrite* a, const TiaWrite* b, int count) {
    int i = 0;
    while (i <= count - 8 && agree<8 * sizeof(TiaWrite)>(a + i, b + i)) i += 8;
    while (i < count && agree<sizeof(TiaWrite)>(a + i, b + i)) ++i;
    return i;
}

namespace {

// The first eight bytes of TiaPlaces are handled as one word: five positions, then flags.
static_assert(std::endian::native == std::endian::little && offsetof(TiaPlaces, last_hmove) == 8);
constexpr uint64_t kPositions = 0xffffffffff, kOnes = 0x0101010101010101, kHigh = 0x80 * kOnes;

uint64_t word_of(const TiaPlaces& places) {
    uint64_t word;
    std::memcpy(&word, &places, sizeof word);
    return word;
}

// Subtracts positions bytewise, modulo the line's width: a result below 0 wraps to the right end.
constexpr uint64_t back(uint64_t positions, uint64_t by) {
    const uint64_t less = ((positions | kHigh) - (by & ~kHigh)) ^ ((positions ^ ~by) & kHigh);
    const uint64_t borrows = ((~positions & by) | (~(positions ^ by) & less)) & kHigh;
    return less - (borrows >> 7) * (256 - kScreenWidth);
}

// Returns a bit set: bit i is set if byte i is not 0.
constexpr unsigned bytes_set(uint64_t word) {
    const uint64_t set = (word | ((word & ~kHigh) + ~kHigh)) & kHigh;
    return static_cast<unsigned>((set >> 7) * 0x0102040810204080 >> 56);
}
static_assert(bytes_set(0x80000000000100ff) == 0b10000101 && bytes_set(0x0001007f00) == 0b01010);

}  // namespace

Difference difference(const TiaPlaces& now, const TiaPlaces& before) {
    if (agree<sizeof now>(&now, &before)) return {};
    const uint64_t new_word = word_of(now), old_word = word_of(before);
    Difference d{0, back(old_word & kPositions, new_word & kPositions), (old_word ^ new_word) & ~kPositions,
                 now.last_hmove, 0};
    const unsigned positions = bytes_set(d.positions), flags = bytes_set(d.flags) >> 5;
    d.objects = positions | (flags & 3) << kP0 | flags >> 2 << kBL;
    if (before.last_hmove != now.last_hmove) d.objects |= kPlacing;
    return d;
}

unsigned colours_in(uint32_t changes) { return bytes_set(changes) << kColourBits; }

void carry(const Difference& by, TiaPlaces* first, TiaPlaces* last) {
    const unsigned positions = bytes_set(by.positions);
    if (by.flags || (positions & (positions - 1))) {
        for (TiaPlaces* line = first; line < last; ++line) {
            const uint64_t word = back(word_of(*line), by.positions) ^ by.flags;
            std::memcpy(line, &word, sizeof word);
        }
    } else if (positions) {  // The most frequent case takes less time by bytes.
        const int object = std::countr_zero(positions), distance = static_cast<uint8_t>(by.positions >> 8 * object);
        for (TiaPlaces* line = first; line < last; ++line) {
            const int position = line->pos[object] - distance;
            line->pos[object] = static_cast<uint8_t>(position < 0 ? position + kScreenWidth : position);
        }
    }
    if (by.objects & kPlacing)
        for (TiaPlaces* line = first; line < last; ++line) line->last_hmove = by.last_hmove;
}

void carry_colours(uint32_t changes, TiaCommon* first, TiaCommon* last) {
    for (TiaCommon* line = first; line < last; ++line)
        for (int i = 0; i < 4; ++i) line->colour[i] ^= static_cast<uint8_t>(changes >> (8 * i));
}

}  // namespace atari
