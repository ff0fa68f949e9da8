#include "collider.hpp"

#include <algorithm>
#include <bit>

#include "machine/console_config.hpp"
#include "machine/inline.hpp"
#include "machine/tia/tia_positions.hpp"

namespace atari {

namespace {

// Effects on registers of the TIA writes whose application can be deferred.

void set_graphics_of(TiaLine& t, unsigned player, const TiaWrite& write) {
    t.grp[player] = write.value;
    t.old_grp[player ^ 1] = static_cast<uint8_t>(write.beside);
    if (player == 1) t.old_enabl = write.beside >> 8 != 0;
}

void set_register(TiaLine& t, const TiaWrite& write) {
    const uint8_t reg = write.reg, value = write.value;
    switch (reg) {
        case REFP0:
        case REFP1: t.refp[reg - REFP0] = value & bits_of(REFP0); break;
        case PF0:
        case PF1:
        case PF2: t.playfield = with_playfield(t.playfield, reg, value); break;
        case GRP0:
        case GRP1: set_graphics_of(t, reg - GRP0, write); break;
        case ENAM0:
        case ENAM1: t.enam[reg - ENAM0] = value & bits_of(ENAM0); break;
        case ENABL: t.enabl = value & bits_of(ENABL); break;
        default: break;
    }
}

}  // namespace

void Collider::begin(unsigned latches) {
    watched_ = latches;
    first_cycle_ = static_cast<uint32_t>(t_.frame_start / 3);
    from_ = t_.drawn_to;
    blanked_at_ = t_.draw_start;
    collecting_ = true;
    acted_ = 0;
    noted_ = 0;
    derive_again();
}

// Discards everything derived from the TIA's state, and derives the enabled objects again.
void Collider::derive_again() {
    const Tia& t = t_;
    line_end_acts_ = true;
    idle_ = false;
    stale_ = kAllObjects;
    near_known_ = 0;
    unknown_ = 0xffff;
    enabled_ = 0;
    for (unsigned i : {0u, 1u}) {
        enabled_ |= (t.vdelp[i] ? t.old_grp[i] : t.grp[i]) ? bit_of(kP0 + i) : 0;
        enabled_ |= t.enam[i] && !t.resmp[i] ? bit_of(kM0 + i) : 0;
    }
    enabled_ |= (t.vdelbl ? t.old_enabl : t.enabl) ? bit_of(kBL) : 0;
    enabled_ |= t.playfield ? bit_of(kPF) : 0;
    find_open_pairs();
    reconsider();
}

void Collider::watch(unsigned latches) {
    bring_up(kLooks);
    watched_ = latches;
    find_open_pairs();
    reconsider();
}

void Collider::collect(bool on) {
    if (on) bring_up(kLooks);
    collecting_ = on;
    reconsider();
}

void Collider::finish() {
    Tia& t = t_;
    bring_up(~0ull);
    if (idle_) skip_to_pending();
    if (t.hmove_blank && blank_is_over(t.drawn_to)) t.hmove_blank = false;
    t.to_line_end = line_end(t) - t.drawn_to;
    const int32_t drawn = t.drawn_to - t.draw_start;
    t.write_pos = drawn / kClocksPerLine * kScreenWidth + std::max(0, drawn % kClocksPerLine - kHblankClocks);
}

TiaLine Collider::state_at(int32_t clock) {
    advance(clock);
    bring_up(set_of({STILL}));
    TiaLine state = t_;
    for (Registers rest = noted_; rest; rest &= rest - 1) set_register(state, *latest_[std::countr_zero(rest)]);
    state.ctrlpf &= kShapesOfCtrlpf;
    // The same values as after `skip_to_pending`.
    if (state.pending >= t_.draw_start)
        state.drawn_to = std::max(state.drawn_to, std::min(state.pending, t_.draw_stop));
    if (state.hmove_blank && blank_is_over(state.drawn_to)) state.hmove_blank = false;
    return state;
}

void Collider::go_on_from(const TiaLine& state, uint16_t collisions, int32_t blanked_at) {
    static_cast<TiaLine&>(t_) = state;
    t_.collisions = collisions;
    blanked_at_ = blanked_at;
    noted_ = 0;
    derive_again();
}

// --- single registers ---

// A write to one player's graphics also copies the other player's new graphics to their delayed copy. Returns the objects
// whose look it changes.
INLINE unsigned Collider::changed_by_graphics(unsigned player, const TiaWrite& write) const {
    const Tia& t = t_;
    const unsigned other = player ^ 1;
    unsigned objects = 0;
    if (!t.vdelp[player] && t.grp[player] != write.value) objects |= bit_of(kP0 + player);
    if (t.vdelp[other] && t.old_grp[other] != static_cast<uint8_t>(write.beside)) objects |= bit_of(kP0 + other);
    if (player == 1 && t.vdelbl && t.old_enabl != (write.beside >> 8 != 0)) objects |= bit_of(kBL);
    return objects;
}

INLINE void Collider::set_graphics(unsigned player, const TiaWrite& write, unsigned changed) {
    set_graphics_of(t_, player, write);
    if (changed & bit_of(kP0)) show(0);
    if (changed & bit_of(kP1)) show(1);
    if (changed & bit_of(kBL)) enable(kBL, t_.old_enabl);
}

INLINE void Collider::set_enam(unsigned missile, uint8_t value) {
    t_.enam[missile] = value & bits_of(ENAM0);
    enable(kM0 + missile, t_.enam[missile] && !t_.resmp[missile]);
}

INLINE void Collider::set_enabl(uint8_t value) {
    t_.enabl = value & bits_of(ENABL);
    if (!t_.vdelbl) enable(kBL, t_.enabl);
}

// Applies a TIA write that acts, after the beam has been brought to the clock at which the write shows.
INLINE void Collider::apply_one(const TiaWrite& write) {
    Tia& t = t_;
    const unsigned reg = write.reg;
    const uint8_t value = write.value;
    const auto clock = static_cast<int32_t>(3 * write.cycle);
    const auto hpos = [&] { return static_cast<int>(3 * ((write.cycle - first_cycle_) % kCyclesPerLine)); };
    switch (reg) {
        case VBLANK:
            if ((t.vblank ^ value) & kBlanks) {
                advance(clock + delay_of(VBLANK));
                bring_up(kLooks);
                reconsider();
            }
            t.vblank = value;
            break;
        case NUSIZ0:
        case NUSIZ1: write_nusiz(reg - NUSIZ0, value, clock); break;
        case CTRLPF: write_ctrlpf(value, (write.cycle - first_cycle_) % kCyclesPerLine, clock); break;
        case REFP0:
        case REFP1:
            if (t.refp[reg - REFP0] != ((value & bits_of(REFP0)) != 0)) advance(clock + delay_of(REFP0));
            apply_noted(write);
            break;
        case PF0:
        case PF1:
        case PF2: write_playfield(write, shown_at(write, first_cycle_)); break;
        case RESP0:
        case RESP1: reset_player(reg - RESP0, hpos(), clock); break;
        case RESM0:
        case RESM1: {
            const unsigned second = reg - RESM0;
            advance(clock + delay_of(RESM0));
            bring_up(set_of({STILL}));
            t.pos[kM0 + second] = strobe_missile(second, hpos(), static_cast<uint32_t>(clock - t.last_hmove));
            if (second == 0) t.m0_variant = kPlain;
            moved(bit_of(kM0 + second));
            break;
        }
        case RESBL:
            advance(clock);
            bring_up(set_of({STILL}));
            t.pos[kBL] = strobe_ball(hpos(), static_cast<uint32_t>(clock - t.last_hmove));
            moved(bit_of(kBL));
            break;
        case GRP0: write_graphics(0, write, clock); break;
        case GRP1: write_graphics(1, write, clock); break;
        case ENAM0:
        case ENAM1:
            if (!t.resmp[reg - ENAM0]) advance(clock);
            set_enam(reg - ENAM0, value);
            break;
        case ENABL:
            if (!t.vdelbl) advance(clock);
            set_enabl(value);
            break;
        case HMM0:  // has an effect only if the motion goes from 7 to 6
            bring_up(set_of({STILL}));
            if (static_cast<uint32_t>(clock - t.last_hmove) != kArkClocks) break;
            advance(clock);
            bring_up(~0ull);
            t.cosmic_ark = line_end_acts_ = true;
            t.ark_counter = 0;
            reconsider();
            break;
        case VDELP0:
        case VDELP1: {
            const unsigned player = reg - VDELP0;
            advance(clock);
            bring_up(kLooks);
            t.vdelp[player] = value & bits_of(VDELP0);
            show(player);
            reconsider();
            break;
        }
        case VDELBL:
            advance(clock);
            bring_up(kLooks);
            t.vdelbl = value & bits_of(VDELBL);
            enable(kBL, t.vdelbl ? t.old_enabl : t.enabl);
            reconsider();
            break;
        case RESMP0:
        case RESMP1: release_missile(reg - RESMP0, value, clock); break;
        case STILL:
            advance(clock);
            apply_noted(write);
            break;
        case CXCLR: {
            advance(clock);
            const bool opens = t.collisions & watched_;  // otherwise the same pairs stay open, and the same writes act
            if (opens) bring_up(kLooks);
            t.collisions = 0;
            if (!opens) break;
            find_open_pairs();
            reconsider();
            break;
        }
        case SAME_TIME:  // one instruction's write in the same cycle as the one before: the longest delay counts
            t.pending = std::max(t.pending, shown_at((&write)[-1], first_cycle_));
            break;
        default: break;
    }
}

// Applies TIA writes. Writes to registers that do not act are only noted. The sets are copied, because the compiler
// cannot keep members in registers here.
void Collider::apply(const TiaWrite* write, const TiaWrite* last) {
    while (write != last) {
        std::size_t reg = write->reg;
        if (const Registers acting = acting_; !(acting >> reg & 1)) {
            Registers noted = noted_;
            do {
                latest_[reg] = write;
                noted |= kSetOf[reg];
                if (++write == last) break;
                reg = write->reg;
            } while (!(acting >> reg & 1));
            noted_ = noted;
            if (write == last) return;
        }
        if (!chosen_ && !(kAlwaysActing >> reg & 1)) {
            choose_acting();
            if (!(acting_ >> reg & 1)) continue;
        }
        noted_ &= ~kSetOf[reg];  // a noted write is older than this one
        ++acted_;
        // most frequent, so inlined
        if (reg == HMOVE) move_objects(*write, static_cast<int32_t>(3 * write->cycle));
        else apply_one(*write);
        ++write;
    }
}

// The effect of a TIA write on its register, without bringing the beam to it first.
void Collider::apply_noted(const TiaWrite& write) {
    Tia& t = t_;
    const uint8_t value = write.value;
    switch (write.reg) {
        case REFP0:
        case REFP1:
            set_register(t, write);
            outdate(write.reg - REFP0);
            break;
        case PF0:
        case PF1:
        case PF2:
            set_register(t, write);
            if (t.playfield) enable(kPF, true);  // never disabled here, because its bits change from line to line
            moved(bit_of(kPF));
            break;
        case GRP0: set_graphics(0, write, changed_by_graphics(0, write)); break;
        case GRP1: set_graphics(1, write, changed_by_graphics(1, write)); break;
        case ENAM0:
        case ENAM1: set_enam(write.reg - ENAM0, value); break;
        case ENABL: set_enabl(value); break;
        case STILL:
            if (config_.hmove_blanks) blank(static_cast<int32_t>(3 * write.cycle));
            end_tricks(static_cast<int32_t>(3 * write.cycle));
            break;
        default: break;
    }
}

void Collider::apply_all_noted(Registers due) {
    noted_ &= ~due;
    const unsigned before = enabled_;
    for (Registers rest = due; rest; rest &= rest - 1) apply_noted(*latest_[std::countr_zero(rest)]);
    if (enabled_ != before) reconsider();  // an object may have disappeared whose registers do not act
}

void Collider::write_nusiz(unsigned player, uint8_t value, int32_t clock) {
    Tia& t = t_;
    const bool ark = player == 0 && (t.cosmic_ark || t.m0_variant != kPlain);
    if (((t.nusiz[player] ^ value) & bits_of(NUSIZ0)) || t.skip_first[player] || ark) {
        advance(clock + delay_of(NUSIZ0));
        t.skip_first[player] = false;
        if (player == 0) t.m0_variant = kPlain;
        moved(bit_of(kP0 + player));
        moved(bit_of(kM0 + player));
    }
    t.nusiz[player] = value;
}

void Collider::write_ctrlpf(uint8_t value, uint32_t cycle_in_line, int32_t clock) {
    Tia& t = t_;
    const bool sized = (t.ctrlpf ^ value) & kBallSize, pending = t.pf_reflect != (t.ctrlpf & kReflects);
    const bool reflect_changes = pending || ((t.ctrlpf ^ value) & kReflects);
    if (sized || reflect_changes) advance(clock);
    t.ctrlpf = value;
    if (sized) moved(bit_of(kBL));
    if (!reflect_changes) return;
    bring_up(kLooks);
    if (cycle_in_line < kLateReflect) t.pf_reflect = value & kReflects;
    line_end_acts_ |= t.pf_reflect != (value & kReflects);
    near_known_ = 0;
    moved(bit_of(kPF));
    reconsider();
}

inline void Collider::write_graphics(unsigned player, const TiaWrite& write, int32_t clock) {
    const unsigned changed = changed_by_graphics(player, write);
    if (changed) advance(clock + delay_of(GRP0));
    set_graphics(player, write, changed);
}

// Playfield bits that are near no object cannot collide.
inline void Collider::write_playfield(const TiaWrite& write, int32_t shown) {
    const uint32_t changed = t_.playfield ^ with_playfield(t_.playfield, write.reg, write.value);
    if (chosen_ && !(changed & acting_playfield_)) {
        t_.playfield ^= changed;
        outdate(kPF);
        unknown_ |= kPairsWith[bit_of(kPF)];
        return;
    }
    advance(shown);
    apply_noted(write);
}

void Collider::reset_player(unsigned player, int hpos, int32_t clock) {
    Tia& t = t_;
    const uint8_t position = strobe_player(hpos);
    const PlayerStrobe strobe = player_strobe(position, t.pos[player], t.nusiz[player] & 7);
    advance(strobe.goes_on ? clock + 11 : clock);
    bring_up(set_of({STILL}));  // a noted STILL would end the hiding that begins here
    t.pos[player] = position;
    t.skip_first[player] = strobe.hidden;
    moved(bit_of(kP0 + player));
    if (!strobe.hidden) return;
    line_end_acts_ = true;
    reconsider();
}

inline void Collider::move_objects(const TiaWrite& write, int32_t clock) {
    Tia& t = t_;
    advance(clock);
    bring_up(set_of({STILL}));
    const uint32_t cycle_in_line = (write.cycle - first_cycle_) % kCyclesPerLine;
    if (config_.hmove_blanks && hmove_blanks(cycle_in_line)) blank(clock);
    const auto& distances = kMotion[cycle_in_line];
    const uint32_t motions = write.beside | uint32_t{write.value} << 16;
    uint32_t nibbles = 0x11111;  // in most cycles an object without motion keeps its position
    if (distances[0] == 0) nibbles &= motions | motions >> 1 | motions >> 2 | motions >> 3;
    unsigned objects = 0;
    for (; nibbles; nibbles &= nibbles - 1) {
        const int at = std::countr_zero(nibbles);
        const auto object = static_cast<unsigned>(at) / 4;
        const int distance = distances[motions >> at & 15];
        if (distance == 0) continue;
        t.pos[object] = moved_by(t.pos[object], distance);
        objects |= bit_of(object);
    }
    if (objects) moved(objects);
    end_tricks(clock);
}

// The effects of every HMOVE, also of one that moves no object.
inline void Collider::end_tricks(int32_t clock) {
    Tia& t = t_;
    t.last_hmove = clock;
    t.cosmic_ark = false;
    if (t.skip_first[0]) outdate(kP0);
    if (t.skip_first[1]) outdate(kP1);
    t.skip_first[0] = t.skip_first[1] = false;
    if (t.m0_variant == kPlain) return;
    t.m0_variant = kPlain;
    moved(bit_of(kM0));
}

void Collider::release_missile(unsigned missile, uint8_t value, int32_t clock) {
    Tia& t = t_;
    advance(clock);
    bring_up(kLooks);
    if (t.resmp[missile] && !(value & bits_of(RESMP0))) {
        t.pos[kM0 + missile] = released_missile(t.pos[missile], t.nusiz[missile] & 7);
        if (missile == 0) t.m0_variant = kPlain;
        moved(bit_of(kM0 + missile));
    }
    t.resmp[missile] = value & bits_of(RESMP0);
    enable(kM0 + missile, t.enam[missile] && !t.resmp[missile]);
}

void Collider::blank(int32_t clock) {
    t_.hmove_blank = true;
    blanked_at_ = std::max(from_, std::min(clock, t_.draw_stop));
}

// Returns whether the blank of the last HMOVE has been rendered. The blank covers eight pixels of the beam's line at
// the HMOVE, or of the next line if the beam was already past them.
bool Collider::blank_is_over(int32_t drawn_to) const {
    constexpr int kBlankEnd = kHblankClocks + kHmoveBlank;
    const int32_t blanked = blanked_at_ - t_.draw_start, in_line = blanked % kClocksPerLine;
    return drawn_to - t_.draw_start >= blanked - in_line + kBlankEnd + (in_line >= kBlankEnd ? kClocksPerLine : 0);
}

// Finds collisions up to `pending`, at most to the end of the visible area.
void Collider::catch_up() {
    const Tia& t = t_;
    if (t.pending < t.draw_start || t.drawn_to >= t.draw_stop || t.drawn_to >= t.pending) return;
    if (!known_) find_possible();
    if (possible_ || line_end_acts_) return go_to(std::min(t.pending, t.draw_stop));
    idle_ = true;
}

// While `idle_` is set the beam is not moved, so it is moved here.
void Collider::skip_to_pending() {
    Tia& t = t_;
    if (t.pending >= t.draw_start) t.drawn_to = std::max(t.drawn_to, std::min(t.pending, t.draw_stop));
}

void Collider::go_to(int32_t target) {
    Tia& t = t_;
    const auto part = [&](int32_t end, int32_t until) {
        const int from = kClocksPerLine - (end - t.drawn_to), to = kClocksPerLine - (end - until);
        t.drawn_to = until;
        if (to > kHblankClocks && to > from) collide(std::max(from - kHblankClocks, 0), to - kHblankClocks);
    };
    int32_t end = line_end(t);
    while (target > end) {
        part(end, end);
        end_line();
        int32_t lines = 1;
        // If several whole lines are equal, only the last is run.
        const int32_t left = target - end - kClocksPerLine;
        if (left > kClocksPerLine && !t.cosmic_ark) lines = 1 + (left - 1) / kClocksPerLine;
        end += kClocksPerLine * lines;
        t.drawn_to = end - kClocksPerLine;
    }
    part(end, target);
}

void Collider::end_line() {
    Tia& t = t_;
    if (!line_end_acts_) return;
    line_end_acts_ = t.cosmic_ark;
    if (t.pf_reflect != (t.ctrlpf & kReflects)) {
        t.pf_reflect = t.ctrlpf & kReflects;
        moved(bit_of(kPF));
        near_known_ = 0;
        reconsider();
    }
    for (unsigned player : {0u, 1u}) {
        if (!t.skip_first[player]) continue;
        t.skip_first[player] = false;
        outdate(player);
    }
    if (t.cosmic_ark) {
        step_cosmic_ark(t);
        moved(bit_of(kM0));
    }
}

}  // namespace atari
