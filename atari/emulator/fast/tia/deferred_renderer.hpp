// Deferred rendering: applies the TIA writes of a log to a TIA, each at its own time, and renders the pixels.
//
// The collider (collider.hpp) has already found collisions and positions while the frame was run. When a framebuffer is
// needed, the renderer runs the log again from the state at the beginning of the frame. Between two changes only line
// ends have an effect, so whole spans are rendered at once.
//
// tests/emulator/test_fast_equals_plain.py compares this with the reference TIA (machine/tia/).
#pragma once

#include <cstdint>

#include "line_difference.hpp"
#include "machine/tia/masks.hpp"
#include "paint.hpp"
#include "machine/state.hpp"
#include "write_log.hpp"

namespace atari {

struct ConsoleConfig;

class DeferredRenderer {
  public:
    // The calls below advance `tia`.
    DeferredRenderer(Tia& tia, const ConsoleConfig& config) : t_(tia), config_(config) {}

    // Begins at the state of `tia`, with output to the framebuffer at `pixels`.
    void begin(uint8_t* pixels);

    // Applies TIA writes, rendering up to each of them.
    void apply(const TiaWrite* first, const TiaWrite* last);

    // Renders up to a clock, as an access at that clock does.
    void reach(int32_t clock);

    // Renders to the end of a line at `line_end`, with the TIA writes up to there. Returns the first write after them.
    const TiaWrite* draw_line(const TiaWrite* first, const TiaWrite* last, int32_t line_end);
    // Renders a whole line as a copy of the line above. The beam must be at the line's beginning.
    void repeat_row();
    // Objects that show or are placed in the line that `draw_line` rendered last, kPlacing, and colours that are painted
    // or written in it.
    unsigned involved() const;

  private:
    // `pending` is the clock at which the latest of the TIA writes so far shows.
    void apply_one(Tia& t, const TiaWrite& write, int32_t& pending);
    void write_nusiz(unsigned player, uint8_t value, int32_t pending);
    void write_graphics(unsigned player, uint8_t value, int32_t pending);
    void write_playfield(uint32_t value, int32_t pending);
    void reset_player(unsigned player, int hpos, int32_t clock, int32_t& pending);
    void move_objects(const TiaWrite& write, uint32_t cycle_in_line, int32_t clock, int32_t pending);
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
    uint8_t* row_ = nullptr;  // row of the line that ends at `line_end_`
    int32_t line_end_ = 0;
    uint32_t first_cycle_ = 0;  // first cycle of line 0
    unsigned enabled_ = 0;      // objects that are visible at all, a bit each
    unsigned involved_ = 0;
    bool line_end_acts_ = false;  // the end of a line would change the state

    // The pixels of each object, computed when needed.
    unsigned stale_ = kAllObjects;
    Mask masks_[6];
    bool layers_known_ = false;
    Layers layers_;  // the pixel sets to paint; valid while only colours change
};

}  // namespace atari
