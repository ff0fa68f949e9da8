#include "observation_stack.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "ale/colours/colour_conversion.hpp"
#include "ale/programs/labels.hpp"
#include "gray_of_pairs.hpp"
#include "pooling.hpp"

namespace atari {
namespace {

// A pooled plane, as working memory on the stack: a thread has its stack from its start. If the C library has no memory
// for a new thread's `thread_local` variables, it aborts the process.
struct PooledPlane {
    uint8_t pixels[kFrameBytes];
    uint32_t changes[kFrameRows];
};

// Frees the memory too; an assignment of {} would keep it.
void release(std::vector<uint8_t>& values) { std::vector<uint8_t>().swap(values); }

}  // namespace

ObservationStack::ObservationStack(const FrameSource& source, const ObservationSettings& settings,
                                   std::shared_ptr<const Resizer> resizer)
    : source_(source), settings_(settings), resizer_(std::move(resizer)),
      planes_(settings.pixels == PixelFormat::kNone || settings.pixels == PixelFormat::kRam ? 0
              : settings.pixels == PixelFormat::kRgb                                        ? 3
                                                                                            : 1),
      pools_last_again_(settings.maxpool && settings.end_frames == EndFrames::kGymnasium && !is_screen_rgb()) {
    const Palette& palette = source_.palette();
    tables_[0] = settings_.pixels == PixelFormat::kGrayOfRgb ? gray_of_pairs(palette) : palette.gray;
    if (settings_.pixels == PixelFormat::kRgb) {
        for (int plane = 0; plane < 3; ++plane)
            for (int i = 0; i < 256; ++i) colours_.push_back(static_cast<uint8_t>(palette.rgb[i] >> (16 - 8 * plane)));
        for (int plane = 0; plane < 3; ++plane) tables_[plane] = colours_.data() + 256 * plane;
    }
    const auto planes = static_cast<size_t>(planes_);
    if (planes && settings_.end_frames == EndFrames::kBaselines) late_.resize(plane_size());
    frame_size_ = planes * static_cast<size_t>(settings_.img_height) * static_cast<size_t>(settings_.img_width);
    if (settings.pixels == PixelFormat::kRam) frame_size_ = kRamSize;
    ring_.resize(frame_size_ * static_cast<size_t>(settings_.stack_num));
}

void ObservationStack::begin(bool new_stack) {
    if (!frame_size_) return;
    early_noted_ = false;
    if (planes_) drop_last();
    std::fill(late_.begin(), late_.end(), uint8_t{0});
    add_now();
    if (new_stack) repeat(true);
}

void ObservationStack::repeat(bool new_stack) {
    if (!frame_size_) return;
    if (lacks_newest()) return new_stack ? void() : lack();
    if (!new_stack) {
        const uint8_t* const last = newest_slot();
        uint8_t* const slot = next_slot();
        if (slot != last) std::memcpy(slot, last, frame_size_);
        return;
    }
    const uint8_t* const last = newest_slot();
    for (uint8_t* slot = ring_.data(); slot != ring_.data() + ring_.size(); slot += frame_size_) {
        if (slot == last) continue;
        if (settings_.padding == Padding::kZero) std::memset(slot, 0, frame_size_);
        else std::memcpy(slot, last, frame_size_);
    }
    lacking_ = 0;
}

// Notes the last frame but one of a skip.
void ObservationStack::frame_played(int left, bool ended) {
    if (left != 1 || !planes_ || !draws_ || !settings_.maxpool ||
        (ended && settings_.end_frames == EndFrames::kGymnasium))
        return;
    early_noted_ = true;
    source_.note();
}

void ObservationStack::skip_ended(int left, bool ended) {
    if (settings_.pixels == PixelFormat::kRam) return add_now();
    if (!planes_) return;
    if (!draws_) return lack();
    const bool pools = std::exchange(early_noted_, false);
    if (left == 0 && !(ended && settings_.end_frames == EndFrames::kGymnasium)) {
        drop_last();
        // In the order in which the frames were played: consecutive frames share more lines, which are not rendered
        // again.
        const Frame first = pools ? source_.noted() : source_.current(), last = source_.current();
        if (!late_.empty()) std::copy_n(last.pixels, late_.size(), late_.begin());
        return add(first, last);
    }
    switch (settings_.end_frames) {
        case EndFrames::kLast: return add_now();
        case EndFrames::kGymnasium:  // without the frame that ended the episode; with the frame before, if it was noted
            if (!pools || lacks_newest()) break;
            return add_pooled_with_last();
        case EndFrames::kBaselines:
            if (!pools || lacks_newest()) break;
            return add(source_.current(), {late_.data(), nullptr});
        case EndFrames::kEnvpool:
            if (!pools) break;
            return add_now();
    }
    repeat(false);
}

// Moves on by a slot without a frame.
void ObservationStack::lack() {
    newest_ = (newest_ + 1) % settings_.stack_num;
    if (lacks_newest()) return;
    lacking_ = settings_.stack_num;
    drop_last();
    forget_looks();
}

// Adds the present frame, or the present RAM.
void ObservationStack::add_now() {
    if (planes_) return add(source_.current(), source_.current());
    std::memcpy(next_slot(), source_.ram(), kRamSize);
}

void ObservationStack::add(Frame early, Frame late) {
    if (is_screen_rgb()) return add_rgb(early, late);
    if (const AreaResize* resize = resizer_->area_resize(); resize && planes_ == 1) {
        add_changed_rows(early, late, *resize);
    } else {
        PooledPlane pooled;
        uint8_t* const slot = next_slot();
        for (int plane = 0; plane < planes_; ++plane) {
            pool_plane(early, late, plane, 0, source_.rows(), pooled.pixels, pooled.changes);
            resize_plane(plane, pooled.pixels, pooled.changes, slot);
        }
    }
    if (pools_last_again_) keep_last(early, late);
}

// Pools all planes of two frames.
void ObservationStack::pool_all(Frame early, Frame late, uint8_t* out) const {
    uint32_t changes[kFrameRows];
    for (int plane = 0; plane < planes_; ++plane, out += plane_size())
        pool_plane(early, late, plane, 0, source_.rows(), out, changes);
}

// Keeps the frames that the newest resized frame was pooled from, in place of the frames kept before.
void ObservationStack::keep_last(Frame early, Frame late) {
    if (source_.hold(early)) {
        last_[0] = early.framebuffer;
        last_[1] = late.framebuffer;
        return;
    }
    pooled_.resize(pooled_size());
    pool_all(early, late, pooled_.data());
}

// To be called before the frames of the next resized frame are rendered.
void ObservationStack::drop_last() {
    source_.let_go();
    last_[0] = last_[1] = -1;
    release(pooled_);
}

// Writes the planes of the newest resized frame before it was resized.
void ObservationStack::pool_last(uint8_t* out) const {
    if (!pooled_.empty()) {
        std::copy(pooled_.begin(), pooled_.end(), out);
    } else if (last_[0] < 0) {  // no frame is kept
        std::fill_n(out, pooled_size(), uint8_t{0});
    } else {
        pool_all(source_.held(last_[0]), source_.held(last_[1]), out);
    }
}

// Sets `changed` for each row whose looks differ from those of the newest resized frame, or are unknown.
void ObservationStack::find_changed_rows(Frame early, Frame late, uint8_t* changed) {
    static constexpr uint32_t kUnknown[kFrameRows] = {};
    const auto height = static_cast<size_t>(source_.rows());
    for (std::vector<uint32_t>& looks : looks_) looks.resize(height);
    const uint32_t* const first = early.looks ? early.looks : kUnknown;
    const uint32_t* const second = late.looks ? late.looks : kUnknown;
    uint32_t *const first_before = looks_[0].data(), *const second_before = looks_[1].data();
    for (size_t row = 0; row < height; ++row) {  // no branch, so that the compiler vectorizes the loop
        const bool same = (first[row] == first_before[row]) & (second[row] == second_before[row]);
        changed[row] = !(same & (first[row] != 0) & (second[row] != 0));
    }
    std::copy_n(first, height, first_before);
    std::copy_n(second, height, second_before);
}

// Copies the result rows whose source rows have not changed from the newest resized frame.
// (tests/vector/test_equals_ale_py.py and test_presets.py compare every byte)
void ObservationStack::add_changed_rows(Frame early, Frame late, const AreaResize& resize) {
    const int results = settings_.img_height;
    uint8_t changed[kFrameRows];
    PooledPlane pooled;
    find_changed_rows(early, late, changed);
    const auto width = static_cast<size_t>(settings_.img_width);
    const auto is_new = [&](int result) {
        const auto [first, last] = resize.sources(result);
        return std::find(changed + first, changed + last + 1, uint8_t{1}) != changed + last + 1;
    };
    const uint8_t* const before = newest_slot();
    uint8_t* const slot = next_slot();
    for (int first = 0, end; first < results; first = end) {
        const bool make = is_new(first);
        for (end = first + 1; end < results && is_new(end) == make;) ++end;
        if (make) {
            const int from = resize.sources(first).first, count = resize.sources(end - 1).last + 1 - from;
            pool_plane(early, late, 0, from, count, pooled.pixels, pooled.changes);
            resize.make_rows(pooled.pixels, pooled.changes, slot, first, end);
        } else if (slot != before) {
            const size_t offset = width * static_cast<size_t>(first), size = width * static_cast<size_t>(end - first);
            std::memcpy(slot + offset, before + offset, size);
        }
    }
}

// Pools rows first .. first+count-1 of a plane into the same rows of `out` and `changes`.
void ObservationStack::pool_plane(Frame early, Frame late, int plane, int first, int count, uint8_t* out,
                                  uint32_t* changes) const {
    const auto offset = kScreenWidth * first;
    const auto pooling = [&](auto function) {
        function(early.pixels + offset, late.pixels + offset, count, tables_[plane], out + offset, changes + first);
    };
    if (settings_.pixels == PixelFormat::kGrayOfRgb) pooling([](auto... arguments) { pool_pairs(arguments...); });
    else pooling([](auto... arguments) { pool_gray(arguments...); });
}

void ObservationStack::add_rgb(Frame early, Frame late) {
    uint8_t* const slot = next_slot();
    to_rgb(late.pixels, source_.rows(), source_.palette(), slot);
    if (early.pixels != late.pixels) pool_rgb(early, slot);
}

// Raises `colours` to the maximum of itself and of a frame, channel by channel.
void ObservationStack::pool_rgb(Frame frame, uint8_t* colours) const {
    uint8_t others[3 * kScreenWidth];
    for (int row = 0; row < source_.rows(); ++row, colours += sizeof others) {
        to_rgb(frame.pixels + kScreenWidth * row, 1, source_.palette(), others);
        for (size_t i = 0; i < sizeof others; ++i) colours[i] = std::max(colours[i], others[i]);
    }
}

// Adds the last frame but one of the skip, pooled with the frames that the newest resized frame was pooled from.
void ObservationStack::add_pooled_with_last() {
    if (is_screen_rgb()) {
        repeat(false);
        return pool_rgb(source_.noted(), newest_slot());
    }
    const Frame frame = source_.noted();
    std::vector<uint8_t> pooled(pooled_size());
    pool_last(pooled.data());
    PooledPlane others;
    uint8_t* const slot = next_slot();
    for (int plane = 0; plane < planes_; ++plane) {
        uint8_t* const out = pooled.data() + plane_size() * static_cast<size_t>(plane);
        pool_plane(frame, frame, plane, 0, source_.rows(), others.pixels, others.changes);
        for (size_t i = 0; i < plane_size(); ++i) out[i] = std::max(out[i], others.pixels[i]);
        resize_plane(plane, out, nullptr, slot);
    }
    drop_last();
    pooled_ = std::move(pooled);
    forget_looks();
}

uint8_t* ObservationStack::next_slot() {
    newest_ = (newest_ + 1) % settings_.stack_num;
    if (lacking_) [[unlikely]]
        --lacking_;
    return newest_slot();
}

// Resizes a pooled plane into its place in `slot`. `changes` has an entry for each row, or is null if the changes are
// unknown.
void ObservationStack::resize_plane(int plane, const uint8_t* pooled, const uint32_t* changes, uint8_t* slot) const {
    if (planes_ == 1) return (*resizer_)(pooled, changes, slot);
    std::vector<uint8_t> resized(frame_size_ / 3);
    (*resizer_)(pooled, changes, resized.data());
    for (size_t i = 0; i < resized.size(); ++i) slot[3 * i + static_cast<size_t>(plane)] = resized[i];
}

void ObservationStack::write(uint8_t* out) const {
    const size_t oldest = frame_size_ * static_cast<size_t>((newest_ + 1) % settings_.stack_num);
    std::memcpy(out, ring_.data() + oldest, ring_.size() - oldest);
    std::memcpy(out + (ring_.size() - oldest), ring_.data(), oldest);
}

size_t ObservationStack::state_size() const { return pooled_size() + late_.size() + ring_.size() + sizeof newest_; }

uint8_t* ObservationStack::save(uint8_t* out) const {
    if (pools_last_again_) pool_last(out);
    out += pooled_size();
    for (const std::vector<uint8_t>* part : {&late_, &ring_}) out = std::copy(part->begin(), part->end(), out);
    std::memcpy(out, &newest_, sizeof newest_);
    return out + sizeof newest_;
}

const uint8_t* ObservationStack::load(const uint8_t* in) {
    drop_last();
    pooled_.assign(in, in + pooled_size());
    in += pooled_size();
    for (std::vector<uint8_t>* part : {&late_, &ring_}) {
        std::copy_n(in, part->size(), part->begin());
        in += part->size();
    }
    std::memcpy(&newest_, in, sizeof newest_);
    newest_ = std::clamp(newest_, 0, settings_.stack_num - 1);
    lacking_ = 0;
    forget_looks();
    return in + sizeof newest_;
}

}  // namespace atari
