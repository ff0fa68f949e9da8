// The Mersenne Twister MT19937 (Matsumoto and Nishimura 1998) with the single-integer seeding, trivially copyable.
#pragma once

#include <cstdint>

namespace atari {

struct MersenneTwister {
    uint32_t words[624];
    uint32_t position;

    void seed(uint32_t value) {
        words[0] = value;
        for (uint32_t i = 1; i < 624; ++i) words[i] = 1812433253u * (words[i - 1] ^ (words[i - 1] >> 30)) + i;
        position = 624;
    }

    uint32_t next() {
        if (position >= 624) refill();
        uint32_t y = words[position++];
        y ^= y >> 11;
        y ^= (y << 7) & 0x9d2c5680u;
        y ^= (y << 15) & 0xefc60000u;
        return y ^ (y >> 18);
    }

    // Returns a uniform number in 0 .. count-1, without bias (Lemire 2019).
    uint32_t below(uint32_t count) {
        uint64_t product = uint64_t{next()} * count;
        if (static_cast<uint32_t>(product) < count)
            for (const uint32_t limit = (0u - count) % count; static_cast<uint32_t>(product) < limit;)
                product = uint64_t{next()} * count;
        return static_cast<uint32_t>(product >> 32);
    }

    // Equivalent to `count` calls of `next`.
    void skip(uint64_t count) {
        while (count > 624 - position) {
            count -= 624 - position;
            refill();
        }
        position += static_cast<uint32_t>(count);
    }

  private:
    // Has three loops without a modulo, because skipping many words spends most of its time here.
    void refill() {
        const auto twist = [this](uint32_t i, uint32_t next, uint32_t middle) {
            const uint32_t y = (words[i] & 0x80000000u) | (words[next] & 0x7fffffffu);
            words[i] = words[middle] ^ (y >> 1) ^ ((0u - (y & 1)) & 0x9908b0dfu);
        };
        for (uint32_t i = 0; i < 227; ++i) twist(i, i + 1, i + 397);
        for (uint32_t i = 227; i < 623; ++i) twist(i, i + 1, i - 227);
        twist(623, 0, 396);
        position = 0;
    }
};

// The machine's generator (RAM at power-on, timer at reset) starts from a seed, which is constant in ale-py. So its
// state is the number of words drawn. The twister itself is a cache, as it can be advanced to any position again.
class MachineRandom {
  public:
    static constexpr uint32_t kSeed = 4753849;
    static constexpr uint64_t kFurthest = uint64_t{1} << 32;  // a position that is reached within two seconds

    explicit MachineRandom(uint32_t seed = kSeed) : seed_(seed) { twister_.seed(seed_); }

    // Returns the word at `position`, counted from 0.
    uint32_t at(uint64_t position) {
        if (position < drawn_) {
            twister_.seed(seed_);
            drawn_ = 0;
        }
        twister_.skip(position - drawn_);
        drawn_ = position + 1;
        return twister_.next();
    }

  private:
    uint32_t seed_;
    MersenneTwister twister_;
    uint64_t drawn_ = 0;
};

}  // namespace atari
