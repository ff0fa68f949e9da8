#include "beam.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

#include "console.hpp"
#include "inline.hpp"
#include "paint.hpp"
#include "tia_registers.hpp"

namespace atari {
namespace {

const Painter kPaint = best_painter();

}  // namespace

void Beam::begin(uint8_t* pixels) {
    const Tia& t = t_;
    line_end_ = line_end(t);
    row_ = pixels + kScreenWidth * ((line_end_ - t.draw_start) / 228 - 1);
    first_cycle_ = static_cast<uint32_t>(t.frame_start / 3);
    line_end_acts_ = true;
    layers_known_ = false;
    stale_ = 0x3f;
    for (unsigned player : {0u, 1u}) {
        enable(kP0 + player, t.vdelp[player] ? t.old_grp[player] : t.grp[player]);
        enable(kM0 + player, t.enam[player] && !t.resmp[player]);
    }
    enable(kBL, t.vdelbl ? t.old_enabl : t.enabl);
    enable(kPF, t.playfield);
}

void Beam::apply(const Write* first, const Write* last) {
    int32_t pending = t_.pending;
    for (const Write* write = first; write != last; ++write) apply_one(t_, *write, pending);
    t_.pending = pending;
}

void Beam::reach(int32_t clock) {
    Tia& t = t_;
    t.pending = std::max(t.pending, clock);
    advance(t.pending);
}

const Write* Beam::draw_line(const Write* first, const Write* last, int32_t line_end) {
    Tia& t = t_;
    begin_line();
    int32_t pending = t.pending;
    const Write* write = first;
    for (; write != last && static_cast<int32_t>(3 * write->cycle) < line_end; ++write)
        apply_one(t, *write, pending);
    t.pending = pending;
    reach(line_end);
    return write;
}

void Beam::begin_line() {
    involved_ = enabled_;
    if (t_.enabl || t_.old_enabl) involved_ |= bit_of(kBL);  // which VDELBL hides or shows
}

void Beam::repeat_row() {
    begin_line();
    std::memcpy(row_ + kScreenWidth, row_, kScreenWidth);
    row_ += kScreenWidth;
    line_end_ += 228;
    t_.drawn_to = t_.pending = line_end_;
}

INLINE void Beam::apply_one(Tia& t, const Write& write, int32_t& pending) {
    const unsigned reg = write.reg;
    const uint8_t value = write.value;
    const uint32_t cycle = write.cycle - first_cycle_;
    const auto clock = static_cast<int32_t>(3 * write.cycle);
    pending = std::max(pending, clock + kDelays[reg][cycle & 3]);
    const auto hpos = [&] { return static_cast<int>(3 * (cycle % 76)); };
    switch (reg) {
        case VBLANK:
            if ((t.vblank ^ value) & 2) advance(pending);
            t.vblank = value;
            break;
        case NUSIZ0: case NUSIZ1: write_nusiz(reg - NUSIZ0, value, pending); break;
        case COLUP0: case COLUP1: case COLUPF: case COLUBK: {
            const uint8_t colour = colour_of(value, config_.pal, t);
            if (t.colour[reg - COLUP0] != colour) advance(pending);
            t.colour[reg - COLUP0] = colour;
            break;
        }
        case CTRLPF: case PRIORITY: {
            const bool at_once = cycle % 76 < kMirrorsAtOnce;
            if (t.ctrlpf == value && (!at_once || t.pf_mirror == (value & 1))) break;
            advance(pending);
            t.ctrlpf = value;
            if (at_once) t.pf_mirror = value & 1;
            line_end_acts_ |= t.pf_mirror != (value & 1);
            outdate(bit_of(kPF) | bit_of(kBL));
            break;
        }
        case REFP0: case REFP1: {
            const unsigned player = reg - REFP0;
            involved_ |= bit_of(player);
            if (t.refp[player] == ((value & 8) != 0)) break;
            advance(pending);
            t.refp[player] = value & 8;
            outdate(bit_of(player));
            break;
        }
        case PF0: case PF1: case PF2: write_playfield(with_playfield(t.playfield, reg, value), pending); break;
        case RESP0: case RESP1: reset_player(reg - RESP0, hpos(), clock, pending); break;
        case RESM0: case RESM1: {
            const unsigned second = reg - RESM0;
            involved_ |= bit_of(kM0 + second) | kPlacing;
            advance(pending);
            t.pos[kM0 + second] = strobe_missile(second, hpos(), static_cast<uint32_t>(clock - t.last_hmove));
            if (second == 0) t.m0_variant = kPlain;
            outdate(bit_of(kM0 + second));
            break;
        }
        case RESBL:
            involved_ |= bit_of(kBL) | kPlacing;
            advance(pending);
            t.pos[kBL] = strobe_ball(hpos(), static_cast<uint32_t>(clock - t.last_hmove));
            outdate(bit_of(kBL));
            break;
        case GRP0: write_graphics(0, value, pending); break;
        case GRP1: write_graphics(1, value, pending); break;
        case ENAM0: case ENAM1: {
            const unsigned missile = reg - ENAM0;
            if (t.enam[missile] == ((value & 2) != 0)) break;
            if (!t.resmp[missile]) {
                advance(pending);
                enable(kM0 + missile, value & 2);
            }
            t.enam[missile] = value & 2;
            break;
        }
        case ENABL:
            involved_ |= bit_of(kBL);
            if (t.enabl == ((value & 2) != 0)) break;
            if (!t.vdelbl) {
                advance(pending);
                enable(kBL, value & 2);
            }
            t.enabl = value & 2;
            break;
        case HMM0:  // kept only if the motion goes from 7 to 6
            involved_ |= kPlacing;
            if (static_cast<uint32_t>(clock - t.last_hmove) != 63) break;
            advance(pending);
            t.cosmic_ark = line_end_acts_ = true;
            t.ark_counter = 0;
            break;
        case VDELP0: case VDELP1: {
            const unsigned player = reg - VDELP0;
            if (t.vdelp[player] == ((value & 1) != 0)) break;
            advance(pending);
            t.vdelp[player] = value & 1;
            show(player);
            break;
        }
        case VDELBL:
            involved_ |= bit_of(kBL);
            if (t.vdelbl == ((value & 1) != 0)) break;
            advance(pending);
            t.vdelbl = value & 1;
            enable(kBL, t.vdelbl ? t.old_enabl : t.enabl);
            break;
        case RESMP0: case RESMP1: {
            const unsigned second = reg - RESMP0;
            if (t.resmp[second] == ((value & 2) != 0)) break;
            advance(pending);
            if (t.resmp[second]) {
                involved_ |= bit_of(second) | bit_of(kM0 + second);
                t.pos[kM0 + second] = released_missile(t.pos[second], t.nusiz[second] & 7);
                if (second == 0) t.m0_variant = kPlain;
                outdate(bit_of(kM0 + second));
            }
            t.resmp[second] = value & 2;
            enable(kM0 + second, t.enam[second] && !t.resmp[second]);
            break;
        }
        case HMOVE: case STILL: move_objects(write, cycle % 76, clock, pending); break;
        default: break;
    }
}

// The graphics of a player that show have changed.
inline void Beam::show(unsigned player) {
    const Tia& t = t_;
    enable(player, t.vdelp[player] ? t.old_grp[player] : t.grp[player]);
    outdate(bit_of(player));
}

inline void Beam::write_playfield(uint32_t value, int32_t pending) {
    if (t_.playfield == value) return;
    advance(pending);
    t_.playfield = value;
    enable(kPF, value);
    outdate(bit_of(kPF));
}

void Beam::write_nusiz(unsigned player, uint8_t value, int32_t pending) {
    Tia& t = t_;
    const bool ark = player == 0 && (t.cosmic_ark || t.m0_variant != kPlain);
    if (((t.nusiz[player] ^ value) & 0x37) || t.skip_first[player] || ark) {
        advance(pending);
        t.skip_first[player] = false;
        if (player == 0) t.m0_variant = kPlain;
        outdate(bit_of(kP0 + player) | bit_of(kM0 + player));
    }
    t.nusiz[player] = value;
}

// A write to one player's graphics also moves the other's new graphics to its delayed copy.
inline void Beam::write_graphics(unsigned player, uint8_t value, int32_t pending) {
    Tia& t = t_;
    const unsigned other = player ^ 1;
    const bool own = !t.vdelp[player] && t.grp[player] != value;
    const bool others = t.vdelp[other] && t.old_grp[other] != t.grp[other];
    const bool ball = player == 1 && t.vdelbl && t.old_enabl != t.enabl;
    if (own || others || ball) advance(pending);
    t.grp[player] = value;
    t.old_grp[other] = t.grp[other];
    if (player == 1) t.old_enabl = t.enabl;
    if (own) show(player);
    if (others) show(other);
    if (ball) enable(kBL, t.old_enabl);
}

void Beam::reset_player(unsigned player, int hpos, int32_t clock, int32_t& pending) {
    Tia& t = t_;
    involved_ |= bit_of(player);
    const uint8_t position = strobe_player(hpos);
    const PlayerStrobe strobe = player_strobe(position, t.pos[player], t.nusiz[player] & 7);
    if (strobe.goes_on) pending = std::max(pending, clock + 11);
    advance(pending);
    t.pos[player] = position;
    t.skip_first[player] = strobe.hidden;
    line_end_acts_ |= strobe.hidden;
    outdate(bit_of(kP0 + player));
}

inline void Beam::move_objects(const Write& write, uint32_t cycle_in_line, int32_t clock, int32_t pending) {
    Tia& t = t_;
    advance(pending);
    if (config_.hmove_blanks && (cycle_in_line <= 20 || cycle_in_line == 75)) t.hmove_blank = true;
    if (write.reg != STILL) {
        const auto& distances = kMotion[cycle_in_line];
        for (int object = kP0; object <= kBL; ++object) {
            const int distance = distances[object == kBL ? write.value : write.beside >> (4 * object) & 15];
            if (distance == 0) continue;
            t.pos[object] = moved_by(t.pos[object], distance);
            outdate(bit_of(object));
        }
    }
    if (t.skip_first[0] || t.skip_first[1]) {
        outdate(bit_of(kP0) | bit_of(kP1));
        t.skip_first[0] = t.skip_first[1] = false;
    }
    if (t.m0_variant != kPlain) {
        t.m0_variant = kPlain;
        outdate(bit_of(kM0));
    }
    t.last_hmove = clock;
    involved_ |= kPlacing;
    t.cosmic_ark = false;
}

// Brings the picture up to a clock, or to the end of what shows.
INLINE void Beam::advance(int32_t pending) {
    Tia& t = t_;
    if (pending < t.draw_start || t.drawn_to >= t.draw_stop || t.drawn_to >= pending) return;
    const int32_t target = std::min(pending, t.draw_stop);
    if (!t.hmove_blank && target <= line_end_ - kScreenWidth) t.drawn_to = target;  // in front of the first pixel
    else go_to(target);
}

void Beam::go_to(int32_t target) {
    Tia& t = t_;
    while (target > line_end_) {
        line_part(line_end_);
        end_line();
        int32_t lines = 1;
        const int32_t left = target - line_end_ - 228;
        if (left > 228 && !t.cosmic_ark && !t.hmove_blank) {
            // Several whole lines are alike: the first and the last of them are run as usual.
            lines = 1 + (left - 1) / 228;
            row_ += kScreenWidth;
            line_end_ += 228;
            line_part(line_end_);
            for (int32_t i = 1; i < lines - 1; ++i) std::memcpy(row_ + i * kScreenWidth, row_, kScreenWidth);
            row_ -= kScreenWidth;
            line_end_ -= 228;
        }
        line_end_ += 228 * lines;
        t.drawn_to = line_end_ - 228;
        row_ += kScreenWidth * lines;
    }
    line_part(target);
}

// The rest of a line, or a part of it.
inline void Beam::line_part(int32_t until) {
    Tia& t = t_;
    const int from = 228 - (line_end_ - t.drawn_to), to = 228 - (line_end_ - until);
    t.drawn_to = until;
    if (to > 68 && to > from) draw(std::max(from - 68, 0), to - 68);
    if (t.hmove_blank && from < 76) {
        // Eight pixels are black. Where drawing stops in front of them this reaches further, as in the reference.
        const int behind_blank = std::max(from, std::min(68, to));
        if (behind_blank == 68) std::memset(row_, 0, 8);
        else std::memset(row_ + std::max(behind_blank - 68, 0), 0, static_cast<size_t>(76 - behind_blank));
        if (to >= 76) t.hmove_blank = false;
    }
}

void Beam::end_line() {
    Tia& t = t_;
    if (!line_end_acts_) return;
    line_end_acts_ = t.cosmic_ark;
    if (t.pf_mirror != (t.ctrlpf & 1)) {
        t.pf_mirror = t.ctrlpf & 1;
        outdate(bit_of(kPF));
    }
    for (int player : {0, 1}) {
        if (!t.skip_first[player]) continue;
        t.skip_first[player] = false;
        outdate(bit_of(player));
    }
    if (t.cosmic_ark) {
        step_cosmic_ark(t);
        outdate(bit_of(kM0));
    }
}

// Draws pixels first .. last-1 of the line.
void Beam::draw(int first, int last) {
    const Tia& t = t_;
    if ((t.vblank & 2) || !enabled_) {
        std::memset(row_ + first, t.vblank & 2 ? 0 : t.colour[3], static_cast<size_t>(last - first));
        return;
    }
    if (!layers_known_) make_layers();
    kPaint(row_, layers_, t.colour, first, last);
}

void Beam::make_layers() {
    layers_known_ = true;
    for (unsigned stale = stale_ & enabled_; stale; stale &= stale - 1) {
        const int object = std::countr_zero(stale);
        make_mask(masks_[object], t_, object);
    }
    stale_ &= ~enabled_;
    static constexpr Mask kNone, kLeft = Mask::range(0, 80);
    const auto lit = [&](int object) -> const Mask& { return enabled_ & bit_of(object) ? masks_[object] : kNone; };
    const Mask &p0 = lit(kP0), &p1 = lit(kP1), &m0 = lit(kM0), &m1 = lit(kM1), &bl = lit(kBL), &pf = lit(kPF);
    const bool score = t_.ctrlpf & 2, playfield_first = t_.ctrlpf & 4;
    const bool halved = score && (!playfield_first || enabled_ == bit_of(kPF));  // the playfield has the players' colours
    for (int i = 0; i < 3; ++i) {
        const uint64_t half = pf.word[i] & kLeft.word[i];
        uint64_t player0 = p0.word[i] | m0.word[i], player1 = p1.word[i] | m1.word[i], playfield = pf.word[i] | bl.word[i];
        if (halved) {
            player0 |= half;
            player1 |= pf.word[i] & ~half;
            playfield &= ~pf.word[i] | bl.word[i];
        }
        const uint64_t behind0 = playfield_first ? playfield : 0, behind = playfield_first ? 0 : player0 | player1;
        layers_.player0.word[i] = player0 & ~behind0;
        layers_.player1.word[i] = player1 & ~(behind0 | player0);
        layers_.playfield.word[i] = playfield & ~behind;
    }
}

}  // namespace atari
