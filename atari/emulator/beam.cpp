#include "beam.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "console.hpp"
#include "tia_registers.hpp"

namespace atari {
namespace {

// The collision latches that a set of enabled objects could switch on.
constexpr auto kPairsOf = [] {
    std::array<uint16_t, 64> table{};
    for (unsigned objects = 0; objects < 64; ++objects)
        for (const Pair& pair : kPairs)
            if ((objects >> pair.a & 1) && (objects >> pair.b & 1)) table[objects] |= pair.latch;
    return table;
}();

// The pair of each latch.
constexpr auto kPairOf = [] {
    std::array<Pair, 16> table{};
    for (const Pair& pair : kPairs) table[static_cast<size_t>(std::countr_zero(pair.latch))] = pair;
    return table;
}();

// Eight bits as eight bytes of 0x00 or 0xff, lowest bit first.
constexpr auto kByteMasks = [] {
    std::array<uint64_t, 256> table{};
    for (uint64_t byte = 0; byte < 256; ++byte)
        for (int bit = 0; bit < 8; ++bit)
            if (byte & (1u << bit)) table[byte] |= uint64_t{0xff} << (8 * bit);
    return table;
}();

constexpr uint64_t repeated(uint8_t byte) { return byte * 0x0101010101010101ull; }

constexpr unsigned bit_of(int object) { return 1u << object; }

}  // namespace

Beam::Beam(Tia& tia, const ConsoleConfig& config, uint8_t* pixels) : t_(tia), config_(config), pixels_(pixels) {}

void Beam::begin() {
    first_cycle_ = static_cast<uint32_t>(t_.frame_start / 3);
    line_end_ = t_.drawn_to + t_.to_line_end;
    touch(0x3f);
}

void Beam::finish() {
    t_.to_line_end = line_end_ - t_.drawn_to;
    const int line = (line_end_ - t_.draw_start) / 228 - 1;
    t_.write_pos = line * kScreenWidth + std::max(0, 228 - t_.to_line_end - 68);
}

void Beam::apply(const Write* first, const Write* last, const Write* collisions_from) {
    if (pixels_) apply_all<true>(first, last, collisions_from);
    else apply_all<false>(first, last, collisions_from);
}

void Beam::reach(int32_t clock) {
    t_.pending = std::max(t_.pending, clock);
    if (pixels_) advance<true>();
    else advance<false>();
}

template <bool drawing>
void Beam::apply_all(const Write* first, const Write* last, const Write* collisions_from) {
    for (const Write* write = first; write != last; ++write) {
        collecting_ = write >= collisions_from;
        apply_one<drawing>(*write);
    }
    collecting_ = true;
}

template <bool drawing>
void Beam::apply_one(const Write& write) {
    Tia& t = t_;
    const uint8_t value = write.value;
    const uint32_t cycle = write.cycle - first_cycle_;
    const auto clock = static_cast<int32_t>(3 * write.cycle);
    t.pending = std::max(t.pending, clock + static_cast<int32_t>(write_delay(write.reg, cycle)));
    const auto hpos = [&] { return static_cast<int>(3 * (cycle % 76)); };
    const int second = write.reg & 1;  // of register pairs that begin at an even address
    switch (write.reg) {
        case VBLANK:
            if ((t.vblank ^ value) & 2) advance<drawing>();
            t.vblank = value;
            break;
        case NUSIZ0: case NUSIZ1: write_nusiz<drawing>(second, value); break;
        case COLUP0: case COLUP1: case COLUPF: case COLUBK: {
            const auto colour = static_cast<uint8_t>((value & 0xfe) | (config_.pal ? t.last_line_count & 1 : 0));
            uint8_t& field = t.colour[write.reg - COLUP0];
            if (drawing && field != colour) advance<drawing>();  // colours do not collide
            field = colour;
            break;
        }
        case CTRLPF:
            change<drawing>(t.ctrlpf, value, bit_of(kPF) | bit_of(kBL));
            if (hpos() < 147) change<drawing>(t.pf_mirror, (value & 1) != 0, bit_of(kPF));
            break;
        case REFP0: case REFP1:
            change<drawing>(t.refp[write.reg - REFP0], (value & 8) != 0, bit_of(write.reg - REFP0));
            break;
        case PF0: change<drawing>(t.playfield, (t.playfield & ~0xfu) | value >> 4, bit_of(kPF)); break;
        case PF1: change<drawing>(t.playfield, (t.playfield & ~0xff0u) | value << 4, bit_of(kPF)); break;
        case PF2: change<drawing>(t.playfield, (t.playfield & ~0xff000u) | value << 12, bit_of(kPF)); break;
        case RESP0: case RESP1: reset_player<drawing>(second, hpos(), clock); break;
        case RESM0: case RESM1:
            advance<drawing>();
            t.pos[kM0 + second] = strobe_missile(second, hpos(), static_cast<uint32_t>(clock - t.last_hmove));
            if (second == 0) t.m0_variant = kPlain;
            touch(bit_of(kM0 + second));
            break;
        case RESBL:
            advance<drawing>();
            t.pos[kBL] = strobe_ball(hpos(), static_cast<uint32_t>(clock - t.last_hmove));
            touch(bit_of(kBL));
            break;
        case GRP0: write_graphics<drawing>(0, value); break;
        case GRP1: write_graphics<drawing>(1, value); break;
        case ENAM0: case ENAM1: {
            const int missile = write.reg - ENAM0;
            if (t.resmp[missile]) t.enam[missile] = value & 2;
            else change<drawing>(t.enam[missile], (value & 2) != 0, 0);
            break;
        }
        case ENABL:
            if (t.vdelbl) t.enabl = value & 2;
            else change<drawing>(t.enabl, (value & 2) != 0, 0);
            break;
        case HMM0:
            if (static_cast<uint32_t>(clock - t.last_hmove) == 63 && t.hm[kM0] == 7 && value >> 4 == 6) {
                advance<drawing>();
                t.cosmic_ark = true;
                t.ark_counter = 0;
            }
            [[fallthrough]];
        case HMP0: case HMP1: case HMM1: case HMBL: t.hm[write.reg - HMP0] = value >> 4; break;
        case VDELP0: case VDELP1:
            change<drawing>(t.vdelp[write.reg - VDELP0], (value & 1) != 0, bit_of(write.reg - VDELP0));
            break;
        case VDELBL: change<drawing>(t.vdelbl, (value & 1) != 0, 0); break;
        case RESMP0: case RESMP1:
            if (t.resmp[second] == ((value & 2) != 0)) break;
            advance<drawing>();
            if (t.resmp[second]) {
                t.pos[kM0 + second] = released_missile(t.pos[second], t.nusiz[second] & 7);
                if (second == 0) t.m0_variant = kPlain;
            }
            t.resmp[second] = value & 2;
            touch(bit_of(kM0 + second));
            break;
        case HMOVE: move_objects<drawing>(static_cast<int>(cycle % 76), clock); break;
        case HMCLR: std::fill_n(t.hm, 5, uint8_t{0}); break;
        case CXCLR:
            advance<drawing>();
            t.collisions = 0;
            break;
        default: break;
    }
}

template <bool drawing, typename T, typename V>
void Beam::change(T& field, V value, unsigned objects) {
    if (field == value) return;
    advance<drawing>();
    field = value;
    touch(objects);
}

template <bool drawing>
void Beam::write_nusiz(int player, uint8_t value) {
    Tia& t = t_;
    const bool ark = player == 0 && (t.cosmic_ark || t.m0_variant != kPlain);
    if (((t.nusiz[player] ^ value) & 0x37) || t.skip_first[player] || ark) {
        advance<drawing>();
        t.skip_first[player] = false;
        if (player == 0) t.m0_variant = kPlain;
        touch(bit_of(kP0 + player) | bit_of(kM0 + player));
    }
    t.nusiz[player] = value;
}

// A write to one player's graphics also moves the other's new graphics to its delayed copy.
template <bool drawing>
void Beam::write_graphics(int player, uint8_t value) {
    Tia& t = t_;
    const int other = player ^ 1;
    const bool own = !t.vdelp[player] && t.grp[player] != value;
    const bool others = t.vdelp[other] && t.old_grp[other] != t.grp[other];
    const bool ball = player == 1 && t.vdelbl && t.old_enabl != t.enabl;
    if (own || others || ball) {
        advance<drawing>();
        touch((own ? bit_of(player) : 0) | (others ? bit_of(other) : 0));
    }
    t.grp[player] = value;
    t.old_grp[other] = t.grp[other];
    if (player == 1) t.old_enabl = t.enabl;
}

template <bool drawing>
void Beam::reset_player(int player, int hpos, int32_t clock) {
    Tia& t = t_;
    const PlayerStrobe strobe = strobe_player(hpos, t.pos[player], t.nusiz[player] & 7);
    if (strobe.goes_on) t.pending = std::max(t.pending, clock + 11);
    advance<drawing>();
    t.pos[player] = strobe.position;
    t.skip_first[player] = strobe.hidden;
    touch(bit_of(kP0 + player));
}

template <bool drawing>
void Beam::move_objects(int cycle_in_line, int32_t clock) {
    Tia& t = t_;
    advance<drawing>();
    if (config_.hmove_blanks && (cycle_in_line <= 20 || cycle_in_line == 75)) t.hmove_blank = true;
    unsigned moved = 0;
    for (int object = kP0; object <= kBL; ++object) {
        const int distance = motion(cycle_in_line, t.hm[object]);
        if (distance == 0) continue;
        t.pos[object] = wrapped(t.pos[object] + distance);
        moved |= bit_of(object);
    }
    if (t.skip_first[0]) moved |= bit_of(kP0);
    if (t.skip_first[1]) moved |= bit_of(kP1);
    if (t.m0_variant != kPlain) moved |= bit_of(kM0);
    stale_ |= moved;
    t.skip_first[0] = t.skip_first[1] = false;
    t.m0_variant = kPlain;
    t.last_hmove = clock;
    t.cosmic_ark = false;
}

// Brings the picture up to `pending`, or to the end of what shows.
template <bool drawing>
void Beam::advance() {
    Tia& t = t_;
    if (t.pending < t.draw_start || t.drawn_to >= t.draw_stop || t.drawn_to >= t.pending) return;
    const int32_t target = std::min(t.pending, t.draw_stop);
    while (target > line_end_) {
        line_part<drawing>(line_end_);
        end_line();
        line_end_ += 228;
        const int32_t left = target - line_end_;
        if (left <= 228 || t.cosmic_ark || (drawing && t.hmove_blank)) continue;
        // Several whole lines are alike: one of them tells their collisions, and how they look.
        const int32_t lines = (left - 1) / 228;
        if (drawing) {
            line_part<drawing>(line_end_);
            uint8_t* row = row_at(line_end_);
            for (int32_t i = 1; i < lines; ++i) std::memcpy(row + i * kScreenWidth, row, kScreenWidth);
        }
        t.drawn_to = line_end_ - 228 + 228 * lines;
        line_end_ += 228 * lines;
    }
    line_part<drawing>(target);
}

// The row that is being drawn in the line that ends at a clock.
uint8_t* Beam::row_at(int32_t line_end) const {
    return pixels_ + ((line_end - t_.draw_start) / 228 - 1) * kScreenWidth;
}

// The rest of a line, or a part of it.
template <bool drawing>
void Beam::line_part(int32_t until) {
    Tia& t = t_;
    const int from = 228 - (line_end_ - t.drawn_to), to = 228 - (line_end_ - until);
    t.drawn_to = until;
    if (to > 68 && to > from) {
        const int first = std::max(from - 68, 0), last = to - 68;
        if constexpr (drawing) draw(first, last);
        else collide(first, last);
    }
    if (t.hmove_blank && from < 76) {
        // Eight pixels are black. Where drawing stops in front of them this reaches further, as in the reference.
        const int behind_blank = std::max(from, std::min(68, to));
        if constexpr (drawing)
            std::memset(row_at(line_end_) + std::max(behind_blank - 68, 0), 0, static_cast<size_t>(76 - behind_blank));
        if (to >= 76) t.hmove_blank = false;
    }
}

// Happens only when drawing goes strictly past the end of a visible line.
void Beam::end_line() {
    Tia& t = t_;
    if (t.pf_mirror != (t.ctrlpf & 1)) {
        t.pf_mirror = t.ctrlpf & 1;
        stale_ |= bit_of(kPF);
    }
    for (int player : {0, 1}) {
        if (!t.skip_first[player]) continue;
        t.skip_first[player] = false;
        stale_ |= bit_of(kP0 + player);
    }
    if (t.cosmic_ark) {
        static constexpr uint8_t kStep[4] = {18, 33, 0, 17};
        t.ark_counter = (t.ark_counter + 1) & 3;
        t.pos[kM0] = static_cast<uint8_t>((t.pos[kM0] + 160 - kStep[t.ark_counter]) % 160);
        t.m0_variant = t.ark_counter == 1 ? kWide : t.ark_counter == 2 ? kOff : kPlain;
        stale_ |= bit_of(kM0);
    }
}

unsigned Beam::enabled() {
    if (enabled_known_) return enabled_;
    const Tia& t = t_;
    enabled_known_ = true;
    enabled_ = 0;
    if (t.vdelp[0] ? t.old_grp[0] : t.grp[0]) enabled_ |= bit_of(kP0);
    if (t.vdelp[1] ? t.old_grp[1] : t.grp[1]) enabled_ |= bit_of(kP1);
    if (t.enam[0] && !t.resmp[0]) enabled_ |= bit_of(kM0);
    if (t.enam[1] && !t.resmp[1]) enabled_ |= bit_of(kM1);
    if (t.vdelbl ? t.old_enabl : t.enabl) enabled_ |= bit_of(kBL);
    if (t.playfield) enabled_ |= bit_of(kPF);
    return enabled_;
}

const Mask& Beam::mask(int object) {
    Mask& mask = masks_[object];
    if (!(stale_ & bit_of(object))) return mask;
    stale_ &= ~bit_of(object);
    mask = object_mask(t_, object);
    return mask;
}

// Latches the collisions in pixels first .. last-1 of the line.
void Beam::collide(int first, int last) {
    Tia& t = t_;
    if (!collecting_ || (t.vblank & 2)) return;
    unsigned pairs = kPairsOf[enabled()] & ~t.collisions;
    if (!pairs) return;
    const Mask span = Mask::range(first, last);
    do {
        const Pair& pair = kPairOf[static_cast<size_t>(std::countr_zero(pairs))];
        pairs &= pairs - 1;
        if (meets(mask(pair.a) & span, mask(pair.b))) t.collisions |= pair.latch;
    } while (pairs);
}

// Draws pixels first .. last-1 of the line.
void Beam::draw(int first, int last) {
    const Tia& t = t_;
    uint8_t* row = row_at(line_end_);
    const unsigned objects = enabled();
    if ((t.vblank & 2) || !objects) {
        std::memset(row + first, t.vblank & 2 ? 0 : t.colour[3], static_cast<size_t>(last - first));
        return;
    }
    Mask lit[6];
    for (int object = kP0; object <= kPF; ++object)
        if (objects & bit_of(object)) lit[object] = mask(object);

    // Which pixels take the colour of player 0, of player 1, of the playfield; the rest is background.
    static constexpr Mask kLeft = Mask::range(0, 80);
    const bool score = t.ctrlpf & 2, playfield_first = t.ctrlpf & 4;
    const Mask side0 = lit[kP0] | lit[kM0], side1 = lit[kP1] | lit[kM1];
    Mask colour0, colour1, colour_pf;
    if (playfield_first) {
        colour_pf = lit[kPF] | lit[kBL];
        colour0 = without(side0, colour_pf);
        colour1 = without(side1, colour_pf | side0);
        if (score && objects == bit_of(kPF)) {
            colour0 = lit[kPF] & kLeft;
            colour1 = without(lit[kPF], kLeft);
            colour_pf = {};
        }
    } else {
        colour0 = score ? side0 | (lit[kPF] & kLeft) : side0;
        colour1 = without(score ? side1 | without(lit[kPF], kLeft) : side1, colour0);
        colour_pf = without(lit[kPF] | lit[kBL], colour0 | colour1);
    }
    const uint64_t c0 = repeated(t.colour[0]), c1 = repeated(t.colour[1]);
    const uint64_t cf = repeated(t.colour[2]), cb = repeated(t.colour[3]);
    uint64_t line[20];
    for (int group = first / 8; group <= (last - 1) / 8; ++group) {
        const auto eight = [&](const Mask& mask) { return kByteMasks[mask.word[group / 8] >> (group % 8 * 8) & 0xff]; };
        const uint64_t m0 = eight(colour0), m1 = eight(colour1), mf = eight(colour_pf);
        line[group] = (m0 & c0) | (m1 & c1) | (mf & cf) | (~(m0 | m1 | mf) & cb);
    }
    std::memcpy(row + first, reinterpret_cast<const uint8_t*>(line) + first, static_cast<size_t>(last - first));
}

}  // namespace atari
