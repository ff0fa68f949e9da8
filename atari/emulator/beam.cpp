#include "beam.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "console.hpp"
#include "paint.hpp"
#include "tia_registers.hpp"

#if defined(__GNUC__)
#define INLINE [[gnu::always_inline]] inline
#else
#define INLINE __forceinline
#endif

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

// The collision latches that an object has a part in.
constexpr auto kPairsWith = [] {
    std::array<uint16_t, 6> table{};
    for (const Pair& pair : kPairs) {
        table[pair.a] |= pair.latch;
        table[pair.b] |= pair.latch;
    }
    return table;
}();

// The pair of each latch.
constexpr auto kPairOf = [] {
    std::array<Pair, 16> table{};
    for (const Pair& pair : kPairs) table[static_cast<size_t>(std::countr_zero(pair.latch))] = pair;
    return table;
}();

const Painter kPaint = best_painter();

constexpr unsigned bit_of(unsigned object) { return 1u << object; }

}  // namespace

void Beam::begin(Work work, unsigned latches, uint8_t* pixels) {
    const Tia& t = t_;
    work_ = work;
    watched_ = latches;
    line_end_ = line_end();
    if (pixels) row_ = pixels + kScreenWidth * ((line_end_ - t.draw_start) / 228 - 1);
    first_cycle_ = static_cast<uint32_t>(t.frame_start / 3);
    blanked_at_ = t.draw_start;
    line_end_acts_ = true;
    quiet_ = layers_known_ = false;
    stale_ = 0x3f;
    cells_stale_ = true;
    unknown_ = 0xffff;
    for (unsigned player : {0u, 1u}) {
        enable(kP0 + player, t.vdelp[player] ? t.old_grp[player] : t.grp[player]);
        enable(kM0 + player, t.enam[player] && !t.resmp[player]);
    }
    enable(kBL, t.vdelbl ? t.old_enabl : t.enabl);
    enable(kPF, t.playfield);
    find_open_pairs();
}

void Beam::apply(const Write* first, const Write* last, const Write* collisions_from) {
    if (work_ == kCollisions) apply_all<kCollisions>(first, last, collisions_from);
    else apply_all<kPixels>(first, last, collisions_from);
}

void Beam::reach(int32_t clock) {
    Tia& t = t_;
    t.pending = std::max(t.pending, clock);
    if (work_ == kCollisions) advance<kCollisions>(t.pending);
    else advance<kPixels>(t.pending);
}

