// The TIA, run late: applies the writes of a log, one after the other, each at its own time.
//
// The same log can be run twice: once for what programs can see (collisions, positions), and, where a picture is wanted,
// once more from the state at the beginning of the frame, for the pixels. Between two changes nothing happens but line
// ends, so whole spans are handled at once. The plain TIA (tia.cpp, picture.cpp) is what this is tested against
// (tests/emulator/test_fast_equals_plain.py).
#pragma once

#include <cstdint>

#include "masks.hpp"
#include "paint.hpp"
#include "state.hpp"

namespace atari {

struct ConsoleConfig;

// A write to a register of the TIA, at the end of a CPU cycle of the frame. Motion registers are not kept: HMOVE brings
// what they hold along.
struct Write {
    uint32_t cycle;
    uint8_t reg;
    uint8_t value;     // under HMOVE: the motion of the ball
    uint16_t motions;  // under HMOVE: of the others, a nibble each, player 0 lowest
};

class Beam {
  public:
    enum Work : uint8_t { kCollisions, kPixels };
    // Among objects that are involved in a line: a missile or the ball is placed, which may depend on when HMOVE was.
    static constexpr unsigned kPlacing = 1u << 6;

    // `tia` is brought forward by the calls below.
    Beam(Tia& tia, const ConsoleConfig& config) : t_(tia), config_(config) {}

    // Begins where `tia` is. `latches` are those that collisions are made for, `pixels` is the picture.
    void begin(Work work, unsigned latches, uint8_t* pixels);

    // From now on collisions are made for these latches.
    void watch(unsigned latches) {
        watched_ = latches;
        find_open_pairs();
    }

    // Applies the writes. Collisions of everything before `collisions_from` are left out: they will be cleared.
    void apply(const Write* first, const Write* last, const Write* collisions_from);

    // Brings the picture and the collisions up to a clock, as an access at that clock does.
    void reach(int32_t clock);

    // Goes on to the end of a line at `line_end`, with the writes up to there. Returns what follows.
    const Write* draw_line(const Write* first, const Write* last, int32_t line_end);
    // Draws a whole line, at whose beginning drawing is, as the line above was drawn.
    void repeat_row();
    // Objects that show or are placed in the line drawn last, and kPlacing.
    unsigned involved() const { return involved_; }

    // The frame has ended: brings what follows from the rest of the state up to date.
    void finish();

  private:
    template <Work work>
    void apply_all(const Write* first, const Write* last, const Write* collisions_from);
    template <Work work>
    void apply_range(const Write* first, const Write* last);
    // `pending` is the clock at which the latest of the writes so far shows.
    template <Work work>
    void apply_one(Tia& t, const Write& write, int32_t& pending);
    template <Work work>
    void write_nusiz(unsigned player, uint8_t value, int32_t pending);
    template <Work work>
    void write_graphics(unsigned player, uint8_t value, int32_t pending);
    template <Work work>
    void write_playfield(uint32_t value, int32_t pending);
    template <Work work>
    void reset_player(unsigned player, int hpos, int32_t clock, int32_t& pending);
    template <Work work>
    void move_objects(const Write& write, uint32_t cycle_in_line, int32_t clock, int32_t pending);
    template <Work work>
    void advance(int32_t pending);
    template <Work work>
    void go_to(int32_t target);
    template <Work work>
    void line_part(int32_t line_end, int32_t until);
    void begin_line();
    void end_line();
    int32_t line_end() const;
    bool blank_is_over() const;

    void enable(unsigned object, bool on) {
        const unsigned bit = 1u << object, now = on ? enabled_ | bit : enabled_ & ~bit;
        if (now == enabled_) return;
        enabled_ = now;
        involved_ |= now;
        layers_known_ = false;
        find_open_pairs();
    }
    void outdate(unsigned objects) {
        stale_ |= objects;
        layers_known_ = false;
    }
    void line_end_matters() {
        line_end_acts_ = true;
        quiet_ = false;
    }
    void find_open_pairs();
    void show(unsigned player);
    void moved(unsigned object);
    const Mask& mask(int object);
    int width_of(unsigned object) const;
    template <typename Visit>
    void visit_copies(unsigned object, Visit&& visit) const;
    bool may_touch(unsigned a, unsigned b);
    unsigned possible_pairs();
    void collide(int first, int last);
    void draw(int first, int last);
    void make_layers();

    Tia& t_;
    const ConsoleConfig& config_;
    Work work_ = kCollisions;
    uint8_t* row_ = nullptr;     // while pixels are made: the row of the line that ends at
    int32_t line_end_ = 0;
    uint32_t first_cycle_ = 0;   // of line 0
    int32_t blanked_at_ = 0;     // how far drawing was at the last HMOVE
    unsigned enabled_ = 0;       // objects that can be seen at all, a bit each
    unsigned involved_ = 0;
    unsigned watched_ = 0xffff;  // collision latches that are wanted
    bool collecting_ = true;     // and wanted now
    bool line_end_acts_ = false; // the end of a line would change something
    bool quiet_ = false;         // nothing can collide, nor does a line's end act, until one of them changes

    // The pixels of each object, and the cells of the playfield; made when needed.
    unsigned stale_ = 0x3f;
    Mask masks_[6];
    bool layers_known_ = false;
    Layers layers_;              // what is painted, as long as nothing but colours changes
    bool cells_stale_ = true;
    uint64_t cells_;
    unsigned open_pairs_ = 0;    // of enabled objects, watched, and not latched yet
    // Pairs of objects that could collide where they are now, of those that have been looked at.
    unsigned touching_ = 0, unknown_ = 0xffff;
};

}  // namespace atari
