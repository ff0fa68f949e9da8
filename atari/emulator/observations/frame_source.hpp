// `FrameSource`: the frames that an `ObservationStack` reads, from an environment or from arrays of the caller.
#pragma once

#include <cstdint>
#include <vector>

#include "ale/environment_parts.hpp"

namespace atari {

// A frame of palette indices. `looks` has the looks of its rows (LineCache::looks), or is null. `framebuffer` is the
// number of the console's framebuffer that holds it, or -1.
struct Frame {
    const uint8_t* pixels;
    const uint32_t* looks = nullptr;
    int framebuffer = -1;
};

// The memory that it reads must exist while frames are read. It owns a copy of the noted frame if the next frame
// overwrites that frame.
class FrameSource {
  public:
    // Reads an environment without averaged colours, for which no other source holds frames.
    explicit FrameSource(Environment& environment)
        : rows_(environment.height()), palette_(environment.parts().game->palette), environment_(&environment),
          holder_(&environment) {}
    // Reads frames of rows x 160 that `read` gets.
    FrameSource(int rows, const Palette& palette) : rows_(rows), palette_(&palette) {}

    // Reads the environment, or the frame, from here on. Frames of an environment are rendered when they are read.
    void read(Environment& environment) {
        environment_ = &environment;
        pixels_ = nullptr;
    }
    void read(const uint8_t* pixels) {
        environment_ = nullptr;
        pixels_ = pixels;
    }
    // Reads the environment with which the source was made again, if there is one.
    void read_own() {
        if (holder_) read(*holder_);
    }

    int rows() const { return rows_; }
    const Palette& palette() const { return *palette_; }

    Frame current() {
        if (!environment_) return {pixels_};
        const uint8_t* const pixels = console().framebuffer();  // rendered first
        return {pixels, console().looks(), console().machine().tia.current};
    }

    // The present RAM: the environment's, or the bytes that the caller passed in place of a frame.
    const uint8_t* ram() const { return environment_ ? environment_->ram() : pixels_; }

    // Notes the present frame; `noted` returns it after the next frame. A console renders the next frame into its other
    // framebuffer. It continues a partial frame in place, so a partial frame is copied.
    void note() {
        copied_ = !environment_ || console().machine().tia.partial;
        if (!copied_) return std::vector<uint8_t>().swap(copy_);  // frees the memory
        const uint8_t* const pixels = current().pixels;
        copy_.assign(pixels, pixels + rows_ * kScreenWidth);
    }
    Frame noted() {
        if (copied_) return {copy_.data()};
        if (!environment_) return current();
        const uint8_t* const pixels = console().previous_framebuffer();
        return {pixels, console().previous_looks(), console().machine().tia.current ^ 1};
    }

    // Keeps the console's framebuffers, one of which has this frame, until `let_go`. Returns false if this source
    // cannot.
    bool hold(Frame frame) {
        if (!holder_ || frame.framebuffer < 0) return false;
        framebuffers().hold();
        return true;
    }
    void let_go() {
        if (holder_) framebuffers().let_go();
    }
    Frame held(int framebuffer) const { return {framebuffers().held(framebuffer)}; }

  private:
    Console& console() const { return *environment_->parts().console; }
    Framebuffers& framebuffers() const { return holder_->parts().console->framebuffers(); }

    int rows_;
    const Palette* palette_;
    Environment* environment_ = nullptr;
    const uint8_t* pixels_ = nullptr;
    Environment* holder_ = nullptr;  // whose framebuffers are held, or null
    bool copied_ = false;            // whether `copy_` is the noted frame
    std::vector<uint8_t> copy_;
};

}  // namespace atari
