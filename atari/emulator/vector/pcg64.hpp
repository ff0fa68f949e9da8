// NumPy's default generator, PCG64 (O'Neill 2014), and `Generator.integers` on it, as plain data.
#pragma once

#include <bit>
#include <cstdint>

namespace atari {

struct Pcg64 {
    uint64_t low, high;                      // the state, 128 bits
    uint64_t increment_low, increment_high;  // odd
    uint32_t kept;                           // the upper half of a word whose lower half has been returned
    uint32_t has_kept;

    // Words of the state and the increment, least significant first, as `PCG64(...).state` has them.
    void set(const uint32_t* words) {
        const auto pair = [&](int i) { return words[i] | uint64_t{words[i + 1]} << 32; };
        *this = {pair(0), pair(2), pair(4) | 1, pair(6), 0, 0};
    }

    uint64_t next64() {
        constexpr uint64_t kLow = 4865540595714422341u, kHigh = 2549297995355413924u;
        const uint64_t product_high = high_of_product(low, kLow) + low * kHigh + high * kLow;
        low = low * kLow + increment_low;
        high = product_high + increment_high + (low < increment_low);
        return std::rotr(high ^ low, static_cast<int>(high >> 58));
    }

    uint32_t next32() {
        if (has_kept) {
            has_kept = 0;
            return kept;
        }
        const uint64_t word = next64();
        kept = static_cast<uint32_t>(word >> 32);
        has_kept = 1;
        return static_cast<uint32_t>(word);
    }

    // Returns a uniform number in low .. high-1, as `integers(low, high)`. Draws nothing if only one number is
    // possible.
    int integers(int from, int to) {
        const auto count = static_cast<uint32_t>(to - from);
        if (count <= 1) return from;
        uint64_t product = uint64_t{next32()} * count;
        if (static_cast<uint32_t>(product) < count)
            for (const uint32_t limit = (0u - count) % count; static_cast<uint32_t>(product) < limit;)
                product = uint64_t{next32()} * count;
        return from + static_cast<int>(product >> 32);
    }

  private:
    // Multiplies in parts of 32 bits, because not every compiler has integers of 128 bits.
    static uint64_t high_of_product(uint64_t a, uint64_t b) {
        const uint64_t a_low = a & 0xffffffffu, a_high = a >> 32, b_low = b & 0xffffffffu, b_high = b >> 32;
        const uint64_t low = a_low * b_low, cross = a_high * b_low, other = a_low * b_high;
        const uint64_t middle = (low >> 32) + (cross & 0xffffffffu) + (other & 0xffffffffu);
        return a_high * b_high + (cross >> 32) + (other >> 32) + (middle >> 32);
    }
};

}  // namespace atari
