// The part of `Collider` about objects: the objects that could collide, and the TIA writes that could affect
// collisions.
#include <array>
#include <bit>

#include "collider.hpp"
#include "machine/console_config.hpp"
#include "machine/tia/object_mask.hpp"

namespace atari {
namespace {

// By the set of delayed players and ball, the registers of an object's look. A delayed copy changes when the other
// player's graphics are written.
constexpr auto kLooksOf = [] {
    std::array<std::array<uint64_t, 32>, 8> table{};
    for (unsigned delayed = 0; delayed < 8; ++delayed)
        for (unsigned objects = 0; objects < 32; ++objects) {
            uint64_t& looks = table[delayed][objects];
            for (unsigned i : {0u, 1u}) {
                if (objects >> (kP0 + i) & 1)
                    looks |= 1ull << (delayed >> i & 1 ? GRP1 - i : GRP0 + i) | 1ull << (REFP0 + i);
                if (objects >> (kM0 + i) & 1) looks |= 1ull << (ENAM0 + i);
            }
            if (objects >> kBL & 1) looks |= 1ull << (delayed & 4 ? GRP1 : ENABL);
        }
    return table;
}();

// By low and by high byte of a set of latches, the objects of these latches.
constexpr auto kObjectsIn = [] {
    std::array<std::array<uint8_t, 256>, 2> table{};
    for (unsigned latches = 0; latches < 256; ++latches)
        for (const Pair& pair : kPairs)
            for (unsigned high : {0u, 1u})
                if (latches << 8 * high & pair.latch)
                    table[high][latches] |= static_cast<uint8_t>(bit_of(pair.a) | bit_of(pair.b));
    return table;
}();
inline unsigned objects_in(unsigned latches) { return kObjectsIn[0][latches & 0xff] | kObjectsIn[1][latches >> 8]; }

// The playfield bits near a run of pixels. Indices: the reflect bit, the bit width of the run's width less one, the
// first pixel. The widths are those of `width_of`.
constexpr auto kPlayfieldNear = [] {
    std::array<std::array<std::array<uint32_t, kScreenWidth>, 7>, 2> table{};
    for (size_t reflect = 0; reflect < 2; ++reflect)
        for (size_t width = 0; width < 7; ++width)
            for (int x = 0; x < kScreenWidth; ++x) {
                const int pixels = width == 5 ? 17 : width == 6 ? 33 : 1 << width;
                table[reflect][width][static_cast<size_t>(x)] =
                    playfield_of_cells(cells_of_run(x, pixels), reflect != 0);
            }
    return table;
}();

// Double and quadruple size begin one pixel later.
constexpr int width_of_player(int mode) { return mode == 5 ? 17 : mode == 7 ? 33 : 8; }

// The playfield bits near all copies of a player. Indices: the reflect bit, the low bits of NUSIZ, the position.
constexpr auto kPlayfieldNearPlayer = [] {
    std::array<std::array<std::array<uint32_t, kScreenWidth>, 8>, 2> table{};
    for (size_t reflect = 0; reflect < 2; ++reflect)
        for (int mode = 0; mode < 8; ++mode)
            for (int x = 0; x < kScreenWidth; ++x)
                for (int copy = 0; copy < kCopies[mode].count; ++copy) {
                    const auto width =
                        static_cast<size_t>(std::bit_width(static_cast<unsigned>(width_of_player(mode)) - 1u));
                    const auto at = static_cast<size_t>((x + kCopies[mode].offset[copy]) % kScreenWidth);
                    table[reflect][static_cast<size_t>(mode)][static_cast<size_t>(x)] |=
                        kPlayfieldNear[reflect][width][at];
                }
    return table;
}();

}  // namespace

// To be called when an object appears or disappears.
void Collider::toggle(unsigned object) {
    enabled_ ^= bit_of(object);
    find_open_pairs();
    // Another object that is not enabled acts when it appears. The playfield does not, so its pairs count here.
    const unsigned pairs = kPairsOf[enabled_ | bit_of(kPF)] & unset_ & kPairsWith[bit_of(object)];
    if (enabled_ >> object & 1 && pairs) reconsider();
}

// To be called when the positions or sizes of objects change.
void Collider::moved(unsigned objects) {
    const unsigned pairs = kPairsWith[objects];
    stale_ |= objects;
    near_known_ &= ~objects;
    unknown_ |= pairs;
    if (open_pairs_ & pairs) reconsider();
}

void Collider::find_open_pairs() {
    unset_ = watched_ & ~static_cast<unsigned>(t_.collisions);
    open_pairs_ = kPairsOf[enabled_] & unset_;
    possible_ &= open_pairs_;
}

// Discards `possible_` and `acting_`.
void Collider::reconsider() {
    if (idle_) skip_to_pending();
    idle_ = known_ = chosen_ = false;
    acting_ = ~0ull;
}

// Finds the pairs of objects that may collide from here on.
void Collider::find_possible() {
    possible_ = 0;
    known_ = true;
    if (!collecting_ || (t_.vblank & kBlanks)) return;
    if (unset_ & kPairsWith[bit_of(kPF)]) bring_up(kPlayfieldRegisters);
    if (open_pairs_ & unknown_ & ~kPairsWith[bit_of(kPF)]) bring_up(kLooks);
    for (unsigned unknown = open_pairs_ & unknown_; unknown; unknown &= unknown - 1) {
        const Pair& pair = lowest_pair(unknown);
        if (may_touch(pair.a, pair.b)) touching_ |= pair.latch;
        else touching_ &= ~static_cast<unsigned>(pair.latch);
    }
    unknown_ &= ~open_pairs_;
    possible_ = open_pairs_ & touching_;
    if (possible_) bring_up(kLooks);  // an object may have disappeared
    known_ = true;
}

// Chooses the registers whose TIA writes could affect collisions from here on. These are the registers of objects that
// may collide at their positions, and those that could make an object appear. Two enabled objects that are apart do not
// act.
void Collider::choose_acting() {
    const Tia& t = t_;
    if (!known_) find_possible();
    // The line's end moves objects, so no write can be deferred.
    if (t.cosmic_ark || t.pf_reflect != (t.ctrlpf & kReflects)) return;
    chosen_ = true;
    acting_ = kAlwaysActing;
    if (t.skip_first[0] || t.skip_first[1] || t.m0_variant != kPlain) acting_ |= set_of({STILL});
    if (!collecting_ || (t.vblank & kBlanks)) return;
    const unsigned objects = (objects_in(unset_) & ~enabled_) | objects_in(possible_);
    acting_ |= kLooksOf[t.vdelp[0] | t.vdelp[1] << 1 | t.vdelbl << 2][objects & 31];
    acting_playfield_ = 0;
    unsigned pairs = kPairsOf[enabled_ | bit_of(kPF)] & unset_ & kPairsWith[bit_of(kPF)];
    if (!(enabled_ & bit_of(kPF)) && pairs) acting_playfield_ = ~0u;
    else
        for (; pairs; pairs &= pairs - 1) acting_playfield_ |= playfield_near(lowest_pair(pairs).a);
    if (acting_playfield_ & 0xf) acting_ |= set_of({PF0});
    if (acting_playfield_ & 0xff0) acting_ |= set_of({PF1});
    if (acting_playfield_ & 0xff000) acting_ |= set_of({PF2});
}

// Returns whether two objects could share a pixel at their positions, for any player graphics.
bool Collider::may_touch(unsigned a, unsigned b) {
    if (b == kPF) return t_.playfield && (playfield_near(a) & t_.playfield);
    const int width_a = width_of(a), width_b = width_of(b);
    bool touch = false;
    visit_copies(a, [&](int xa) {
        visit_copies(b, [&](int xb) {
            const int behind = (xb - xa + 2 * kScreenWidth) % kScreenWidth;
            touch |= behind < width_a || behind + width_b > kScreenWidth;
        });
    });
    return touch;
}

// Returns the playfield bits that an object could collide with at its position, in cells of four pixels.
uint32_t Collider::playfield_near(unsigned object) {
    const size_t reflect = t_.pf_reflect ? 1 : 0;
    if (object <= kP1) return kPlayfieldNearPlayer[reflect][t_.nusiz[object] & 7][t_.pos[object]];
    if (!(near_known_ & bit_of(object))) {
        near_known_ |= bit_of(object);
        const auto& near = kPlayfieldNear[reflect][static_cast<size_t>(std::bit_width(width_of(object) - 1u))];
        near_[object] = 0;
        visit_copies(object, [&](int x) { near_[object] |= near[static_cast<size_t>(x % kScreenWidth)]; });
    }
    return near_[object];
}

// Returns the largest width of each copy of an object, in pixels.
inline int Collider::width_of(unsigned object) const {
    const Tia& t = t_;
    if (object == kBL) return 1 << (t.ctrlpf >> 4 & 3);
    if (object >= kM0) return 1 << ((t.nusiz[object - kM0] >> 4 & 3) | (t.m0_variant == kWide ? 1 : 0));
    return width_of_player(t.nusiz[object] & 7);
}

// Calls `visit` with the first pixel of each copy of an object, not wrapped.
template <typename Visit>
inline void Collider::visit_copies(unsigned object, Visit&& visit) const {
    const int position = t_.pos[object];
    if (object == kBL) return visit(position);
    const auto& copies = kCopies[t_.nusiz[object & 1] & 7];
    for (int copy = 0; copy < copies.count; ++copy) visit(position + copies.offset[copy]);
}

inline const Mask& Collider::mask(unsigned object) {
    if (stale_ & bit_of(object)) {
        stale_ &= ~bit_of(object);
        make_mask(masks_[object], t_, static_cast<int>(object));
    }
    return masks_[object];
}

// Latches the collisions in pixels first .. last-1 of the line.
void Collider::collide(int first, int last) {
    if (!known_) find_possible();
    unsigned pairs = possible_;
    if (!pairs) return;
    const Mask span = Mask::range(first, last);
    for (; pairs; pairs &= pairs - 1) {
        const Pair& pair = lowest_pair(pairs);
        if (!meets(mask(pair.a) & span, mask(pair.b))) continue;
        t_.collisions |= pair.latch;
        find_open_pairs();
        reconsider();
    }
}

}  // namespace atari
