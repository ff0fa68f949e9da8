// The counters and the generator of a replay memory, as plain data. The saved state begins with them.
#pragma once

#include <bit>
#include <cstdint>

namespace atari::memory {

// The flags of a step of a lane. `kFirst` belongs to its frame, the other flags to its action.
enum Flags : uint8_t {
    kTerminated = 1,
    kTruncated = 2,
    kFirst = 4,   // the frame is the first of an episode
    kNoStep = 8,  // the action was ignored: the frame is an observation, but begins no transition
};

// xoshiro256** (Blackman and Vigna 2018).
struct Generator {
    uint64_t words[4];

    // Seeds by splitmix64, as the authors recommend.
    void seed(uint64_t value) {
        for (uint64_t& word : words) {
            value += 0x9e3779b97f4a7c15u;
            uint64_t mixed = (value ^ (value >> 30)) * 0xbf58476d1ce4e5b9u;
            mixed = (mixed ^ (mixed >> 27)) * 0x94d049bb133111ebu;
            word = mixed ^ (mixed >> 31);
        }
    }

    uint64_t next() {
        const uint64_t result = std::rotl(words[1] * 5, 7) * 9, shifted = words[1] << 17;
        words[2] ^= words[0];
        words[3] ^= words[1];
        words[1] ^= words[2];
        words[0] ^= words[3];
        words[2] ^= shifted;
        words[3] = std::rotl(words[3], 45);
        return result;
    }

    // Returns a uniform number in 0 .. count-1.
    uint64_t below(uint64_t count) {
        const uint64_t mask = std::bit_ceil(count) - 1;
        for (;;)
            if (const uint64_t drawn = next() & mask; drawn < count) return drawn;
    }

    // Returns a uniform number in [0, 1), a multiple of 2**-53.
    double fraction() { return static_cast<double>(next() >> 11) * 0x1p-53; }
};

struct State {
    int64_t head;         // the pending row, which has frames and no actions yet; rows count from 0 and never restart
    int64_t tail;         // the oldest row that can be sampled; equal to `head` if no row can be sampled
    int64_t finals;       // final observations ever stored
    int64_t first_final;  // the oldest final observation of a step from `tail` on
    int64_t steps;        // steps ever added, of all lanes
    Generator generator;
    double greatest;   // the greatest priority that was given to a stored step, 1 if none was; new steps get it
    uint64_t started;  // whether row 0 has its frames
};

// The greatest priority, and the greatest power of one by the exponent: their sums are finite.
constexpr double kMostPriority = 1e100;

// The header before a saved state. While the state is being written, `begun` is greater than `completed` by 2.
struct SectionHeader {
    uint64_t begun, completed;  // numbers of saves; a section has every second one
    uint64_t check;             // checksum of `begun` and the bytes after this header
};

}  // namespace atari::memory
