// The TIA, run late, for its picture: applies the writes of a log, one after the other, each at its own time.
//
// What programs can see, collisions and positions, has been found by the collider (collider.hpp) while the frame was run.
// Where a picture is wanted the log is run once more, from the state at the beginning of the frame. Between two changes
// nothing happens but line ends, so whole spans are drawn at once. The plain TIA (tia.cpp, picture.cpp) is what this is
// tested against (tests/emulator/test_fast_equals_plain.py).
#pragma once

#include <cstdint>

#include "line_difference.hpp"
#include "masks.hpp"
#include "paint.hpp"
#include "state.hpp"
#include "write_log.hpp"

namespace atari {

struct ConsoleConfig;

class Beam {
  public:
    // `tia` is brought forward by the calls below.
    Beam(Tia& tia, const ConsoleConfig& config) : t_(tia), config_(config) {}

    // Begins where `tia` is, in a picture.
    void begin(uint8_t* pixels);

    // Applies the writes.
    void apply(const Write* first, const Write* last);

    // Brings the picture up to a clock, as an access at that clock does.
    void reach(int32_t clock);

    // Goes on to the end of a line at `line_end`, with the writes up to there. Returns what follows.
    const Write* draw_line(const Write* first, const Write* last, int32_t line_end);
    // Draws a whole line, at whose beginning drawing is, as the line above was drawn.
    void repeat_row();
    // Objects that show or are placed in the line drawn last, and kPlacing.
    unsigned involved() const { return involved_; }

  private:
    // `pending` is the clock at which the latest of the writes so far shows.
    void apply_one(Tia& t, const Write& write, int32_t& pending);
    void write_nusiz(unsigned player, uint8_t value, int32_t pending);
    void write_graphics(unsigned player, uint8_t value, int32_t pending);
    void write_playfield(uint32_t value, int32_t pending);
    void reset_player(unsigned player, int hpos, int32_t clock, int32_t& pending);
    void move_objects(const Write& write, uint32_t cycle_in_line, int32_t clock, int32_t pending);
    void advance(int32_t pending);
    void go_to(int32_t target);
    void line_part(int32_t until);
    void begin_line();
    void end_line();

    void enable(unsigned object, bool on) {
        const unsigned bit = 1u << object, now = on ? enabled_ | bit : enabled_ & ~bit;
        if (now == enabled_) return;
        enabled_ = now;
        involved_ |= now;
        layers_known_ = false;
    }
    void outdate(unsigned objects) {
        stale_ |= objects;
        layers_known_ = false;
    }
    void show(unsigned player);
    void draw(int first, int last);
    void make_layers();

    Tia& t_;
    const ConsoleConfig& config_;
    uint8_t* row_ = nullptr;      // of the line that ends at
    int32_t line_end_ = 0;
    uint32_t first_cycle_ = 0;    // of line 0
    unsigned enabled_ = 0;        // objects that can be seen at all, a bit each
    unsigned involved_ = 0;
    bool line_end_acts_ = false;  // the end of a line would change something

    // The pixels of each object, made when needed.
    unsigned stale_ = 0x3f;
    Mask masks_[6];
    bool layers_known_ = false;
    Layers layers_;              // what is painted, as long as nothing but colours changes
};

}  // namespace atari