const Write* Beam::draw_line(const Write* first, const Write* last, int32_t line_end) {
    Tia& t = t_;
    begin_line();
    int32_t pending = t.pending;
    const Write* write = first;
    for (; write != last && static_cast<int32_t>(3 * write->cycle) < line_end; ++write)
        apply_one<kPixels>(t, *write, pending);
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

void Beam::finish() {
    Tia& t = t_;
    if (t.hmove_blank && blank_is_over()) t.hmove_blank = false;
    t.to_line_end = line_end() - t.drawn_to;
    const int32_t drawn = t.drawn_to - t.draw_start;
    t.write_pos = drawn / 228 * kScreenWidth + std::max(0, drawn % 228 - 68);
}

template <Beam::Work work>
void Beam::apply_all(const Write* first, const Write* last, const Write* collisions_from) {
    const Write* const unwatched = std::clamp(collisions_from, first, last);
    collecting_ = false;
    apply_range<work>(first, unwatched);
    collecting_ = true;
    quiet_ = false;
    apply_range<work>(unwatched, last);
}

template <Beam::Work work>
INLINE void Beam::apply_range(const Write* first, const Write* last) {
    int32_t pending = t_.pending;
    for (const Write* write = first; write != last; ++write) apply_one<work>(t_, *write, pending);
    t_.pending = pending;
}

template <Beam::Work work>
INLINE void Beam::apply_one(Tia& t, const Write& write, int32_t& pending) {
    const unsigned reg = write.reg;
    const uint8_t value = write.value;
    const uint32_t cycle = write.cycle - first_cycle_;
    const auto clock = static_cast<int32_t>(3 * write.cycle);
    pending = std::max(pending, clock + kDelays[reg][cycle & 3]);
    const auto hpos = [&] { return static_cast<int>(3 * (cycle % 76)); };
    switch (reg) {
        case VBLANK:
            if ((t.vblank ^ value) & 2) advance<work>(pending);
            t.vblank = value;
            quiet_ = false;
            break;
        case NUSIZ0: case NUSIZ1: write_nusiz<work>(reg - NUSIZ0, value, pending); break;
        case COLUP0: case COLUP1: case COLUPF: case COLUBK: {
            const auto colour = static_cast<uint8_t>((value & 0xfe) | (config_.pal ? t.last_line_count & 1 : 0));
            uint8_t& field = t.colour[reg - COLUP0];
            if (work == kPixels && field != colour) advance<work>(pending);  // colours do not collide
            field = colour;
            break;
        }
        case CTRLPF: {
            const bool mirror = hpos() < 147 ? value & 1 : t.pf_mirror != 0;
            if (t.ctrlpf == value && t.pf_mirror == mirror) break;
            advance<work>(pending);
            t.ctrlpf = value;
            if (t.pf_mirror != mirror) moved(kPF);
            t.pf_mirror = mirror;
            if (mirror != (value & 1)) {
                line_end_matters();
            }
            moved(kBL);
            break;
        }
        case REFP0: case REFP1: {
            const unsigned player = reg - REFP0;
            involved_ |= bit_of(player);
            if (t.refp[player] == ((value & 8) != 0)) break;
            advance<work>(pending);
            t.refp[player] = value & 8;
            outdate(bit_of(player));
            break;
        }
        case PF0: write_playfield<work>((t.playfield & ~0xfu) | value >> 4, pending); break;
        case PF1: write_playfield<work>((t.playfield & ~0xff0u) | uint32_t{value} << 4, pending); break;
        case PF2: write_playfield<work>((t.playfield & ~0xff000u) | uint32_t{value} << 12, pending); break;
        case RESP0: case RESP1: reset_player<work>(reg - RESP0, hpos(), clock, pending); break;
        case RESM0: case RESM1: {
            const unsigned second = reg - RESM0;
            involved_ |= bit_of(kM0 + second) | kPlacing;
            advance<work>(pending);
            t.pos[kM0 + second] = strobe_missile(second, hpos(), static_cast<uint32_t>(clock - t.last_hmove));
            if (second == 0) t.m0_variant = kPlain;
            moved(kM0 + second);
            break;
        }
        case RESBL:
            involved_ |= bit_of(kBL) | kPlacing;
            advance<work>(pending);
            t.pos[kBL] = strobe_ball(hpos(), static_cast<uint32_t>(clock - t.last_hmove));
            moved(kBL);
            break;
        case GRP0: write_graphics<work>(0, value, pending); break;
        case GRP1: write_graphics<work>(1, value, pending); break;
        case ENAM0: case ENAM1: {
            const unsigned missile = reg - ENAM0;
            if (t.enam[missile] == ((value & 2) != 0)) break;
            if (!t.resmp[missile]) {
                advance<work>(pending);
                enable(kM0 + missile, value & 2);
            }
            t.enam[missile] = value & 2;
            break;
        }
        case ENABL:
            involved_ |= bit_of(kBL);
            if (t.enabl == ((value & 2) != 0)) break;
            if (!t.vdelbl) {
                advance<work>(pending);
                enable(kBL, value & 2);
            }
            t.enabl = value & 2;
            break;
        case HMM0:  // kept only if the motion goes from 7 to 6
            involved_ |= kPlacing;
            if (static_cast<uint32_t>(clock - t.last_hmove) != 63) break;
            advance<work>(pending);
            t.cosmic_ark = true;
            line_end_matters();
            t.ark_counter = 0;
            break;
        case VDELP0: case VDELP1: {
            const unsigned player = reg - VDELP0;
            if (t.vdelp[player] == ((value & 1) != 0)) break;
            advance<work>(pending);
            t.vdelp[player] = value & 1;
            show(player);
            break;
        }
        case VDELBL:
            involved_ |= bit_of(kBL);
            if (t.vdelbl == ((value & 1) != 0)) break;
            advance<work>(pending);
            t.vdelbl = value & 1;
            enable(kBL, t.vdelbl ? t.old_enabl : t.enabl);
            break;
        case RESMP0: case RESMP1: {
            const unsigned second = reg - RESMP0;
            if (t.resmp[second] == ((value & 2) != 0)) break;
            advance<work>(pending);
            if (t.resmp[second]) {
                involved_ |= bit_of(second) | bit_of(kM0 + second);
                t.pos[kM0 + second] = released_missile(t.pos[second], t.nusiz[second] & 7);
                if (second == 0) t.m0_variant = kPlain;
                moved(kM0 + second);
            }
            t.resmp[second] = value & 2;
            enable(kM0 + second, t.enam[second] && !t.resmp[second]);
            break;
        }
        case HMOVE: move_objects<work>(write, cycle % 76, clock, pending); break;
        case CXCLR:
            advance<work>(pending);
            t.collisions = 0;
            find_open_pairs();
            break;
        default: break;
    }
}

void Beam::find_open_pairs() {
    open_pairs_ = kPairsOf[enabled_] & watched_ & ~t_.collisions;
    quiet_ = false;
}

// The graphics of a player that show have changed.
inline void Beam::show(unsigned player) {
    const Tia& t = t_;
    enable(player, t.vdelp[player] ? t.old_grp[player] : t.grp[player]);
    outdate(bit_of(player));
}

// The place or the size of an object has changed.
inline void Beam::moved(unsigned object) {
    outdate(bit_of(object));
    cells_stale_ |= object == kPF;
    const unsigned pairs = kPairsWith[object];
    unknown_ |= pairs;
    if (open_pairs_ & pairs) quiet_ = false;
}

template <Beam::Work work>
inline void Beam::write_playfield(uint32_t value, int32_t pending) {
    if (t_.playfield == value) return;
    advance<work>(pending);
    t_.playfield = value;
    enable(kPF, value);
    moved(kPF);
}

template <Beam::Work work>
void Beam::write_nusiz(unsigned player, uint8_t value, int32_t pending) {
    Tia& t = t_;
    const bool ark = player == 0 && (t.cosmic_ark || t.m0_variant != kPlain);
    if (((t.nusiz[player] ^ value) & 0x37) || t.skip_first[player] || ark) {
        advance<work>(pending);
        t.skip_first[player] = false;
        if (player == 0) t.m0_variant = kPlain;
        moved(kP0 + player);
        moved(kM0 + player);
    }
    t.nusiz[player] = value;
}

// A write to one player's graphics also moves the other's new graphics to its delayed copy.
template <Beam::Work work>
inline void Beam::write_graphics(unsigned player, uint8_t value, int32_t pending) {
    Tia& t = t_;
    const unsigned other = player ^ 1;
    const bool own = !t.vdelp[player] && t.grp[player] != value;
    const bool others = t.vdelp[other] && t.old_grp[other] != t.grp[other];
    const bool ball = player == 1 && t.vdelbl && t.old_enabl != t.enabl;
    if (own || others || ball) advance<work>(pending);
    t.grp[player] = value;
    t.old_grp[other] = t.grp[other];
    if (player == 1) t.old_enabl = t.enabl;
    if (own) show(player);
    if (others) show(other);
    if (ball) enable(kBL, t.old_enabl);
}

template <Beam::Work work>
void Beam::reset_player(unsigned player, int hpos, int32_t clock, int32_t& pending) {
    Tia& t = t_;
    involved_ |= bit_of(player);
    const uint8_t position = strobe_player(hpos);
    const PlayerStrobe strobe = player_strobe(position, t.pos[player], t.nusiz[player] & 7);
    if (strobe.goes_on) pending = std::max(pending, clock + 11);
    advance<work>(pending);
    t.pos[player] = position;
    t.skip_first[player] = strobe.hidden;
    if (strobe.hidden) line_end_matters();
    moved(kP0 + player);
}

template <Beam::Work work>
inline void Beam::move_objects(const Write& write, uint32_t cycle_in_line, int32_t clock, int32_t pending) {
    Tia& t = t_;
    advance<work>(pending);
    const bool ordinary = cycle_in_line <= 3 || cycle_in_line == 75;
    if (config_.hmove_blanks && (cycle_in_line <= 20 || cycle_in_line == 75)) {
        t.hmove_blank = true;
        blanked_at_ = t.drawn_to;
    }
    if (!ordinary || write.motions || write.value) {
        const auto& distances = kMotion[cycle_in_line];
        for (int object = kP0; object <= kBL; ++object) {
            const int distance = distances[object == kBL ? write.value : write.motions >> (4 * object) & 15];
            if (distance == 0) continue;
            const int position = t.pos[object] + distance;
            t.pos[object] = static_cast<uint8_t>(position < 0 ? position + 160 : position >= 160 ? position - 160 : position);
            moved(object);
        }
    }
    if (t.skip_first[0] || t.skip_first[1]) {
        outdate(bit_of(kP0) | bit_of(kP1));
        t.skip_first[0] = t.skip_first[1] = false;
    }
    if (t.m0_variant != kPlain) {
        t.m0_variant = kPlain;
        moved(kM0);
    }
    t.last_hmove = clock;
    involved_ |= kPlacing;
    t.cosmic_ark = false;
}

// The end of the line in which drawing goes on. Exactly at an end it is this end: what a line's end does happens only
// when drawing goes strictly past it.
inline int32_t Beam::line_end() const {
    const int32_t drawn = t_.drawn_to - t_.draw_start;
    return drawn == 0 ? t_.draw_start + 228 : t_.draw_start + (drawn + 227) / 228 * 228;
}

// Whether the blank of the last HMOVE has been drawn: eight pixels of the line in which drawing was then, or of the next
// one if it was past them already.
bool Beam::blank_is_over() const {
    const int32_t line = (blanked_at_ - t_.draw_start) / 228 * 228, in_line = (blanked_at_ - t_.draw_start) % 228;
    return t_.drawn_to - t_.draw_start >= line + 76 + (in_line >= 76 ? 228 : 0);
}

// Brings the picture or the collisions up to a clock, or to the end of what shows.
template <Beam::Work work>
INLINE void Beam::advance(int32_t pending) {
    Tia& t = t_;
    if (pending < t.draw_start || t.drawn_to >= t.draw_stop || t.drawn_to >= pending) return;
    const int32_t target = std::min(pending, t.draw_stop);
    if (work == kPixels && !t.hmove_blank && target <= line_end_ - kScreenWidth) {
        t.drawn_to = target;  // still in front of the first pixel
        return;
    }
    if (work == kCollisions) {
        if (!quiet_) quiet_ = !line_end_acts_ && !possible_pairs();
        if (quiet_) {
            t.drawn_to = target;
            return;
        }
    }
    go_to<work>(target);
}

template <Beam::Work work>
void Beam::go_to(int32_t target) {
    Tia& t = t_;
    constexpr bool drawing = work == kPixels;
    int32_t end = drawing ? line_end_ : line_end();
    while (target > end) {
        line_part<work>(end, end);
        end_line();
        int32_t lines = 1;
        const int32_t left = target - end - 228;
        if (left > 228 && !t.cosmic_ark && !(drawing && t.hmove_blank)) {
            // Several whole lines are alike: the first and the last of them are run as usual.
            lines = 1 + (left - 1) / 228;
            if constexpr (drawing) {
                row_ += kScreenWidth;
                line_part<work>(end + 228, end + 228);
                for (int32_t i = 1; i < lines - 1; ++i) std::memcpy(row_ + i * kScreenWidth, row_, kScreenWidth);
                row_ -= kScreenWidth;
            }
        }
        end += 228 * lines;
        t.drawn_to = end - 228;
        if constexpr (drawing) row_ += kScreenWidth * lines;
    }
    line_end_ = end;
    line_part<work>(end, target);
}

// The rest of a line, or a part of it.
template <Beam::Work work>
inline void Beam::line_part(int32_t line_end, int32_t until) {
    Tia& t = t_;
    const int from = 228 - (line_end - t.drawn_to), to = 228 - (line_end - until);
    t.drawn_to = until;
    const bool visible = to > 68 && to > from;
    if (work == kCollisions && visible) collide(std::max(from - 68, 0), to - 68);
    if constexpr (work == kPixels) {
        if (visible) draw(std::max(from - 68, 0), to - 68);
        if (t.hmove_blank && from < 76) {
            // Eight pixels are black. Where drawing stops in front of them this reaches further, as in the reference.
            const int behind_blank = std::max(from, std::min(68, to));
            if (behind_blank == 68) std::memset(row_, 0, 8);
            else std::memset(row_ + std::max(behind_blank - 68, 0), 0, static_cast<size_t>(76 - behind_blank));
            if (to >= 76) t.hmove_blank = false;
        }
    }
}

void Beam::end_line() {
    Tia& t = t_;
    if (!line_end_acts_) return;
    line_end_acts_ = t.cosmic_ark;
    if (t.pf_mirror != (t.ctrlpf & 1)) {
        t.pf_mirror = t.ctrlpf & 1;
        moved(kPF);
    }
    for (int player : {0, 1}) {
        if (!t.skip_first[player]) continue;
        t.skip_first[player] = false;
        outdate(bit_of(player));
    }
    if (t.cosmic_ark) {
        static constexpr uint8_t kStep[4] = {18, 33, 0, 17};
        t.ark_counter = (t.ark_counter + 1) & 3;
        t.pos[kM0] = static_cast<uint8_t>((t.pos[kM0] + 160 - kStep[t.ark_counter]) % 160);
        t.m0_variant = t.ark_counter == 1 ? kWide : t.ark_counter == 2 ? kOff : kPlain;
        moved(kM0);
    }
}

inline const Mask& Beam::mask(int object) {
    if (stale_ & bit_of(object)) {
        stale_ &= ~bit_of(object);
        masks_[object] = object_mask(t_, object);
    }
    return masks_[object];
}

// Copies of a player or missile, and how many pixels wide each can be.
inline int Beam::width_of(unsigned object) const {
    const Tia& t = t_;
    if (object == kBL) return 1 << (t.ctrlpf >> 4 & 3);
    if (object >= kM0) return 1 << ((t.nusiz[object - kM0] >> 4 & 3) | (t.m0_variant == kWide ? 1 : 0));
    const int mode = t.nusiz[object] & 7;
    return mode == 5 ? 17 : mode == 7 ? 33 : 8;  // wide players begin a pixel late
}

// Calls `visit` with the first pixel of each copy of an object, not wrapped.
template <typename Visit>
inline void Beam::visit_copies(unsigned object, Visit&& visit) const {
    const int position = t_.pos[object];
    if (object == kBL) return visit(position);
    const auto& copies = kCopies[t_.nusiz[object & 1] & 7];
    for (int copy = 0; copy < copies.count; ++copy) visit(position + copies.offset[copy]);
}

// Whether two objects could share a pixel where they are now, whatever the graphics of players.
bool Beam::may_touch(unsigned a, unsigned b) {
    bool touch = false;
    if (b == kPF) {
        // Cells of four pixels are near enough.
        if (cells_stale_) {
            cells_stale_ = false;
            cells_ = playfield_cells(t_.playfield, t_.pf_mirror);
        }
        const int width = width_of(a);
        visit_copies(a, [&](int x) { touch |= (cells_of_run(x % kScreenWidth, width) & cells_) != 0; });
        return touch;
    }
    const int width_a = width_of(a), width_b = width_of(b);
    visit_copies(a, [&](int xa) {
        visit_copies(b, [&](int xb) {
            const int behind = (xb - xa + 2 * kScreenWidth) % kScreenWidth;
            touch |= behind < width_a || behind + width_b > kScreenWidth;
        });
    });
    return touch;
}

// Pairs of objects that may collide in what is drawn next and whose latch is still open.
inline unsigned Beam::possible_pairs() {
    const Tia& t = t_;
    if (!collecting_ || (t.vblank & 2)) return 0;
    const unsigned pairs = open_pairs_;
    for (unsigned unknown = pairs & unknown_; unknown; unknown &= unknown - 1) {
        const Pair& pair = kPairOf[static_cast<size_t>(std::countr_zero(unknown))];
        unknown_ &= ~static_cast<unsigned>(pair.latch);
        if (may_touch(pair.a, pair.b)) touching_ |= pair.latch;
        else touching_ &= ~static_cast<unsigned>(pair.latch);
    }
    return pairs & touching_;
}

// Latches the collisions in pixels first .. last-1 of the line.
void Beam::collide(int first, int last) {
    Tia& t = t_;
    unsigned pairs = possible_pairs();
    if (!pairs) return;
    const Mask span = Mask::range(first, last);
    do {
        const Pair& pair = kPairOf[static_cast<size_t>(std::countr_zero(pairs))];
        pairs &= pairs - 1;
        if (!meets(mask(pair.a) & span, mask(pair.b))) continue;
        t.collisions |= pair.latch;
        find_open_pairs();
    } while (pairs);
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
    Mask lit[6];
    for (int object = kP0; object <= kPF; ++object)
        if (enabled_ & bit_of(object)) lit[object] = mask(object);
    static constexpr Mask kLeft = Mask::range(0, 80);
    const bool score = t_.ctrlpf & 2, playfield_first = t_.ctrlpf & 4;
    const Mask side0 = lit[kP0] | lit[kM0], side1 = lit[kP1] | lit[kM1];
    Layers& layers = layers_;
    if (playfield_first) {
        layers.playfield = lit[kPF] | lit[kBL];
        layers.player0 = without(side0, layers.playfield);
        layers.player1 = without(side1, layers.playfield | side0);
        if (score && enabled_ == bit_of(kPF)) {
            layers.player0 = lit[kPF] & kLeft;
            layers.player1 = without(lit[kPF], kLeft);
            layers.playfield = {};
        }
    } else {
        layers.player0 = score ? side0 | (lit[kPF] & kLeft) : side0;
        layers.player1 = without(score ? side1 | without(lit[kPF], kLeft) : side1, layers.player0);
        layers.playfield = without(lit[kPF] | lit[kBL], layers.player0 | layers.player1);
    }
}

}  // namespace atari
