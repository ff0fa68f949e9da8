#include "line_cache.hpp"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <utility>

#include "console.hpp"

namespace atari {
namespace {

// What must not differ stands in front of a TiaLine. Of this, clocks come first.
constexpr size_t kStrict = offsetof(TiaLine, pos);
constexpr size_t kClocks = offsetof(TiaLine, playfield);

// How many writes agree, of `count`.
int agreeing(const Write* a, const Write* b, int count) {
    constexpr int kAtOnce = 4;
    const auto agree = [&](int i, int n) { return std::memcmp(a + i, b + i, static_cast<size_t>(n) * sizeof *a) == 0; };
    int i = 0;
    while (i <= count - kAtOnce && agree(i, kAtOnce)) i += kAtOnce;
    while (i < count && agree(i, 1)) ++i;
    return i;
}

}  // namespace

void LineCache::forget() {
    known_ = 0;
    for (auto& rows : shown_) std::fill(std::begin(rows), std::end(rows), 0u);
}

void LineCache::draw(const FrameLog& log, Pictures& pictures, int picture) {
    uint8_t* const pixels = pictures.use(picture, config_.picture_bytes());
    if (straight_ > 0) return draw_straight(log, pixels);
    if (++frame_ == 0) {
        forget();
        frame_ = 1;
    }
    const bool comparable = known_ > 0;
    if (log.start.frame_start != frame_start_) known_ = 0;  // clocks are counted from elsewhere
    frame_start_ = log.start.frame_start;
    Drawing d{log.start, {d.tia, config_}, pixels, pictures[picture ^ 1], picture, log.writes, log.writes + log.size, log.writes};
    d.beam.begin(pixels);

    const int behind_picture = config_.first_line + config_.height;
    const int lines = std::min({(log.reached - frame_start_) / 228, behind_picture, kMostLines});
    int drawn = 0;
    while (true) {
        const bool alike = begins_alike(d) && skip_lines(d, lines);
        if (d.line == lines) break;
        if (!alike) looks_[d.line] = frame_;
        draw_line(d);
        ++drawn;
    }
    begin_line(d);
    if (lines < behind_picture) {
        // The frame ends in this line. What its row shows behind that is older.
        if (const int row = lines - config_.first_line; row >= 0) shown_[picture][row] = 0;
        d.beam.apply(d.next, d.end);
        d.beam.reach(log.reached);
    }
    known_ = lines;
    log_ = log.writes;
    if (comparable && 4 * drawn > 3 * lines) straight_ = kStraight;
}

void LineCache::draw_straight(const FrameLog& log, uint8_t* pixels) {
    if (--straight_ == kStraight - 1) forget();
    Tia tia = log.start;
    Beam beam(tia, config_);
    beam.begin(pixels);
    beam.apply(log.writes, log.writes + log.size);
    beam.reach(log.reached);
}

bool LineCache::begins_alike(Drawing& d) const {
    if (d.line >= known_) return false;
    if (d.live) {
        const TiaLine &now = d.tia, &before = beginnings_[d.line];
        if (std::memcmp(&now, &before, kStrict) != 0) return false;
        d.difference = difference(now, before);
    }
    return !(d.difference.objects & involved_[d.line]);
}

// Skips lines with the writes that they had before, as long as they are shown. Returns whether the line that is reached
// has its writes, too, and only has to be drawn.
bool LineCache::skip_lines(Drawing& d, int lines) {
    const int until = std::min(lines, known_), place = first_[d.line], moved = static_cast<int>(d.next - d.log) - place;
    const int comparable = std::min(static_cast<int>(d.end - d.next), first_[known_] - place);
    const int agreed = place + agreeing(d.next, log_ + place, comparable);
    const Difference difference = d.difference;
    bool has_to_be_drawn = false;
    int line = d.line;
    for (int behind = place; line < until; ++line) {
        const int begins = std::exchange(behind, first_[line + 1]);
        if (behind > agreed || (difference.objects & involved_[line])) break;
        const Write* const next = d.log + behind + moved;
        if (behind == agreed && next != d.end && static_cast<int32_t>(3 * next->cycle) < line_clock(line + 1)) break;
        has_to_be_drawn = !shows(d, line);
        if (has_to_be_drawn) break;
        if (difference.objects) carry(difference, beginnings_[line]);
        first_[line] = static_cast<uint16_t>(begins + moved);
    }
    if (line == d.line) return has_to_be_drawn;
    d.line = line;
    d.next = d.log + first_[line] + moved;
    d.live = false;
    return has_to_be_drawn;
}

// Whether the picture shows the line as it looks; what the other one shows is copied.
bool LineCache::shows(const Drawing& d, int line) {
    const int row = line - config_.first_line;
    if (row < 0) return true;
    uint32_t& shown = shown_[d.picture][row];
    if (shown != looks_[line] && shown_[d.picture ^ 1][row] == looks_[line]) {
        const auto offset = kScreenWidth * row;
        std::memcpy(d.pixels + offset, d.other_pixels + offset, kScreenWidth);
        shown = looks_[line];
    }
    return shown == looks_[line];
}

void LineCache::begin_line(Drawing& d) {
    TiaLine& beginning = beginnings_[d.line];
    if (d.live) {
        beginning = d.tia;
    } else {
        if (d.difference.objects) carry(d.difference, beginning);
        static_cast<TiaLine&>(d.tia) = beginning;
        d.beam.begin(d.pixels);
        d.live = true;
    }
    first_[d.line] = static_cast<uint16_t>(d.next - d.log);
}

void LineCache::draw_line(Drawing& d) {
    begin_line(d);
    if (repeats_line_above(d)) d.beam.repeat_row();
    else d.next = d.beam.draw_line(d.next, d.end, line_clock(d.line + 1));
    involved_[d.line] = static_cast<uint8_t>(d.beam.involved());
    if (const int row = d.line - config_.first_line; row >= 0) shown_[d.picture][row] = looks_[d.line];
    ++d.line;
}

// Whether the line has no writes and begins as the line above, which had none either. What the end of a line does comes
// with the first clock of the next one, so both must begin at the same one; there is none in front of the first row, so
// it does not count.
bool LineCache::repeats_line_above(const Drawing& d) const {
    if (d.line <= config_.first_line + 1 || first_[d.line] != first_[d.line - 1]) return false;
    if (beginnings_[d.line].drawn_to != beginnings_[d.line - 1].drawn_to + 228) return false;
    if (d.next != d.end && static_cast<int32_t>(3 * d.next->cycle) < line_clock(d.line + 1)) return false;
    const auto* const now = reinterpret_cast<const char*>(&beginnings_[d.line]);
    return std::memcmp(now + kClocks, now - sizeof(TiaLine) + kClocks, sizeof(TiaLine) - kClocks) == 0;
}

LineCache::Difference LineCache::difference(const TiaLine& now, const TiaLine& before) {
    Difference d{};
    if (std::memcmp(before.pos, now.pos, sizeof now - kStrict) == 0) return d;
    for (unsigned object = kP0; object <= kBL; ++object) {
        const int by = now.pos[object] - before.pos[object];
        d.pos[object] = static_cast<uint8_t>(by < 0 ? by + kScreenWidth : by);
        if (by != 0) d.objects |= 1u << object;
    }
    for (unsigned player : {0u, 1u}) {
        d.refp[player] = before.refp[player].value ^ now.refp[player].value;
        if (d.refp[player]) d.objects |= 1u << (kP0 + player);
    }
    d.vdelbl = before.vdelbl.value ^ now.vdelbl.value;
    if (d.vdelbl) d.objects |= 1u << kBL;
    d.last_hmove = now.last_hmove;
    if (before.last_hmove != now.last_hmove) d.objects |= Beam::kPlacing;
    return d;
}

// Makes the beginning of a line that of this frame. Objects that take no part have been moved as before.
inline void LineCache::carry(const Difference& by, TiaLine& line) {
    for (int object = kP0; object <= kBL; ++object) {
        const int position = line.pos[object] + by.pos[object];
        line.pos[object] = static_cast<uint8_t>(position >= kScreenWidth ? position - kScreenWidth : position);
    }
    for (int player : {0, 1}) line.refp[player].value ^= by.refp[player];
    line.vdelbl.value ^= by.vdelbl;
    if (by.objects & Beam::kPlacing) line.last_hmove = by.last_hmove;
}

}  // namespace atari
