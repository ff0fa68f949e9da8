#include "deferred_renderer.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

#include "machine/console_config.hpp"
#include "machine/tia/object_mask.hpp"
#include "machine/inline.hpp"
#include "paint.hpp"
#include "machine/tia/tia_positions.hpp"
#include "machine/tia/tia_registers.hpp"

namespace atari {
namespace {

const Painter kPaint = chosen_painter();
constexpr unsigned kPlayers = 3u << kColourBits, kPlayfield = 4u << kColourBits, kBackground = 8u << kColourBits;

}  // namespace

void DeferredRenderer::begin(uint8_t* pixels) {
    const Tia& t = t_;
    line_end_ = line_end(t);
    row_ = pixels + kScreenWidth * ((line_end_ - t.draw_start) / kClocksPerLine - 1);
    first_cycle_ = static_cast<uint32_t>(t.frame_start / 3);
    line_end_acts_ = true;
    layers_known_ = false;
    stale_ = kAllObjects;
    for (unsigned player : {0u, 1u}) {
        enable(kP0 + player, t.vdelp[player] ? t.old_grp[player] : t.grp[player]);
        enable(kM0 + player, t.enam[player] && !t.resmp[player]);
    }
    enable(kBL, t.vdelbl ? t.old_enabl : t.enabl);
    enable(kPF, t.playfield);
}

void DeferredRenderer::apply(const TiaWrite* first, const TiaWrite* last) {
    int32_t pending = t_.pending;
    for (const TiaWrite* write = first; write != last; ++write) apply_one(t_, *write, pending);
    t_.pending = pending;
}

void DeferredRenderer::reach(int32_t clock) {
    Tia& t = t_;
    t.pending = std::max(t.pending, clock);
    advance(t.pending);
}

const TiaWrite* DeferredRenderer::draw_line(const TiaWrite* first, const TiaWrite* last, int32_t line_end) {
    Tia& t = t_;
    begin_line();
    int32_t pending = t.pending;
    const TiaWrite* write = first;
    for (; write != last && static_cast<int32_t>(3 * write->cycle) < line_end; ++write) apply_one(t, *write, pending);
    t.pending = pending;
    reach(line_end);
    return write;
}

void DeferredRenderer::begin_line() {
    involved_ = enabled_;
    if (t_.enabl || t_.old_enabl) involved_ |= bit_of(kBL);  // VDELBL selects between them
}

unsigned DeferredRenderer::involved() const {
    if (!(involved_ & kBackground)) return involved_;  // nothing is painted
    // In score mode the playfield has the players' colours.
    const unsigned players = t_.ctrlpf & kScore ? kPlayers : (involved_ | involved_ >> kM0) << kColourBits & kPlayers;
    const bool playfield = involved_ & (bit_of(kPF) | bit_of(kBL));
    return involved_ | players | (playfield ? kPlayfield : 0);
}

void DeferredRenderer::repeat_row() {
    std::memcpy(row_ + kScreenWidth, row_, kScreenWidth);
    row_ += kScreenWidth;
    line_end_ += kClocksPerLine;
    t_.drawn_to = t_.pending = line_end_;
}

INLINE void DeferredRenderer::apply_one(Tia& t, const TiaWrite& write, int32_t& pending) {
    const unsigned reg = write.reg;
    const uint8_t value = write.value;
    const uint32_t cycle = write.cycle - first_cycle_;
    const auto clock = static_cast<int32_t>(3 * write.cycle);
    pending = std::max(pending, clock + kTiaRegisters[reg].delay[cycle & 3]);
    const auto hpos = [&] { return static_cast<int>(3 * (cycle % kCyclesPerLine)); };
    switch (reg) {
        case VBLANK:
            if ((t.vblank ^ value) & kBlanks) advance(pending);
            t.vblank = value;
            break;
        case NUSIZ0:
        case NUSIZ1: write_nusiz(reg - NUSIZ0, value, pending); break;
        case COLUP0:
        case COLUP1:
        case COLUPF:
        case COLUBK: {
            const uint8_t colour = colour_of(value, config_.pal, t);
            if (t.colour[reg - COLUP0] != colour) advance(pending);
            t.colour[reg - COLUP0] = colour;
            involved_ |= 1u << (kColourBits + reg - COLUP0);
            break;
        }
        case CTRLPF:
        case PRIORITY: {
            const bool at_once = cycle % kCyclesPerLine < kLateReflect;
            if ((t.ctrlpf | value) & kScore) involved_ |= kPlayers;
            if (t.ctrlpf == value && (!at_once || t.pf_reflect == (value & kReflects))) break;
            advance(pending);
            t.ctrlpf = value;
            if (at_once) t.pf_reflect = value & kReflects;
            line_end_acts_ |= t.pf_reflect != (value & kReflects);
            outdate(bit_of(kPF) | bit_of(kBL));
            break;
        }
        case REFP0:
        case REFP1: {
            const unsigned player = reg - REFP0;
            involved_ |= kTiaRegisters[reg].objects;
            if (t.refp[player] == ((value & bits_of(REFP0)) != 0)) break;
            advance(pending);
            t.refp[player] = value & bits_of(REFP0);
            outdate(bit_of(player));
            break;
        }
        case PF0:
        case PF1:
        case PF2: write_playfield(with_playfield(t.playfield, reg, value), pending); break;
        case RESP0:
        case RESP1: reset_player(reg - RESP0, hpos(), clock, pending); break;
        case RESM0:
        case RESM1: {
            const unsigned second = reg - RESM0;
            involved_ |= kTiaRegisters[reg].objects;
            advance(pending);
            t.pos[kM0 + second] = strobe_missile(second, hpos(), static_cast<uint32_t>(clock - t.last_hmove));
            if (second == 0) t.m0_variant = kPlain;
            outdate(bit_of(kM0 + second));
            break;
        }
        case RESBL:
            involved_ |= kTiaRegisters[RESBL].objects;
            advance(pending);
            t.pos[kBL] = strobe_ball(hpos(), static_cast<uint32_t>(clock - t.last_hmove));
            outdate(bit_of(kBL));
            break;
        case GRP0: write_graphics(0, value, pending); break;
        case GRP1: write_graphics(1, value, pending); break;
        case ENAM0:
        case ENAM1: {
            const unsigned missile = reg - ENAM0;
            if (t.enam[missile] == ((value & bits_of(ENAM0)) != 0)) break;
            if (!t.resmp[missile]) {
                advance(pending);
                enable(kM0 + missile, value & bits_of(ENAM0));
            }
            t.enam[missile] = value & bits_of(ENAM0);
            break;
        }
        case ENABL:
            involved_ |= kTiaRegisters[ENABL].objects;
            if (t.enabl == ((value & bits_of(ENABL)) != 0)) break;
            if (!t.vdelbl) {
                advance(pending);
                enable(kBL, value & bits_of(ENABL));
            }
            t.enabl = value & bits_of(ENABL);
            break;
        case HMM0:  // has an effect only if the motion goes from 7 to 6
            involved_ |= kTiaRegisters[HMM0].objects;
            if (static_cast<uint32_t>(clock - t.last_hmove) != kArkClocks) break;
            advance(pending);
            t.cosmic_ark = line_end_acts_ = true;
            t.ark_counter = 0;
            break;
        case VDELP0:
        case VDELP1: {
            const unsigned player = reg - VDELP0;
            if (t.vdelp[player] == ((value & bits_of(VDELP0)) != 0)) break;
            advance(pending);
            t.vdelp[player] = value & bits_of(VDELP0);
            show(player);
            break;
        }
        case VDELBL:
            involved_ |= kTiaRegisters[VDELBL].objects;
            if (t.vdelbl == ((value & bits_of(VDELBL)) != 0)) break;
            advance(pending);
            t.vdelbl = value & bits_of(VDELBL);
            enable(kBL, t.vdelbl ? t.old_enabl : t.enabl);
            break;
        case RESMP0:
        case RESMP1: {
            const unsigned second = reg - RESMP0;
            if (t.resmp[second] == ((value & bits_of(RESMP0)) != 0)) break;
            advance(pending);
            if (t.resmp[second]) {
                involved_ |= kTiaRegisters[reg].objects;
                t.pos[kM0 + second] = released_missile(t.pos[second], t.nusiz[second] & 7);
                if (second == 0) t.m0_variant = kPlain;
                outdate(bit_of(kM0 + second));
            }
            t.resmp[second] = value & bits_of(RESMP0);
            enable(kM0 + second, t.enam[second] && !t.resmp[second]);
            break;
        }
        case HMOVE:
        case STILL: move_objects(write, cycle % kCyclesPerLine, clock, pending); break;
        default: break;
    }
}

// To be called when a player's visible graphics change.
inline void DeferredRenderer::show(unsigned player) {
    const Tia& t = t_;
    enable(player, t.vdelp[player] ? t.old_grp[player] : t.grp[player]);
    outdate(bit_of(player));
}

inline void DeferredRenderer::write_playfield(uint32_t value, int32_t pending) {
    if (t_.playfield == value) return;
    advance(pending);
    t_.playfield = value;
    enable(kPF, value);
    outdate(bit_of(kPF));
}

void DeferredRenderer::write_nusiz(unsigned player, uint8_t value, int32_t pending) {
    Tia& t = t_;
    const bool ark = player == 0 && (t.cosmic_ark || t.m0_variant != kPlain);
    if (((t.nusiz[player] ^ value) & bits_of(NUSIZ0)) || t.skip_first[player] || ark) {
        advance(pending);
        t.skip_first[player] = false;
        if (player == 0) t.m0_variant = kPlain;
        outdate(bit_of(kP0 + player) | bit_of(kM0 + player));
    }
    t.nusiz[player] = value;
}

// A write to one player's graphics also moves the other's new graphics to its delayed copy.
inline void DeferredRenderer::write_graphics(unsigned player, uint8_t value, int32_t pending) {
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

void DeferredRenderer::reset_player(unsigned player, int hpos, int32_t clock, int32_t& pending) {
    Tia& t = t_;
    involved_ |= kTiaRegisters[RESP0 + player].objects;
    const uint8_t position = strobe_player(hpos);
    const PlayerStrobe strobe = player_strobe(position, t.pos[player], t.nusiz[player] & 7);
    if (strobe.goes_on) pending = std::max(pending, clock + 11);
    advance(pending);
    t.pos[player] = position;
    t.skip_first[player] = strobe.hidden;
    line_end_acts_ |= strobe.hidden;
    outdate(bit_of(kP0 + player));
}

inline void DeferredRenderer::move_objects(const TiaWrite& write, uint32_t cycle_in_line, int32_t clock,
                                           int32_t pending) {
    Tia& t = t_;
    advance(pending);
    if (config_.hmove_blanks && hmove_blanks(cycle_in_line)) t.hmove_blank = true;
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
    involved_ |= kTiaRegisters[HMOVE].objects;
    t.cosmic_ark = false;
}

// Renders up to a clock, at most to the end of the visible area.
INLINE void DeferredRenderer::advance(int32_t pending) {
    Tia& t = t_;
    if (pending < t.draw_start || t.drawn_to >= t.draw_stop || t.drawn_to >= pending) return;
    const int32_t target = std::min(pending, t.draw_stop);
    // Still before the line's first pixel.
    if (!t.hmove_blank && target <= line_end_ - kScreenWidth) t.drawn_to = target;
    else go_to(target);
}

void DeferredRenderer::go_to(int32_t target) {
    Tia& t = t_;
    while (target > line_end_) {
        line_part(line_end_);
        end_line();
        int32_t lines = 1;
        const int32_t left = target - line_end_ - kClocksPerLine;
        if (left > kClocksPerLine && !t.cosmic_ark && !t.hmove_blank) {
            // The lines between the first and the last are equal, so only those two are run.
            lines = 1 + (left - 1) / kClocksPerLine;
            row_ += kScreenWidth;
            line_end_ += kClocksPerLine;
            line_part(line_end_);
            for (int32_t i = 1; i < lines - 1; ++i) std::memcpy(row_ + i * kScreenWidth, row_, kScreenWidth);
            row_ -= kScreenWidth;
            line_end_ -= kClocksPerLine;
        }
        line_end_ += kClocksPerLine * lines;
        t.drawn_to = line_end_ - kClocksPerLine;
        row_ += kScreenWidth * lines;
    }
    line_part(target);
}

// Renders the rest of a line, or a part of it.
inline void DeferredRenderer::line_part(int32_t until) {
    Tia& t = t_;
    const int from = kClocksPerLine - (line_end_ - t.drawn_to), to = kClocksPerLine - (line_end_ - until);
    t.drawn_to = until;
    if (to > kHblankClocks && to > from) draw(std::max(from - kHblankClocks, 0), to - kHblankClocks);
    constexpr int kBlankEnd = kHblankClocks + kHmoveBlank;
    if (t.hmove_blank && from < kBlankEnd) {
        // The HMOVE blank covers eight black pixels. If rendering stops before them, the black reaches further, as in
        // the reference TIA.
        const int after_blank = std::max(from, std::min(kHblankClocks, to));
        if (after_blank == kHblankClocks) std::memset(row_, 0, kHmoveBlank);
        else
            std::memset(row_ + std::max(after_blank - kHblankClocks, 0), 0,
                        static_cast<size_t>(kBlankEnd - after_blank));
        if (to >= kBlankEnd) t.hmove_blank = false;
    }
}

void DeferredRenderer::end_line() {
    Tia& t = t_;
    if (!line_end_acts_) return;
    line_end_acts_ = t.cosmic_ark;
    if (t.pf_reflect != (t.ctrlpf & kReflects)) {
        t.pf_reflect = t.ctrlpf & kReflects;
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

// Renders pixels first .. last-1 of the line.
void DeferredRenderer::draw(int first, int last) {
    const Tia& t = t_;
    const bool blank = t.vblank & kBlanks;
    if (!blank) involved_ |= kBackground;
    if (blank || !enabled_) {
        std::memset(row_ + first, blank ? 0 : t.colour[3], static_cast<size_t>(last - first));
        return;
    }
    if (!layers_known_) make_layers();
    kPaint(row_, layers_, t.colour, first, last);
}

void DeferredRenderer::make_layers() {
    layers_known_ = true;
    for (unsigned stale = stale_ & enabled_; stale; stale &= stale - 1) {
        const int object = std::countr_zero(stale);
        make_mask(masks_[object], t_, object);
    }
    stale_ &= ~enabled_;
    static constexpr Mask kNone, kLeft = Mask::range(0, 80);
    const auto lit = [&](int object) -> const Mask& { return enabled_ & bit_of(object) ? masks_[object] : kNone; };
    const Mask &p0 = lit(kP0), &p1 = lit(kP1), &m0 = lit(kM0), &m1 = lit(kM1), &bl = lit(kBL), &pf = lit(kPF);
    const bool score = t_.ctrlpf & kScore, playfield_first = t_.ctrlpf & kPlayfieldFirst;
    // In score mode the playfield has the players' colours.
    const bool halved = score && (!playfield_first || enabled_ == bit_of(kPF));
    for (int i = 0; i < 3; ++i) {
        const uint64_t half = pf.word[i] & kLeft.word[i];
        uint64_t player0 = p0.word[i] | m0.word[i], player1 = p1.word[i] | m1.word[i];
        uint64_t playfield = pf.word[i] | bl.word[i];
        if (halved) {
            player0 |= half;
            player1 |= pf.word[i] & ~half;
            playfield &= ~pf.word[i] | bl.word[i];
        }
        const uint64_t over_players = playfield_first ? playfield : 0;
        const uint64_t over_playfield = playfield_first ? 0 : player0 | player1;
        layers_.player0.word[i] = player0 & ~over_players;
        layers_.player1.word[i] = player1 & ~(over_players | player0);
        layers_.playfield.word[i] = playfield & ~over_playfield;
    }
}

}  // namespace atari
