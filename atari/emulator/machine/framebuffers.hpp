// The two framebuffers of a console: the frame that is being rendered or was rendered last, and the one before.
//
// A framebuffer is allocated when it is first rendered into. Environments that observe only RAM never allocate one.
// `hold` keeps the present contents of both: a held framebuffer is copied before it is overwritten, which is rare.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "raster.hpp"

namespace atari {

class Framebuffers {
  public:
    static constexpr int kMargin = 96;  // pixels after the last row: a blank of HMOVE may reach there
    static constexpr std::size_t kMost = kFrameBytes + kMargin;

    // Returns the pixels: as many bytes as `use` has allocated, or kMost zeros if `use` was never called.
    const uint8_t* operator[](int buffer) const {
        static constexpr std::array<uint8_t, kMost> kBlank{};
        const auto& pixels = pixels_[static_cast<std::size_t>(buffer)];
        return pixels.empty() ? kBlank.data() : pixels.data();
    }

    // Returns memory for rendering into the first `bytes` bytes.
    uint8_t* use(int buffer, std::size_t bytes) {
        if (holding_) keep(buffer);
        auto& pixels = pixels_[static_cast<std::size_t>(buffer)];
        if (pixels.size() < bytes) pixels.resize(bytes);
        return pixels.data();
    }

    // Keeps the present contents of both framebuffers, until `let_go` or `clear`.
    void hold() { holding_ = true; }
    const uint8_t* held(int buffer) const {
        const auto& copy = held_[static_cast<std::size_t>(buffer)];
        return copy.empty() ? (*this)[buffer] : copy.data();
    }
    void let_go() {
        if (!holding_) return;
        holding_ = false;
        held_ = {};
    }

    // Writes `last` so that it ends `bytes` bytes after the start of a framebuffer. A framebuffer that has no memory
    // and would stay blank gets none.
    void restore(int buffer, const std::vector<uint8_t>& last, std::size_t bytes) {
        auto& pixels = pixels_[static_cast<std::size_t>(buffer)];
        const bool blank =
            pixels.empty() && std::all_of(last.begin(), last.end(), [](uint8_t pixel) { return pixel == 0; });
        if (blank) return;
        if (holding_) keep(buffer);
        if (pixels.size() < bytes) pixels.resize(bytes);
        std::copy(last.begin(), last.end(), pixels.begin() + static_cast<std::ptrdiff_t>(bytes - last.size()));
    }

    // Discards what is rendered after the first `bytes` bytes: rows that no screen shows.
    void cut(std::size_t bytes) {
        for (int buffer : {0, 1}) {
            auto& pixels = pixels_[static_cast<std::size_t>(buffer)];
            if (pixels.size() <= bytes) continue;
            if (holding_) keep(buffer);
            pixels.resize(bytes);
        }
    }

    void save(int buffer, uint8_t* out) const {
        const auto& pixels = pixels_[static_cast<std::size_t>(buffer)];
        const std::size_t size = std::min(pixels.size(), std::size_t{kFrameBytes});
        std::fill(std::copy_n(pixels.data(), size, out), out + kFrameBytes, uint8_t{0});
    }

    // Gives each framebuffer that has memory at least `bytes` bytes.
    void fit(std::size_t bytes) {
        for (auto& pixels : pixels_)
            if (!pixels.empty() && pixels.size() < bytes) pixels.resize(bytes);
    }

    void clear() {
        let_go();
        for (auto& pixels : pixels_) std::fill(pixels.begin(), pixels.end(), uint8_t{0});
    }

  private:
    void keep(int buffer) {
        auto& copy = held_[static_cast<std::size_t>(buffer)];
        if (!copy.empty()) return;
        const auto& pixels = pixels_[static_cast<std::size_t>(buffer)];
        if (pixels.empty()) copy.resize(kMost);
        else copy = pixels;
    }

    std::array<std::vector<uint8_t>, 2> pixels_, held_;  // `held_`: copies of framebuffers overwritten since `hold`
    bool holding_ = false;
};

}  // namespace atari
