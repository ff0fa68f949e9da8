#include "collision_cache.hpp"

#include <algorithm>
#include <array>
#include <bit>

namespace atari {
namespace {

// Turning the search for collisions off and on again takes as long as about this many TIA writes.
constexpr int kFewWrites = 24;

// By object, the registers whose writes touch it. The last entry has the registers that place an object.
constexpr int kPlacingBit = std::countr_zero(kPlacing);
constexpr auto kTouching = [] {
    std::array<uint64_t, kPlacingBit + 1> table{};
    for (unsigned bit = 0; bit < table.size(); ++bit)
        table[bit] = registers_where([=](const TiaRegister& r) { return (r.objects >> bit & 1) != 0; });
    return table;
}();

// Returns the objects that take part in a block with this beginning and writes to these registers.
unsigned involved_in(const TiaCommon& begin, uint64_t written) {
    unsigned objects = 0;
    for (const uint8_t i : {0, 1}) {
        if (begin.grp[i] || begin.old_grp[i] || (written & kTouching[kP0 + i])) objects |= bit_of(kP0 + i);
        if ((begin.enam[i] && !begin.resmp[i]) || (written & kTouching[kM0 + i])) objects |= bit_of(kM0 + i);
    }
    if (begin.enabl || begin.old_enabl || (written & kTouching[kBL])) objects |= bit_of(kBL);
    if (written & kTouching[kPlacingBit]) objects |= kPlacing;
    return objects;
}

}  // namespace

void CollisionCache::begin(const TiaWrite* log, unsigned latches) {
    if (comparing_) credit_ -= kFrameCost;
    if (credit_ > kMostCredit) {
        credit_ = kMostCredit;
        rest_ = kShortRest;
    } else if (credit_ < 0) {
        credit_ = kMostCredit;
        resting_ = rest_;
        rest_ = std::min(2 * rest_, kLongRest);
    }
    const bool follows = comparing_ && latches == latches_ && t_.frame_start == frame_start_;
    known_ = follows ? std::max(next_ - 1, 0) : 0;
    comparing_ = resting_ == 0;
    if (!comparing_) {
        --resting_;
        known_ = 0;
    }
    next_ = 0;
    latches_ = latches;
    frame_start_ = t_.frame_start;
    log_before_ = log_;
    log_ = log;
    agreed_ = -1;
    written_ = 0;
    acted_ = 0;
}

void CollisionCache::apply(const TiaWrite* first, const TiaWrite* last, const TiaWrite* collisions_from,
                           int32_t clock) {
    if (collisions_from - first > kFewWrites) {
        collider_.collect(false);
        apply(first, collisions_from, false, static_cast<int32_t>(3 * collisions_from->cycle));
        collider_.collect(true);
        first = collisions_from;
    }
    apply(first, last, true, clock);
    collider_.reach(clock);
}

void CollisionCache::apply(const TiaWrite* first, const TiaWrite* last, bool exact, int32_t clock) {
    if (!comparing_) return collider_.apply(first, last);
    const TiaWrite* next = first;
    while (next_ <= kMostBlocks && clock_of(next_) <= clock) {
        const TiaWrite* const end = note_written(next, last, clock_of(next_));
        collider_.apply(next, end);
        next = begin_block(end, last, exact, clock);
    }
    note_written(next, last, INT32_MAX);
    collider_.apply(next, last);
}

// Notes in `written_` to which registers the writes before a clock go. Returns the end of these writes.
const TiaWrite* CollisionCache::note_written(const TiaWrite* write, const TiaWrite* last, int32_t clock) {
    uint64_t written = written_;
    for (; write != last && static_cast<int32_t>(3 * write->cycle) < clock; ++write) written |= kSetOf[write->reg];
    written_ = written;
    return write;
}

// Begins the next block with the write at `next`. If the following blocks repeat those of the previous frame, skips
// them and begins a later block. Returns the first write of the block that was begun.
const TiaWrite* CollisionCache::begin_block(const TiaWrite* next, const TiaWrite* last, bool exact, int32_t clock) {
    const TiaLine now = collider_.state_at(clock_of(next_));
    if (next_ > 0) {
        Block& ended = blocks_[next_ - 1];
        ended.involved = static_cast<uint8_t>(involved_in(beginnings_[next_ - 1], written_));
        ended.acted = static_cast<uint16_t>(collider_.acted() - acted_);
    }
    written_ = 0;
    acted_ = collider_.acted();
    credit_ -= kBlockCost;
    Block& block = blocks_[next_];
    const bool comparable = next_ < known_ && (!exact || block.collisions == t_.collisions);
    int until = comparable ? written_alike_until(next, last, clock) : next_;
    if (until > next_ && agree_but_for_colours(now, beginnings_[next_])) {
        const Difference differs = difference(now, places_[next_]);
        if (differs.objects)
            for (int i = next_; i < until; ++i)
                if (differs.objects & blocks_[i].involved) until = i;
        while (until > next_ && exact && !blocks_[until].exact) --until;
        if (until > next_) {
            carry(differs, places_ + next_, places_ + until + 1);
            for (int i = next_; i < until; ++i) credit_ += blocks_[i].acted;
            for (int i = next_; i <= until; ++i) {
                blocks_[i].first = static_cast<uint16_t>(blocks_[i].first + moved_);
                blocks_[i].exact &= exact;
            }
            next_ = until + 1;
            collider_.go_on_from({beginnings_[until], places_[until]}, blocks_[until].collisions,
                                 blocks_[until].blanked_at);
            return log_ + blocks_[until].first;
        }
    }
    block = {static_cast<uint16_t>(next - log_), t_.collisions, collider_.blanked_at(), exact, 0, 0};
    beginnings_[next_] = now;
    places_[next_] = now;
    ++next_;
    return next;
}

// Returns the first block after `next_` whose preceding TIA writes differ from those of the previous frame.
int CollisionCache::written_alike_until(const TiaWrite* next, const TiaWrite* last, int32_t clock) {
    const int place = blocks_[next_].first, moved = static_cast<int>(next - log_) - place;
    if (moved != moved_ || place > agreed_) {
        moved_ = moved;
        agreed_ = place;
    }
    const TiaWrite* disagrees = log_ + agreed_ + moved;
    const int comparable = std::min(static_cast<int>(last - disagrees), blocks_[known_].first - agreed_);
    const int more = agreeing(disagrees, log_before_ + agreed_, comparable);
    agreed_ += more;
    disagrees += more;

    int until = next_;
    while (until < known_ && blocks_[until + 1].first <= agreed_ && clock_of(until + 1) <= clock) ++until;
    if (disagrees != last)
        while (until > next_ && blocks_[until].first == agreed_ &&
               static_cast<int32_t>(3 * disagrees->cycle) < clock_of(until))
            --until;
    return until;
}

}  // namespace atari
