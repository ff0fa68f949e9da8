// Deferred collisions: `Collider` advances the TIA through a frame's write log and finds collisions, without pixels.
//
// Most TIA writes cannot affect collisions. Their objects are far from all others, or the latches are not watched or
// already set. Only the latest such write of each register is noted. It is applied when its object could collide. The
// registers that act are chosen again when an object moves, grows or appears.
//
// tests/emulator/test_fast_equals_plain.py compares this with the reference TIA (machine/tia/).
#pragma once

#include <cstdint>

#include "machine/tia/masks.hpp"
#include "machine/state.hpp"
#include "write_log.hpp"

namespace atari {

struct ConsoleConfig;

class Collider {
  public:
    // The calls below advance `tia`.
    Collider(Tia& tia, const ConsoleConfig& config) : t_(tia), config_(config) {}

    // Begins a frame at the state of `tia`, and finds collisions for `latches`.
    void begin(unsigned latches);

    // From now on collisions are found for these latches.
    void watch(unsigned latches);

    // Turns the search for collisions on or off. It may be off only where the latches will be cleared. It can be turned
    // on only at a CXCLR or at the frame's beginning, because until then the beam does not agree with the objects.
    void collect(bool on);

    // Applies TIA writes, except those of colours and priorities, which do not affect collisions. The looks of objects
    // in `tia` are not up to date until `finish`.
    void apply(const TiaWrite* first, const TiaWrite* last);

    // Finds collisions up to a clock, as an access at that clock does.
    void reach(int32_t clock) { advance(clock); }

    // The number of this frame's TIA writes that have acted. They take most of the time.
    int acted() const { return acted_; }

    // Ends the frame: brings the rest of the state up to date.
    void finish();

    // Returns the TIA's state, without priorities, at a clock up to which all TIA writes have been applied.
    TiaLine state_at(int32_t clock);

    // The clock of the last HMOVE that blanks.
    int32_t blanked_at() const { return blanked_at_; }

    // Resumes from another state of this frame.
    void go_on_from(const TiaLine& state, uint16_t collisions, int32_t blanked_at);

  private:
    using Registers = uint64_t;  // a set of registers, a bit each

    void derive_again();
    void apply_one(const TiaWrite& write);
    void apply_noted(const TiaWrite& write);
    unsigned changed_by_graphics(unsigned player, const TiaWrite& write) const;
    void set_graphics(unsigned player, const TiaWrite& write, unsigned changed);
    void set_enam(unsigned missile, uint8_t value);
    void set_enabl(uint8_t value);
    void bring_up(Registers registers) {
        if (noted_ & registers) apply_all_noted(noted_ & registers);
    }
    void apply_all_noted(Registers due);

    // --- single registers; `clock` is that of the write, `hpos` its position in the line ---
    void write_nusiz(unsigned player, uint8_t value, int32_t clock);
    void write_ctrlpf(uint8_t value, uint32_t cycle_in_line, int32_t clock);
    void write_graphics(unsigned player, const TiaWrite& write, int32_t clock);
    void write_playfield(const TiaWrite& write, int32_t shown);
    void reset_player(unsigned player, int hpos, int32_t clock);
    void move_objects(const TiaWrite& write, int32_t clock);
    void release_missile(unsigned missile, uint8_t value, int32_t clock);
    void end_tricks(int32_t clock);
    void blank(int32_t clock);
    bool blank_is_over(int32_t drawn_to) const;

    // --- the beam ---
    void advance(int32_t shown) {
        if (t_.pending < shown) t_.pending = shown;
        if (!idle_) catch_up();
    }
    void catch_up();
    void skip_to_pending();
    void go_to(int32_t target);
    void end_line();

    // --- objects that could collide ---
    void enable(unsigned object, bool on) {
        if ((enabled_ >> object & 1) != static_cast<unsigned>(on)) toggle(object);
    }
    void toggle(unsigned object);
    // The visible graphics of a player may have changed.
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
    uint32_t first_cycle_ = 0;   // first cycle of line 0
    int32_t from_ = 0;           // the beam at the frame's beginning
    int32_t blanked_at_ = 0;     // the beam at the last HMOVE that blanks
    bool line_end_acts_ = true;  // the end of a line would change the state
    bool collecting_ = true;     // collisions are being found

    unsigned watched_ = 0xffff;  // collision latches to find
    unsigned enabled_ = 0;       // objects that are visible at all, a bit each
    unsigned unset_ = 0xffff;    // watched latches that are not set yet
    unsigned open_pairs_ = 0;    // latches of `unset_` whose two objects are enabled
    // `touching_`: pairs of objects that could collide at their positions. `unknown_`: pairs not checked yet.
    unsigned touching_ = 0, unknown_ = 0xffff;

    bool known_ = false;     // `possible_` is valid
    unsigned possible_ = 0;  // open pairs that touch
    bool idle_ = false;      // no pair can collide and no line end acts: the beam counts as at `pending`

    bool chosen_ = false;  // `acting_` is valid; until then all registers act
    Registers acting_ = ~0ull;
    uint32_t acting_playfield_ = 0;  // bits of the playfield near objects
    int acted_ = 0;
    Registers noted_ = 0;
    const TiaWrite* latest_[64];  // latest write of each noted register

    // Computed when needed: the pixels of each object, and the playfield bits that it could collide with.
    unsigned stale_ = kAllObjects;
    Mask masks_[6];
    unsigned near_known_ = 0;
    uint32_t near_[5];
};

}  // namespace atari
