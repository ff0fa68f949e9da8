// A checksum of 64 bits, as fast as memory. It finds damage; it does not resist forgery.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace atari::memory {

class Checksum {
  public:
    explicit Checksum(uint64_t seed) {
        for (uint64_t i = 0; i < 4; ++i) sums_[i] = (seed + i + 1) * kOdd;
    }

    void add(const void* data, size_t size) {
        const auto* bytes = static_cast<const uint8_t*>(data);
        length_ += size;
        for (; size >= 32; size -= 32, bytes += 32) {
            uint64_t words[4];
            std::memcpy(words, bytes, 32);
            for (int i = 0; i < 4; ++i) sums_[i] = mixed(sums_[i], words[i]);
        }
        for (int i = 0; size > 0; ++i) {
            const size_t part = size < 8 ? size : 8;
            uint64_t word = 0;
            std::memcpy(&word, bytes, part);
            sums_[i] = mixed(sums_[i], word);
            bytes += part;
            size -= part;
        }
    }

    uint64_t value() const {
        uint64_t result = length_ * kOdd;
        for (const uint64_t sum : sums_) result = mixed(result, sum ^ (sum >> 29));
        return result ^ (result >> 32);
    }

  private:
    static constexpr uint64_t kOdd = 0x9e3779b97f4a7c15u;
    // A bijection of the sum for each word, so one changed word always changes the result.
    static uint64_t mixed(uint64_t sum, uint64_t word) { return std::rotl((sum ^ word) * kOdd, 29); }

    uint64_t sums_[4];
    uint64_t length_ = 0;
};

}  // namespace atari::memory
