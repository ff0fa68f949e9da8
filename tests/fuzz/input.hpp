// Reads and writes fuzzing inputs: a sequence of small numbers and chunks, in the order in which the target reads them.
// An input that ends early continues with zeros, so every string of bytes is an input.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace atari {

// The steps at the end of an input.
// clang-format off
enum class ConsoleStep : uint8_t {
    kFrame, kInstructions, kPress, kLook, kCompare, kChangePlaces, kDamage, kReset, kSamples, kRead, kWrite, kCount
};
enum class EnvironmentStep : uint8_t {
    kAct, kReset, kLook, kCompare, kChangePlaces, kRestore, kDamage, kSeed, kSetRam, kMode, kDifficulty, kCount
};
// clang-format on

class Reader {
  public:
    Reader(const uint8_t* data, size_t size) : at_(data), left_(size) {}

    bool empty() const { return left_ == 0; }
    uint8_t byte() {
        if (empty()) return 0;
        --left_;
        return *at_++;
    }
    // One byte for 0..239 and for -1..-15, five bytes for all other numbers: most numbers are small, but any can be
    // reached.
    int32_t number() {
        const uint8_t first = byte();
        if (first < 240) return first;
        if (first < 255) return 239 - first;
        uint32_t word = 0;
        for (int shift = 0; shift < 32; shift += 8) word |= uint32_t{byte()} << shift;
        return static_cast<int32_t>(word);
    }
    uint16_t word() {
        const uint8_t low = byte();
        return static_cast<uint16_t>(low | byte() << 8);
    }
    std::vector<uint8_t> chunk() {
        const size_t size = std::min<size_t>(word(), left_);
        const std::vector<uint8_t> bytes(at_, at_ + size);
        at_ += size;
        left_ -= size;
        return bytes;
    }

  private:
    const uint8_t* at_;
    size_t left_;
};

class Writer {
  public:
    Writer& byte(uint8_t value) {
        bytes_.push_back(value);
        return *this;
    }
    Writer& number(int32_t value) {
        if (value >= 0 && value < 240) return byte(static_cast<uint8_t>(value));
        if (value < 0 && value >= -15) return byte(static_cast<uint8_t>(239 - value));
        byte(255);
        for (int shift = 0; shift < 32; shift += 8) byte(static_cast<uint8_t>(static_cast<uint32_t>(value) >> shift));
        return *this;
    }
    Writer& word(size_t value) { return byte(static_cast<uint8_t>(value)).byte(static_cast<uint8_t>(value >> 8)); }
    Writer& chunk(const std::vector<uint8_t>& bytes) {
        word(bytes.size());
        bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
        return *this;
    }
    const std::vector<uint8_t>& bytes() const { return bytes_; }

  private:
    std::vector<uint8_t> bytes_;
};

}  // namespace atari
