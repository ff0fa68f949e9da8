// The bitmap of the steps that can be sampled, with counts that find the k-th step directly.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace atari::memory {

// A bitmap in blocks of 512 bits. A Fenwick tree (Fenwick 1994) has the sums of the blocks' counts.
class ValidSteps {
  public:
    explicit ValidSteps(int64_t size)
        : words_((static_cast<size_t>(size) / kBlock + 1) * kWords), sums_(static_cast<size_t>(size) / kBlock + 2) {
        top_ = std::bit_floor(sums_.size() - 1);
    }

    bool get(int64_t index) const { return words_[word(index)] >> (index & 63) & 1; }

    void set(int64_t index, bool value) {
        if (get(index) == value) return;
        words_[word(index)] ^= uint64_t{1} << (index & 63);
        const int64_t change = value ? 1 : -1;
        total_ += change;
        for (size_t i = static_cast<size_t>(index) / kBlock + 1; i < sums_.size(); i += i & (~i + 1))
            sums_[i] += change;
    }

    int64_t total() const { return total_; }

    // Returns the number of set bits below `index`.
    int64_t rank(int64_t index) const {
        int64_t count = 0;
        for (size_t i = static_cast<size_t>(index) / kBlock; i > 0; i &= i - 1) count += sums_[i];
        for (size_t i = static_cast<size_t>(index) / kBlock * kWords; i < word(index); ++i)
            count += std::popcount(words_[i]);
        return count + std::popcount(words_[word(index)] & ((uint64_t{1} << (index & 63)) - 1));
    }

    // Returns the index of the bit with the rank `rank`, which must be less than `total()`.
    int64_t select(int64_t rank) const {
        size_t block = 0;
        for (size_t step = top_; step > 0; step /= 2)
            if (block + step < sums_.size() && sums_[block + step] <= rank) rank -= sums_[block += step];
        size_t i = block * kWords;
        for (int64_t count; (count = std::popcount(words_[i])) <= rank; ++i) rank -= count;
        uint64_t bits = words_[i];
        for (; rank > 0; --rank) bits &= bits - 1;
        return static_cast<int64_t>(i * 64) + std::countr_zero(bits);
    }

  private:
    static constexpr size_t kBlock = 512, kWords = kBlock / 64;
    static size_t word(int64_t index) { return static_cast<size_t>(index) / 64; }

    std::vector<uint64_t> words_;
    std::vector<int64_t> sums_;  // sums_[i] counts the i & -i blocks that end with block i - 1
    size_t top_;
    int64_t total_ = 0;
};

}  // namespace atari::memory
