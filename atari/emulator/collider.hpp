// Collisions, from the log of a frame's writes: brings the TIA forward as the beam would, but makes no pixels.
//
// Most writes cannot matter to collisions: they are to objects that are nowhere near another one, or whose collisions
// nobody reads or have been latched already. Such writes are only noted, the latest of each register, and applied when
// their object could collide after all. Which registers act is chosen again whenever an object moves, grows, or appears.
// The plain TIA (tia.cpp, picture.cpp) is what this is tested against (tests/emulator/test_fast_equals_plain.py).
#pragma once

#include <cstdint>

#include "masks.hpp"
#include "state.hpp"
#include "write_log.hpp"

namespace atari {

struct ConsoleConfig;

class Collider {
  public:
    // `tia` is brought forward by the calls below.
    Collider(Tia& tia, const ConsoleConfig& config) : t_(tia), config_(config) {}

    // Begins a frame where `tia` is. `latches` are those that are wanted.
    void begin(unsigned latches);

    // From now on collisions are made for these latches.
    void watch(unsigned latches);

    // From now on collisions are made, or left out: they will be cleared. They can only be made again from a CXCLR on, or
    // from the frame's beginning: before that the beam is not where the objects are.
    void collect(bool on);

    // Applies the writes, but those of colours and priorities, which do not matter here. What `tia` holds of the objects'
    // looks is not up to date before `finish`.
    void apply(const Write* first, const Write* last);

    // Brings the collisions up to a clock, as an access at that clock does.
    void reach(int32_t clock) { advance(clock); }

    // How many writes of this frame have acted, which is what takes time.
    int acted() const { return acted_; }

    // The frame has ended: brings the rest of the state up to date.
    void finish();

    // What the TIA is at a clock up to which all writes have been applied, without priorities.
    TiaLine state_at(int32_t clock);

    // The clock of the last HMOVE that blanks.
    int32_t blanked_at() const { return blanked_at_; }

    // Goes on from another state of this frame.
    void go_on_from(const TiaLine& state, uint16_t collisions, int32_t blanked_at);

  private:
    using Registers = uint64_t;  // a set of them, a bit each

    void look_around();
    void apply_one(const Write& write);
    void apply_noted(const Write& write);
    void set_graphics(unsigned player, const Write& write);
    void set_enam(unsigned missile, uint8_t value);
    void set_enabl(uint8_t value);
    void bring_up(Registers registers) {
        if (noted_ & registers) apply_all_noted(noted_ & registers);
    }
    void apply_all_noted(Registers due);

    // --- single registers; `clock` is that of the write, `hpos` of its place in the line ---
    void write_nusiz(unsigned player, uint8_t value, int32_t clock);
    void write_ctrlpf(uint8_t value, uint32_t cycle_in_line, int32_t clock);
    void write_graphics(unsigned player, const Write& write, int32_t clock);
    void write_playfield(const Write& write, int32_t shown);
    void reset_player(unsigned player, int hpos, int32_t clock);
    void move_objects(const Write& write, int32_t clock);
    void release_missile(unsigned missile, uint8_t value, int32_t clock);
    void end_tricks(int32_t clock);
    void blank(int32_t clock);
    bool blank_is_over(int32_t drawn_to) const;

    // --- how far the beam is ---
    void advance(int32_t shown) {
        if (t_.pending < shown) t_.pending = shown;
        if (!idle_) catch_up();
    }
    void catch_up();
    void skip_to_pending();
    void go_to(int32_t target);
    void end_line();

    // --- what could collide ---
    void enable(unsigned object, bool on) {
        if ((enabled_ >> object & 1) != static_cast<unsigned>(on)) toggle(object);
    }
    void toggle(unsigned object);
    // The graphics of a player that show may have changed.
    void show(unsigned player) {
        enable(player, t_.vdelp[player] ? t_.old_grp[player] : t_.grp[player]);
        outdate(player);
    }
    void moved(unsigned objects);
    void outdate(unsigned object) { stale_ |= 1u << object; }
    void find_open_pairs();
    void reconsider();
    void find_possible();
    void choose_acting();
    bool may_touch(unsigned a, unsigned b);
    uint32_t playfield_near(unsigned object);
    const Mask& mask(unsigned object);
    int width_of(unsigned object) const;
    template <typename Visit>
    void visit_copies(unsigned object, Visit&& visit) const;
    void collide(int first, int last);

    Tia& t_;
    const ConsoleConfig& config_;
    uint32_t first_cycle_ = 0;     // of line 0
    int32_t from_ = 0;             // where the beam was at the beginning
    int32_t blanked_at_ = 0;       // and at the last HMOVE that blanks
    bool line_end_acts_ = true;    // the end of a line would change something
    bool collecting_ = true;       // collisions are wanted now

    unsigned watched_ = 0xffff;    // collision latches that are wanted
    unsigned enabled_ = 0;         // objects that can be seen at all, a bit each
    unsigned wanted_ = 0xffff;     // and not latched yet
    unsigned open_pairs_ = 0;      // of these, those of enabled objects
    // Pairs of objects that could collide where they are now, of those that have been looked at.
    unsigned touching_ = 0, unknown_ = 0xffff;

    bool known_ = false;           // `possible_` is
    unsigned possible_ = 0;        // open pairs that touch
    bool idle_ = false;            // nothing can collide, nor does a line's end act: the beam is at `pending`

    bool chosen_ = false;          // `acting_` is; until then all registers act
    Registers acting_ = ~0ull;
    uint32_t acting_playfield_ = 0;  // bits of the playfield near to objects
    int acted_ = 0;
    Registers noted_ = 0;
    const Write* latest_[64];      // of the registers noted

    // Made when needed: the pixels of each object, and the bits of the playfield it could collide with.
    unsigned stale_ = 0x3f;
    Mask masks_[6];
    unsigned near_known_ = 0;
    uint32_t near_[5];
};

}  // namespace atari
