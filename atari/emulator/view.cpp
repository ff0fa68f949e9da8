#include "view.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "paint.hpp"

namespace atari {
namespace {

// A thread's own, for what is done with at once. So environments have no such memory each.
template <typename Value>
Value* working_memory(size_t size) {
    thread_local std::vector<Value> memory;
    if (memory.size() < size) memory.resize(size);
    return memory.data();
}

// Gives its memory back, too, which an assignment of {} keeps.
void release(std::vector<uint8_t>& values) { std::vector<uint8_t>().swap(values); }

}  // namespace

View::View(Environment& environment, const ViewSettings& settings, std::shared_ptr<const Scaler> scaler)
    : environment_(environment), settings_(settings), scaler_(std::move(scaler)),
      planes_(settings.pixels == Pixels::kNone ? 0 : settings.pixels == Pixels::kRgb ? 3 : 1),
      pools_again_(settings.max_pool && settings.end_frames == EndFrames::kGymnasium && !as_it_is()) {
    const Palette& palette = *environment.game()->palette;
    tables_[0] = settings_.pixels == Pixels::kGrayOfRgb ? settings_.pairs->data() : palette.gray;
    if (settings_.pixels == Pixels::kRgb) {
        for (int plane = 0; plane < 3; ++plane)
            for (int i = 0; i < 256; ++i) colours_.push_back(static_cast<uint8_t>(palette.rgb[i] >> (16 - 8 * plane)));
        for (int plane = 0; plane < 3; ++plane) tables_[plane] = colours_.data() + 256 * plane;
    }
    const auto planes = static_cast<size_t>(planes_);
    if (planes && settings_.end_frames == EndFrames::kBaselines) late_.resize(plane_size());
    picture_size_ = planes * static_cast<size_t>(settings_.height) * static_cast<size_t>(settings_.width);
    ring_.resize(picture_size_ * static_cast<size_t>(settings_.stack));
}

void View::begin(bool fill) {
    if (!planes_) return;
    early_noted_ = false;
    forget_last();
    std::fill(late_.begin(), late_.end(), uint8_t{0});
    show(current(), current());
    if (fill) repeat(true);
}

void View::repeat(bool fill) {
    if (!planes_) return;
    if (!fill) {
        const uint8_t* const last = ring_.data() + picture_size_ * static_cast<size_t>(newest_);
        uint8_t* const place = next_place();
        if (place != last) std::memcpy(place, last, picture_size_);
        return;
    }
    const uint8_t* const last = ring_.data() + picture_size_ * static_cast<size_t>(newest_);
    for (uint8_t* place = ring_.data(); place != ring_.data() + ring_.size(); place += picture_size_) {
        if (place == last) continue;
        if (settings_.pads_zero) std::memset(place, 0, picture_size_);
        else std::memcpy(place, last, picture_size_);
    }
}

// A frame goes to the console's other buffer, where the next one leaves it alone, unless that one continues it.
void View::played(int left, bool ended) {
    if (left != 1 || !planes_ || !settings_.max_pool || (ended && settings_.end_frames == EndFrames::kGymnasium)) return;
    early_noted_ = true;
    early_copied_ = environment_.console().machine().tia.partial;
    if (early_copied_) early_.assign(current().pixels, current().pixels + plane_size());
    else release(early_);
}

void View::end(int left, bool ended) {
    if (!planes_) return;
    const bool pools = std::exchange(early_noted_, false);
    if (left == 0 && !(ended && settings_.end_frames == EndFrames::kGymnasium)) {
        forget_last();
        // In the order in which they were played: nearer pictures have more lines in common, which are not drawn again.
        const Frame first = pools ? early() : current(), last = current();
        if (!late_.empty()) std::copy_n(last.pixels, late_.size(), late_.begin());
        return show(first, last);
    }
    switch (settings_.end_frames) {
        case EndFrames::kLast:
            return show(current(), current());
        case EndFrames::kGymnasium:  // not the frame that ended it, but perhaps the one before
            if (!pools) break;
            return show_with_last();
        case EndFrames::kBaselines:
            if (!pools) break;
            return show(current(), {late_.data(), nullptr});
        case EndFrames::kEnvpool:
            if (!pools) break;
            return show(current(), current());
    }
    repeat(false);
}

void View::show(Frame early, Frame late) {
    if (as_it_is()) return show_in_colour(early, late);
    if (const AreaResize* resize = scaler_->by_rows(); resize && planes_ == 1) {
        show_changes(early, late, *resize);
    } else {
        const size_t rows = static_cast<size_t>(planes_ * environment_.height());
        auto* const pooled = working_memory<uint8_t>(rows * kScreenWidth);
        auto* const changes = working_memory<uint32_t>(rows);
        pool_all(early, late, pooled, changes);
        push(pooled, changes);
    }
    if (pools_again_) remember(early, late);
}

// All planes of a picture, with what changes from row to row.
void View::pool_all(Frame early, Frame late, uint8_t* out, uint32_t* changes) const {
    const int height = environment_.height();
    for (int plane = 0; plane < planes_; ++plane, out += plane_size(), changes += height)
        pool_plane(early, late, plane, 0, height, out, changes);
}

// What the last picture was made of, in place of what the one before was.
void View::remember(Frame early, Frame late) {
    last_[0] = early.picture;
    last_[1] = late.picture;
    if (early.picture >= 0) return environment_.console().pictures().hold();
    pooled_.resize(pooled_size());
    pool_all(early, late, pooled_.data(), working_memory<uint32_t>(pooled_size() / kScreenWidth));
}

// Before the pictures that the next one is made of are drawn.
void View::forget_last() {
    environment_.console().pictures().let_go();
    last_[0] = last_[1] = -1;
    release(pooled_);
}

// The last picture before it was made small.
void View::pool_last(uint8_t* out) const {
    if (!pooled_.empty()) {
        std::copy(pooled_.begin(), pooled_.end(), out);
    } else if (last_[0] < 0) {  // there is none
        std::fill_n(out, pooled_size(), uint8_t{0});
    } else {
        const Pictures& pictures = environment_.console().pictures();
        auto* const changes = working_memory<uint32_t>(pooled_size() / kScreenWidth);
        pool_all({pictures.held(last_[0]), nullptr}, {pictures.held(last_[1]), nullptr}, out, changes);
    }
}

// Which rows are not made of what they were made of in the last small picture, or not known to be.
void View::note_changes(Frame early, Frame late, uint8_t* changed) {
    static constexpr uint32_t kUnknown[kFrameRows] = {};
    const auto height = static_cast<size_t>(environment_.height());
    for (std::vector<uint32_t>& looks : looks_) looks.resize(height);
    const uint32_t* const first = early.looks ? early.looks : kUnknown;
    const uint32_t* const second = late.looks ? late.looks : kUnknown;
    uint32_t *const first_before = looks_[0].data(), *const second_before = looks_[1].data();
    for (size_t row = 0; row < height; ++row) {  // without a branch: the compiler makes vectors of this
        const bool same = (first[row] == first_before[row]) & (second[row] == second_before[row]);
        changed[row] = !(same & (first[row] != 0) & (second[row] != 0));
    }
    std::copy_n(first, height, first_before);
    std::copy_n(second, height, second_before);
}

// Rows that are made of what they were made of in the last small picture are copied from there.
// (tests/vector/test_equals_ale_py.py and test_presets.py compare every byte)
void View::show_changes(Frame early, Frame late, const AreaResize& resize) {
    const int height = environment_.height(), results = settings_.height;
    auto* const changed = working_memory<uint8_t>(static_cast<size_t>(height) + plane_size());
    uint8_t* const pooled = changed + height;
    auto* const changes = working_memory<uint32_t>(static_cast<size_t>(height));
    note_changes(early, late, changed);
    const auto width = static_cast<size_t>(settings_.width);
    const auto is_new = [&](int result) {
        const auto [first, last] = resize.sources(result);
        return std::find(changed + first, changed + last + 1, uint8_t{1}) != changed + last + 1;
    };
    const uint8_t* const before = ring_.data() + picture_size_ * static_cast<size_t>(newest_);
    uint8_t* const place = next_place();
    for (int first = 0, end; first < results; first = end) {
        const bool make = is_new(first);
        for (end = first + 1; end < results && is_new(end) == make;) ++end;
        if (make) {
            const int from = resize.sources(first).first, count = resize.sources(end - 1).last + 1 - from;
            pool_plane(early, late, 0, from, count, pooled, changes);
            resize.make_rows(pooled, changes, place, first, end);
        } else if (place != before) {
            const size_t offset = width * static_cast<size_t>(first), size = width * static_cast<size_t>(end - first);
            std::memcpy(place + offset, before + offset, size);
        }
    }
}

// Rows first .. first+count-1 of a plane, in their places of `out` and `changes`.
void View::pool_plane(Frame early, Frame late, int plane, int first, int count, uint8_t* out, uint32_t* changes) const {
    const auto offset = kScreenWidth * first;
    const auto pooling = [&](auto function) {
        function(early.pixels + offset, late.pixels + offset, count, tables_[plane], out + offset, changes + first);
    };
    if (settings_.pixels == Pixels::kGrayOfRgb) pooling([](auto... arguments) { pool_pairs(arguments...); });
    else pooling([](auto... arguments) { pool_gray(arguments...); });
}

void View::show_in_colour(Frame early, Frame late) {
    uint8_t* const place = next_place();
    to_rgb(late.pixels, environment_.height(), *environment_.game()->palette, place);
    if (early.pixels != late.pixels) pool_colours(early, place);
}

// The brighter of a frame and of the colours that are there.
void View::pool_colours(Frame frame, uint8_t* colours) const {
    const size_t size = picture_size_;
    auto* const others = working_memory<uint8_t>(size);
    to_rgb(frame.pixels, environment_.height(), *environment_.game()->palette, others);
    for (size_t i = 0; i < size; ++i) colours[i] = std::max(colours[i], others[i]);
}

// The skip's last frame but one, pooled with the last picture.
void View::show_with_last() {
    if (as_it_is()) {
        repeat(false);
        return pool_colours(early(), ring_.data() + picture_size_ * static_cast<size_t>(newest_));
    }
    const Frame frame = early();
    std::vector<uint8_t> pooled(pooled_size());
    pool_last(pooled.data());
    auto* const others = working_memory<uint8_t>(pooled.size());
    pool_all(frame, frame, others, working_memory<uint32_t>(pooled.size() / kScreenWidth));
    for (size_t i = 0; i < pooled.size(); ++i) pooled[i] = std::max(pooled[i], others[i]);
    push(pooled.data(), nullptr);
    forget_last();
    pooled_ = std::move(pooled);
    forget_looks();
}

uint8_t* View::next_place() {
    newest_ = (newest_ + 1) % settings_.stack;
    return ring_.data() + picture_size_ * static_cast<size_t>(newest_);
}

// `changes` are those of each row of each plane; null if they are not known.
void View::push(const uint8_t* pooled, const uint32_t* changes) {
    uint8_t* const place = next_place();
    if (planes_ == 1) return (*scaler_)(pooled, changes, place);
    const size_t count = picture_size_ / 3;
    std::vector<uint8_t> small(count);
    for (int k = 0; k < 3; ++k, pooled += plane_size()) {
        (*scaler_)(pooled, changes ? changes + environment_.height() * k : nullptr, small.data());
        for (size_t i = 0; i < count; ++i) place[3 * i + static_cast<size_t>(k)] = small[i];
    }
}

void View::write(uint8_t* out) const {
    const size_t oldest = picture_size_ * static_cast<size_t>((newest_ + 1) % settings_.stack);
    std::memcpy(out, ring_.data() + oldest, ring_.size() - oldest);
    std::memcpy(out + (ring_.size() - oldest), ring_.data(), oldest);
}

size_t View::state_size() const { return pooled_size() + late_.size() + ring_.size() + sizeof newest_; }

uint8_t* View::save(uint8_t* out) const {
    if (pools_again_) pool_last(out);
    out += pooled_size();
    for (const std::vector<uint8_t>* part : {&late_, &ring_}) out = std::copy(part->begin(), part->end(), out);
    std::memcpy(out, &newest_, sizeof newest_);
    return out + sizeof newest_;
}

const uint8_t* View::load(const uint8_t* in) {
    forget_last();
    pooled_.assign(in, in + pooled_size());
    in += pooled_size();
    for (std::vector<uint8_t>* part : {&late_, &ring_}) {
        std::copy_n(in, part->size(), part->begin());
        in += part->size();
    }
    std::memcpy(&newest_, in, sizeof newest_);
    newest_ = std::clamp(newest_, 0, settings_.stack - 1);
    forget_looks();
    return in + sizeof newest_;
}

}  // namespace atari
