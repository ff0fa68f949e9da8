#include "line_cache.hpp"

#include <algorithm>
#include <cstring>

#include "machine/console_config.hpp"

namespace atari {
namespace {

// Returns whether one of the objects is involved in one of eight lines.
bool takes_part(unsigned objects, const uint16_t* involved) {
    uint64_t lines[2];
    std::memcpy(lines, involved, sizeof lines);
    return ((lines[0] | lines[1]) & 0x0001000100010001 * objects) != 0;
}

}  // namespace

void LineCache::forget() {
    known_ = 0;
    for (auto& rows : shown_) std::fill(std::begin(rows), std::end(rows), 0u);
}

void LineCache::draw(const FrameLog& log, Framebuffers& framebuffers, int buffer) {
    uint8_t* const pixels = framebuffers.use(buffer, config_.framebuffer_bytes());
    if (straight_ > 0) return draw_straight(log, pixels);
    if (++frame_ == 0) {
        forget();
        frame_ = 1;
    }
    const bool comparable = known_ > 0;
    if (log.start.frame_start != frame_start_) known_ = 0;  // clocks have another origin
    frame_start_ = log.start.frame_start;
    Drawing d{log.start,  {d.tia, config_},      pixels,    framebuffers[buffer ^ 1], buffer,
              log.writes, log.writes + log.size, log.writes};
    d.beam.begin(pixels);

    const int framebuffer_end = config_.first_line + config_.height;
    const int most_lines = std::min(framebuffer_end, kMostLines);
    const int lines = std::min((log.reached - frame_start_) / kClocksPerLine, most_lines);
    beginnings_.resize(static_cast<std::size_t>(most_lines) + 1);
    places_.resize(beginnings_.size());
    int drawn = 0;
    while (true) {
        const bool alike = begins_alike(d) && skip_lines(d, lines);
        if (d.line == lines) break;
        if (!alike) looks_[d.line] = frame_;
        draw_line(d);
        ++drawn;
    }
    begin_line(d);
    if (lines < framebuffer_end) {
        // The frame ends in this line. The rest of its row belongs to an older frame.
        if (const int row = lines - config_.first_line; row >= 0) shown_[buffer][row] = 0;
        d.beam.apply(d.next, d.end);
        d.beam.reach(log.reached);
    }
    known_ = lines;
    log_ = log.writes;
    const bool colours_repeat = 2 * d.skipped >= d.compared;
    if (same_colours_ > 0) --same_colours_;
    else if (!colours_repeat && !colours_repeated_) same_colours_ = kStraight;
    colours_repeated_ = colours_repeat;
    const bool repeats = !comparable || 4 * drawn <= 3 * lines;
    if (!repeats && !repeated_) straight_ = kStraight;
    repeated_ = repeats;
}

void LineCache::draw_straight(const FrameLog& log, uint8_t* pixels) {
    if (--straight_ == kStraight - 1) forget();
    Tia tia = log.start;
    DeferredRenderer beam(tia, config_);
    beam.begin(pixels);
    beam.apply(log.writes, log.writes + log.size);
    beam.reach(log.reached);
}

bool LineCache::begins_alike(Drawing& d) const {
    if (d.line >= known_) return false;
    if (d.live) {
        const TiaCommon& before = beginnings_[d.line];
        const uint32_t colours = colour_changes(d.tia, before);
        if (colours && (same_colours_ > 0 || (colours_in(colours) & involved_[d.line]))) return false;
        if (!agree_but_for_colours(d.tia, before)) return false;
        d.difference = difference(d.tia, places_[d.line]);
        if (colours) {
            ++d.compared;
            d.difference.objects |= colours_in(colours);
            d.difference.colours = colours;
        }
    }
    return !(d.difference.objects & involved_[d.line]);
}

// Finds how far the log agrees with the previous frame's log, and up to which line all TIA writes agree.
void LineCache::find_agreement(Drawing& d, int lines) const {
    const int place = first_[d.line], moved = static_cast<int>(d.next - d.log) - place;
    if (moved == d.moved && place <= d.agreed) return;  // already known
    const int comparable = std::min(static_cast<int>(d.end - d.next), first_[known_] - place);
    d.moved = moved;
    d.agreed = place + agreeing(d.next, log_ + place, comparable);
    int line = d.line;
    const int until = std::min(lines, known_);
    while (line + 8 <= until && first_[line + 8] <= d.agreed) line += 8;
    while (line < until && first_[line + 1] <= d.agreed) ++line;
    if (const TiaWrite* next = d.log + d.agreed + moved; next != d.end)
        while (line > d.line && first_[line] == d.agreed && static_cast<int32_t>(3 * next->cycle) < line_clock(line))
            --line;
    d.agreed_lines = line;
}

// Skips lines that have the previous frame's TIA writes and whose rows are already shown. Returns whether the writes of
// the line that is reached have also been applied, so that the line only has to be rendered.
bool LineCache::skip_lines(Drawing& d, int lines) {
    find_agreement(d, lines);
    const int same = std::max(d.line, d.agreed_lines);
    const unsigned differing = d.difference.objects;
    int alike = differing ? d.line : same;  // lines with the same look
    while (alike + 8 <= same && !takes_part(differing, involved_ + alike)) alike += 8;
    while (alike < same && !(differing & involved_[alike])) ++alike;

    const int line = first_not_shown(d, d.line, alike);
    if (line == d.line) return line < alike;
    carry(d, d.line, line);
    if (d.difference.colours) d.skipped += line - d.line;
    const int begins = first_[line];
    if (d.moved)
        for (int skipped = d.line; skipped < line; ++skipped)
            first_[skipped] = static_cast<uint16_t>(first_[skipped] + d.moved);
    d.line = line;
    d.next = d.log + begins + d.moved;
    d.live = false;
    return line < alike;
}

// Returns the first line from `line` on whose row the framebuffer does not hold, or `end`. Rows that the other
// framebuffer holds are copied.
int LineCache::first_not_shown(const Drawing& d, int line, int end) {
    if (end <= config_.first_line) return end;
    line = std::max(line, config_.first_line);
    uint32_t* const shown = shown_[d.buffer];
    const uint32_t* const shown_by_other = shown_[d.buffer ^ 1];
    int single = line;  // lines before this one are checked one by one
    for (; line < end; ++line) {
        int row = line - config_.first_line;
        while (line >= single && line + 8 <= end && agree<8 * sizeof *shown>(shown + row, looks_ + line)) {
            line += 8;
            row += 8;
        }
        if (line >= single) single = line + 8;
        if (line == end) break;
        if (shown[row] == looks_[line]) continue;
        if (shown_by_other[row] != looks_[line]) break;
        std::memcpy(d.pixels + kScreenWidth * row, d.other_pixels + kScreenWidth * row, kScreenWidth);
        shown[row] = looks_[line];
    }
    return line;
}

// Applies the difference to the beginnings of lines first .. last-1.
void LineCache::carry(const Drawing& d, int first, int last) {
    if (!d.difference.objects) return;
    atari::carry(d.difference, &places_[first], &places_[last]);
    if (d.difference.colours) carry_colours(d.difference.colours, &beginnings_[first], &beginnings_[last]);
}

void LineCache::begin_line(Drawing& d) {
    TiaCommon& beginning = beginnings_[d.line];
    TiaPlaces& places = places_[d.line];
    if (d.live) {
        beginning = d.tia;
        places = d.tia;
    } else {
        carry(d, d.line, d.line + 1);
        static_cast<TiaCommon&>(d.tia) = beginning;
        static_cast<TiaPlaces&>(d.tia) = places;
        d.beam.begin(d.pixels);
        d.live = true;
    }
    first_[d.line] = static_cast<uint16_t>(d.next - d.log);
}

void LineCache::draw_line(Drawing& d) {
    begin_line(d);
    const int row = d.line - config_.first_line;
    const uint32_t shown = row >= 0 && looks_[d.line] == frame_ ? shown_[d.buffer][row] : 0;
    const uint8_t* const pixels = d.pixels + kScreenWidth * std::max(row, 0);
    uint8_t before[kScreenWidth];
    if (shown) std::memcpy(before, pixels, sizeof before);
    if (repeats_line_above(d)) {
        d.beam.repeat_row();
        involved_[d.line] = involved_[d.line - 1];
    } else {
        d.next = d.beam.draw_line(d.next, d.end, line_clock(d.line + 1));
        involved_[d.line] = static_cast<uint16_t>(d.beam.involved());
    }
    // Many lines with other TIA writes have the same row as before. Results computed from such a row stay valid.
    if (shown && agree<sizeof before>(before, pixels)) looks_[d.line] = shown;
    if (row >= 0) shown_[d.buffer][row] = looks_[d.line];
    ++d.line;
    // A write at the line's end may show in the next line. If the next line begins with an HMOVE blank, part of its row
    // is already black.
    const bool reaches_on = d.tia.hmove_blank && d.tia.drawn_to > line_clock(d.line);
    if (reaches_on && row + 1 >= 0 && row + 1 < config_.height) shown_[d.buffer][row + 1] = 0;
}

// Returns whether the line has no TIA writes and begins in the same state as the line above, which had no writes
// either. The effects of a line's end come with the first clock of the next line, so both lines must begin at that
// clock. No line end comes before the first row, so it does not count.
bool LineCache::repeats_line_above(const Drawing& d) const {
    if (d.line <= config_.first_line + 1 || first_[d.line] != first_[d.line - 1]) return false;
    if (beginnings_[d.line].drawn_to != beginnings_[d.line - 1].drawn_to + kClocksPerLine) return false;
    if (d.next != d.end && static_cast<int32_t>(3 * d.next->cycle) < line_clock(d.line + 1)) return false;
    constexpr std::size_t kClocks = offsetof(TiaCommon, playfield);
    const auto after_clocks = [](const TiaCommon& line) { return reinterpret_cast<const char*>(&line) + kClocks; };
    const TiaCommon* const now = &beginnings_[d.line];
    return agree<sizeof *now - kClocks>(after_clocks(now[0]), after_clocks(now[-1])) &&
           agree<sizeof(TiaPlaces)>(&places_[d.line], &places_[d.line - 1]);
}

}  // namespace atari
