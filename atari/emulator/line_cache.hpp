// Pictures, drawn from logs: only what differs from the picture drawn last.
//
// A line is what the TIA was at its beginning and what is written to it meanwhile. If both are as in the frame drawn
// last, then the line looks the same and leaves the same behind, and is not drawn again: in most games that holds for
// more than half of all lines. What a register holds that takes no part in the line, such as the place of an object that
// does not show, may differ.
//
// tests/emulator/test_fast_equals_plain.py compares with the plain TIA, which draws everything.
#pragma once

#include <cstdint>
#include <vector>

#include "beam.hpp"
#include "line_difference.hpp"
#include "pictures.hpp"
#include "state.hpp"

namespace atari {

struct FrameLog;

class LineCache {
  public:
    explicit LineCache(const ConsoleConfig& config) : config_(config) {}

    // Draws a frame into picture 0 or 1. Rows that it shows already are left alone, rows that the other one shows are
    // copied from there. The log of the frame that was drawn before must still be there.
    void draw(const FrameLog& log, Pictures& pictures, int picture);

    // The log of the frame drawn last, or null.
    const Write* log() const { return known_ > 0 ? log_ : nullptr; }

    // The pictures are not what has been drawn here.
    void forget();

    // How the rows of picture 0 or 1 look, a number each: rows of equal numbers are equal. 0 where that is not known.
    const uint32_t* looks(int picture) const { return shown_[picture]; }

  private:
    // A frame ends with its first write to the TIA behind line 342.
    static constexpr int kMostLines = 344;

    // A frame that is being drawn.
    struct Drawing {
        Tia tia;
        Beam beam;
        uint8_t* const pixels;  // of the picture that is drawn
        const uint8_t* const other_pixels;
        const int picture;
        const Write *const log, *const end;
        const Write* next;       // that has not been applied
        int line = 0;
        bool live = true;        // `tia` is up to date; otherwise it is what it was in the frame before, but for the
        Difference difference{};
        // Writes up to `agreed` of the frame before are those of this one, `moved` further on, and all that come in lines
        // before `agreed_lines`.
        int agreed = -1, moved = 0, agreed_lines = 0;
    };

    int32_t line_clock(int line) const { return frame_start_ + 228 * line; }
    bool begins_alike(Drawing& d) const;
    void find_agreement(Drawing& d, int lines) const;
    bool skip_lines(Drawing& d, int lines);
    int first_not_shown(const Drawing& d, int line, int end);
    void begin_line(Drawing& d);
    void draw_line(Drawing& d);
    bool repeats_line_above(const Drawing& d) const;
    void draw_straight(const FrameLog& log, uint8_t* pixels);

    const ConsoleConfig& config_;

    // Where few lines repeat in two frames running, looking for them costs more than it saves: so many are drawn without.
    static constexpr int kStraight = 15;
    int straight_ = 0;
    bool repeated_ = true;

    // The lines of the frame drawn last; while one is drawn, of that one up to where drawing is.
    int known_ = 0;
    int32_t frame_start_ = 0;
    const Write* log_ = nullptr;
    uint16_t first_[kMostLines + 1];  // write of each line
    uint8_t involved_[kMostLines];    // objects that show or are placed, and kPlacing
    std::vector<TiaCommon> beginnings_;  // of as many as are drawn, and of the one behind
    std::vector<TiaPlaces> places_;

    // How a line looks, as a number that no other look of this line had; and how the rows of the pictures look, 0 where
    // that is not known.
    uint32_t frame_ = 0;
    uint32_t looks_[kMostLines];
    uint32_t shown_[2][kFrameRows] = {};
};

}  // namespace atari
