// `ObservationStack`: an agent's observation of an environment. The last frames of each skip are pooled, resized and
// stacked.
//
// Frames are rendered only when this class reads them. Implementations of the preprocessing differ in the observation
// when an episode ends inside a skip: see `EndFrames`.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "frame_source.hpp"
#include "resizer.hpp"

namespace atari {

// kGrayOfRgb pools the colours of two frames and converts the result to gray, by a table of pairs of colours. kRam has
// no pixels: a stack holds the RAM at the beginning of an episode and after each skip.
enum class PixelFormat { kNone, kGray, kRgb, kGrayOfRgb, kRam };
enum class EndFrames { kLast, kGymnasium, kBaselines, kEnvpool };
enum class Padding { kZero, kReset };  // fills a new stack: zeros, or the first frame of the episode

struct ObservationSettings {
    PixelFormat pixels = PixelFormat::kGray;
    int img_height = 84, img_width = 84, stack_num = 4;
    bool maxpool = true;
    EndFrames end_frames = EndFrames::kGymnasium;
    Padding padding = Padding::kZero;
};

// Owns a ring of resized frames.
class ObservationStack {
  public:
    // `resizer` is needed for all formats of pixels.
    ObservationStack(const FrameSource& source, const ObservationSettings& settings,
                     std::shared_ptr<const Resizer> resizer);

    FrameSource& source() { return source_; }
    // To be called when the source reads another environment than before, whose looks mean other rows.
    void forget_looks() {
        for (std::vector<uint32_t>& looks : looks_) looks.clear();
    }

    void begin(bool new_stack);   // adds the current screen
    void repeat(bool new_stack);  // adds the last resized frame again
    // To be called after each frame of a skip. `left` frames of the skip remain; `ended` is set if the episode has
    // ended.
    void frame_played(int left, bool ended);
    // Adds the resized frame of a skip. If the episode ended inside the skip, `left` frames were not played.
    void skip_ended(int left, bool ended);

    // While `draws` is false, skips add no frames. The stack lacks their frames until it is whole again: as many skips
    // or a reset have been added since.
    void set_draws(bool draws) { draws_ = draws; }
    bool is_whole() const { return lacking_ == 0; }

    const ObservationSettings& settings() const { return settings_; }
    size_t planes() const { return static_cast<size_t>(planes_); }  // 0 for kNone and kRam
    size_t size() const { return ring_.size(); }
    void write(uint8_t* out)
        const;  // (stack, height, width), for kRgb (stack, height, width, 3), for kRam (stack, 128); the oldest first

    size_t state_size() const;
    // Returns the end of the written bytes; `load` returns the end of the bytes read.
    uint8_t* save(uint8_t* out) const;
    const uint8_t* load(const uint8_t* in);

  private:
    void lack();
    bool lacks_newest() const { return lacking_ == settings_.stack_num; }
    void add(Frame early, Frame late);
    void find_changed_rows(Frame early, Frame late, uint8_t* changed);
    void add_changed_rows(Frame early, Frame late, const AreaResize& resize);
    void add_now();
    void add_rgb(Frame early, Frame late);
    void pool_rgb(Frame frame, uint8_t* colours) const;
    void add_pooled_with_last();
    void keep_last(Frame early, Frame late);
    void drop_last();
    void pool_last(uint8_t* out) const;
    void pool_all(Frame early, Frame late, uint8_t* out) const;
    size_t pooled_size() const { return pools_last_again_ ? static_cast<size_t>(planes_) * plane_size() : 0; }
    void pool_plane(Frame early, Frame late, int plane, int first, int count, uint8_t* out, uint32_t* changes) const;
    void resize_plane(int plane, const uint8_t* pooled, const uint32_t* changes, uint8_t* slot) const;
    uint8_t* next_slot();
    uint8_t* newest_slot() { return ring_.data() + frame_size_ * static_cast<size_t>(newest_); }
    // Returns whether frames are RGB of the screen's size. They are then pooled in the ring, all colours at once.
    bool is_screen_rgb() const {
        return planes_ == 3 && settings_.img_height == source_.rows() && settings_.img_width == kScreenWidth;
    }
    size_t plane_size() const { return static_cast<size_t>(source_.rows()) * kScreenWidth; }

    FrameSource source_;
    const ObservationSettings settings_;
    const std::shared_ptr<const Resizer> resizer_;
    const int planes_;
    const uint8_t* tables_[3];      // by plane, of 256 values; for kGrayOfRgb `gray_of_pairs`
    std::vector<uint8_t> colours_;  // for kRgb: the memory of `tables_`
    // With EndFrames::kGymnasium, an episode may end with the last frame pooled once more. The source holds the two
    // framebuffers, with the numbers `last_`, that the last frame was pooled from. If the source cannot, `pooled_`
    // holds the planes of that frame before it was resized. At most one of the two is in use.
    const bool pools_last_again_;
    int last_[2] = {-1, -1};
    std::vector<uint8_t> pooled_;
    std::vector<uint8_t> late_;       // for kBaselines: the last frame of the last whole skip
    bool early_noted_ = false;        // whether the source has noted the last frame but one of the present skip
    std::vector<uint32_t> looks_[2];  // by row, looks of the two frames of the newest resized frame; 0 is unknown
    std::vector<uint8_t> ring_;       // the last `stack` resized frames
    size_t frame_size_;               // bytes of a resized frame
    int newest_ = 0;                  // slot of the newest resized frame
    bool draws_ = true;
    int lacking_ = 0;  // slots without their frames, the oldest ones
};

}  // namespace atari
