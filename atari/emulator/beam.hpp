// The TIA, run late: applies the writes of a log, one after the other, each at its own time.
//
// The same log can be run twice: once for what programs can see (collisions, positions), and, where a picture is wanted,
// once more from the state at the beginning of the frame, for the pixels. Between two writes nothing changes, so whole
// spans of lines are handled at once. The plain TIA (tia.cpp, picture.cpp) is what this is tested against.
#pragma once

#include <cstdint>

#include "masks.hpp"
#include "state.hpp"

namespace atari {

struct ConsoleConfig;

// A write to a register of the TIA, at the end of a CPU cycle of the frame.
struct Write {
    uint32_t cycle;
    uint8_t reg, value;
    uint16_t unused;
};

class Beam {
  public:
    // `tia` is brought forward by the calls below; `pixels` is the picture, or null if only the state matters.
    Beam(Tia& tia, const ConsoleConfig& config, uint8_t* pixels);

    // To be called when the state has been changed from outside, or is at the beginning of a frame.
    void begin();

    // Applies the writes. Collisions of everything before `collisions_from` are left out: they will be cleared.
    void apply(const Write* first, const Write* last, const Write* collisions_from);

    // Brings the picture and the collisions up to a clock, as an access at that clock does.
    void reach(int32_t clock);

    // Writes what is kept in another form back to the state.
    void finish();

  private:
    template <bool drawing>
    void apply_all(const Write* first, const Write* last, const Write* collisions_from);
    template <bool drawing>
    void apply_one(const Write& write);
    template <bool drawing>
    void advance();
    template <bool drawing>
    void line_part(int32_t until);
    template <bool drawing, typename T, typename V>
    void change(T& field, V value, unsigned objects);
    template <bool drawing>
    void write_nusiz(int player, uint8_t value);
    template <bool drawing>
    void write_graphics(int player, uint8_t value);
    template <bool drawing>
    void reset_player(int player, int hpos, int32_t clock);
    template <bool drawing>
    void move_objects(int cycle_in_line, int32_t clock);
    void end_line();
    unsigned enabled();
    const Mask& mask(int object);
    uint8_t* row_at(int32_t line_end) const;
    void collide(int first, int last);
    void draw(int first, int last);
    void touch(unsigned objects) {
        stale_ |= objects;
        enabled_known_ = false;
    }

    Tia& t_;
    const ConsoleConfig& config_;
    uint8_t* const pixels_;
    uint32_t first_cycle_ = 0;  // of line 0
    int32_t line_end_ = 0;      // clock at which the line that is being drawn ends
    bool collecting_ = true;    // collisions are wanted
    bool enabled_known_ = false;
    unsigned enabled_ = 0;
    unsigned stale_ = 0x3f;     // masks that are out of date
    Mask masks_[6];
};

}  // namespace atari
