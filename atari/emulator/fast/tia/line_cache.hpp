// `LineCache`: renders write logs into framebuffers. Only lines that differ from the frame rendered last are rendered.
//
// A line depends on the TIA's state at its beginning and on the TIA writes during it. If both are equal to those of the
// frame rendered last, the line has the same pixels and the same end state, and is not rendered again. In most games
// this holds for more than half of all lines. Registers that take no part in the line may differ, such as the position
// or the colour of an object that does not show.
//
// tests/emulator/test_fast_equals_plain.py compares this with the reference TIA, which renders every line.
#pragma once

#include <cstdint>
#include <vector>

#include "deferred_renderer.hpp"
#include "frame_log.hpp"
#include "machine/framebuffers.hpp"
#include "line_difference.hpp"
#include "machine/state.hpp"

namespace atari {

class LineCache {
  public:
    explicit LineCache(const ConsoleConfig& config) : config_(config) {}

    // Renders a frame into framebuffer 0 or 1. Rows that it already holds are kept, and rows that the other framebuffer
    // holds are copied. The log of the frame rendered before must stay valid.
    void draw(const FrameLog& log, Framebuffers& framebuffers, int buffer);

    // The log of the frame rendered last, or null.
    const TiaWrite* log() const { return known_ > 0 ? log_ : nullptr; }

    // Discards the cache, because the framebuffers have other contents.
    void forget();

    // The look of each row of framebuffer 0 or 1, as a number: rows of equal numbers are equal. 0 means unknown.
    const uint32_t* looks(int buffer) const { return shown_[buffer]; }

  private:
    // A frame that is being rendered.
    struct Drawing {
        Tia tia;
        DeferredRenderer beam;
        uint8_t* const pixels;  // the framebuffer to render into
        const uint8_t* const other_pixels;
        const int buffer;
        const TiaWrite *const log, *const end;
        const TiaWrite* next;  // first TIA write that has not been applied
        int line = 0;
        bool live = true;  // if false, `tia` is that of the previous frame, without `difference`
        Difference difference{};
        // Lines that were compared although they begin with other colours, and lines that were then skipped.
        int compared = 0, skipped = 0;
        // The log has the previous frame's TIA writes up to `agreed`, `moved` entries further on. All of them in lines
        // before `agreed_lines` agree.
        int agreed = -1, moved = 0, agreed_lines = 0;
    };

    int32_t line_clock(int line) const { return frame_start_ + kClocksPerLine * line; }
    bool begins_alike(Drawing& d) const;
    void find_agreement(Drawing& d, int lines) const;
    bool skip_lines(Drawing& d, int lines);
    int first_not_shown(const Drawing& d, int line, int end);
    void carry(const Drawing& d, int first, int last);
    void begin_line(Drawing& d);
    void draw_line(Drawing& d);
    bool repeats_line_above(const Drawing& d) const;
    void draw_straight(const FrameLog& log, uint8_t* pixels);

    const ConsoleConfig& config_;

    // If few lines repeat in two successive frames, the search costs more than it saves. This many frames are then
    // rendered without it.
    static constexpr int kStraight = 15;
    int straight_ = 0;
    bool repeated_ = true;
    // The same for lines that begin with other colours: for this many frames, colours must agree.
    int same_colours_ = 0;
    bool colours_repeated_ = true;

    // Number of lines of the frame rendered last. During rendering: of the current frame, up to the current line.
    int known_ = 0;
    int32_t frame_start_ = 0;
    const TiaWrite* log_ = nullptr;
    uint16_t first_[kMostLines + 1];  // first TIA write of each line
    // Objects that show or are placed, kPlacing, and colours that are painted or written.
    uint16_t involved_[kMostLines];
    std::vector<TiaCommon> beginnings_;  // by line, and one for the end of the last line
    std::vector<TiaPlaces> places_;

    // The look of each line, as a number that no earlier look of this line had. Also the looks of the framebuffers'
    // rows, 0 if unknown.
    uint32_t frame_ = 0;
    uint32_t looks_[kMostLines];
    uint32_t shown_[2][kFrameRows] = {};
};

}  // namespace atari
