// What an agent sees of an environment: the last frames of each skip pooled, made small, and stacked.
//
// Frames are only drawn where they are looked at, here. Implementations of this preprocessing differ in what they show
// when an episode ends inside a skip; see `EndFrames`, and atari/wrappers/dqn_preprocessing.py for the same in Python.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "environment.hpp"
#include "scaler.hpp"

namespace atari {

enum class Pixels { kNone, kGray, kRgb, kGrayOfRgb };  // the last: colours pooled, then made gray by a table of pairs
enum class EndFrames { kLast, kGymnasium, kBaselines, kEnvpool };

struct ViewSettings {
    Pixels pixels = Pixels::kGray;
    int height = 84, width = 84, stack = 4;
    bool max_pool = true;
    EndFrames end_frames = EndFrames::kGymnasium;
    bool pads_zero = true;  // before the first picture of an episode; otherwise that one, repeated
    std::shared_ptr<const std::vector<uint8_t>> pairs;  // for kGrayOfRgb: 256 x 256 gray values
};

class View {
  public:
    View(Environment& environment, const ViewSettings& settings, std::shared_ptr<const Scaler> scaler);

    void begin(bool fill);           // shows the screen; `fill` begins a new stack
    void repeat(bool fill);          // shows the last picture again
    // A frame of a skip has been played, `left` are still to be; has the episode ended?
    void played(int left, bool ended);
    // A skip has been played, but for `left` frames after which the episode ended.
    void end(int left, bool ended);

    size_t size() const { return ring_.size(); }
    void write(uint8_t* out) const;  // (stack, height, width), for kRgb (stack, height, width, 3); the oldest first

    size_t state_size() const;
    uint8_t* save(uint8_t* out) const;  // return what follows
    const uint8_t* load(const uint8_t* in);

  private:
    // A frame's palette indices, how its rows look (LineCache::looks) or null, and which picture of the console it is or -1.
    struct Frame {
        const uint8_t* pixels;
        const uint32_t* looks;
        int picture = -1;
    };
    void show(Frame early, Frame late);
    void note_changes(Frame early, Frame late, uint8_t* changed);
    void forget_looks() {
        for (std::vector<uint32_t>& looks : looks_) looks.clear();
    }
    void show_changes(Frame early, Frame late, const AreaResize& resize);
    void show_in_colour(Frame early, Frame late);
    void pool_colours(Frame frame, uint8_t* colours) const;
    void show_with_last();
    void remember(Frame early, Frame late);
    void forget_last();
    void pool_last(uint8_t* out) const;
    void pool_all(Frame early, Frame late, uint8_t* out, uint32_t* changes) const;
    size_t pooled_size() const { return pools_again_ ? static_cast<size_t>(planes_) * plane_size() : 0; }
    void pool_plane(Frame early, Frame late, int plane, int first, int count, uint8_t* out, uint32_t* changes) const;
    void push(const uint8_t* pooled, const uint32_t* changes);
    uint8_t* next_place();
    Frame early() {
        if (early_copied_) return {early_.data(), nullptr};
        Console& console = environment_.console();
        const uint8_t* const pixels = console.previous_picture();
        return {pixels, console.previous_looks(), console.machine().tia.current ^ 1};
    }
    Frame current() {
        Console& console = environment_.console();
        const uint8_t* const pixels = console.picture();
        return {pixels, console.looks(), console.machine().tia.current};
    }
    // RGB of the picture's own size: made as it is, all colours at once.
    bool as_it_is() const {
        return planes_ == 3 && settings_.height == environment_.height() && settings_.width == kScreenWidth;
    }
    size_t plane_size() const { return static_cast<size_t>(environment_.height()) * kScreenWidth; }

    Environment& environment_;
    const ViewSettings settings_;
    const std::shared_ptr<const Scaler> scaler_;
    const int planes_;
    const uint8_t* tables_[3];           // of 256 values, by plane
    std::vector<uint8_t> colours_;       // what they point to for kRgb
    // An episode may end with the last picture pooled once more. What that was made of is held by the console, in
    // pictures with these numbers; where it cannot, it is kept as planes before they were made small.
    const bool pools_again_;
    int last_[2] = {-1, -1};
    std::vector<uint8_t> pooled_;
    std::vector<uint8_t> late_;          // for kBaselines: the last whole skip's last frame
    std::vector<uint8_t> early_;         // a frame that the console will not keep
    bool early_noted_ = false, early_copied_ = false;
    std::vector<uint32_t> looks_[2];     // by row, of both frames the newest small picture was made of; 0 if not known
    std::vector<uint8_t> ring_;          // of small pictures
    size_t picture_size_;
    int newest_ = 0;
};

}  // namespace atari
