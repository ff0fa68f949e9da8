// The two pictures of a console: the frame that is being drawn or was drawn last, and the one before.
//
// They take memory when they are drawn to: where nobody looks at pictures, as in environments that observe RAM, they
// need none. Both can be held as they are now; then what is drawn over is copied first, which is rare.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "state.hpp"

namespace atari {

class Pictures {
  public:
    static constexpr int kBehind = 96;  // a blank of HMOVE may reach past the last row
    static constexpr std::size_t kMost = kFrameBytes + kBehind;

    // For reading as many bytes as have been drawn to, or kMost of a picture that has not: then all are 0.
    const uint8_t* operator[](int picture) const {
        static constexpr std::array<uint8_t, kMost> kBlank{};
        const auto& pixels = pixels_[static_cast<std::size_t>(picture)];
        return pixels.empty() ? kBlank.data() : pixels.data();
    }

    // For drawing to the first so many bytes.
    uint8_t* use(int picture, std::size_t bytes) {
        if (holding_) keep(picture);
        auto& pixels = pixels_[static_cast<std::size_t>(picture)];
        if (pixels.size() < bytes) pixels.resize(bytes);
        return pixels.data();
    }

    // Holds both pictures as they are now, until they are let go or cleared.
    void hold() { holding_ = true; }
    const uint8_t* held(int picture) const {
        const auto& copy = held_[static_cast<std::size_t>(picture)];
        return copy.empty() ? (*this)[picture] : copy.data();
    }
    void let_go() {
        if (!holding_) return;
        holding_ = false;
        held_ = {};
    }

    // Restores the last of so many bytes, behind which there is nothing. A picture that was never drawn to and would stay
    // blank takes no memory.
    void restore(int picture, const std::vector<uint8_t>& last, std::size_t bytes) {
        auto& pixels = pixels_[static_cast<std::size_t>(picture)];
        const bool blank = pixels.empty() && std::all_of(last.begin(), last.end(), [](uint8_t pixel) { return pixel == 0; });
        if (blank) return;
        if (holding_) keep(picture);
        pixels.resize(bytes);
        std::copy(last.begin(), last.end(), pixels.end() - static_cast<std::ptrdiff_t>(last.size()));
    }

    void save(int picture, uint8_t* out) const {
        const auto& pixels = pixels_[static_cast<std::size_t>(picture)];
        const std::size_t size = std::min(pixels.size(), std::size_t{kFrameBytes});
        std::fill(std::copy_n(pixels.data(), size, out), out + kFrameBytes, uint8_t{0});
    }

    // Pictures that have memory get so many bytes at least.
    void fit(std::size_t bytes) {
        for (auto& pixels : pixels_)
            if (!pixels.empty() && pixels.size() < bytes) pixels.resize(bytes);
    }

    void clear() {
        let_go();
        for (auto& pixels : pixels_) std::fill(pixels.begin(), pixels.end(), uint8_t{0});
    }

  private:
    void keep(int picture) {
        auto& copy = held_[static_cast<std::size_t>(picture)];
        if (!copy.empty()) return;
        const auto& pixels = pixels_[static_cast<std::size_t>(picture)];
        if (pixels.empty()) copy.resize(kMost);
        else copy = pixels;
    }

    std::array<std::vector<uint8_t>, 2> pixels_, held_;  // `held_` only what has been drawn over
    bool holding_ = false;
};

}  // namespace atari
