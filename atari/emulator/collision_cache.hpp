// Collisions of a frame, found in its log as it grows: only of what differs from the frame before.
//
// A frame is cut into blocks of lines. A block that begins as it did in the frame before, and is written as then, leaves
// the same behind, and the collider (collider.hpp) goes on behind it. What a register holds that takes no part in the
// block, such as the place of an object that does not show, may differ.
//
// tests/emulator/test_fast_equals_plain.py compares with the plain TIA.
#pragma once

#include <cstdint>

#include "collider.hpp"
#include "line_difference.hpp"

namespace atari {

class CollisionCache {
  public:
    CollisionCache(Tia& tia, Collider& collider) : t_(tia), collider_(collider) {}

    // Begins a frame, whose writes will be at `log`, behind the collider. The log of the frame before must stay.
    void begin(const Write* log, unsigned latches);

    // Applies the writes, all there are up to a clock, and brings the collider to it. Collisions of everything before
    // `collisions_from` are left out: they will be cleared.
    void apply(const Write* first, const Write* last, const Write* collisions_from, int32_t clock);

    // From here on, collisions are not those that the frame before would have had; or that one is no longer known.
    void forget() {
        comparing_ = false;
        next_ = known_ = 0;
    }

  private:
    static constexpr int kLines = 8;
    static constexpr int kMostBlocks = 344 / kLines;

    struct Block {
        uint16_t first;       // write
        uint16_t collisions;  // at its beginning
        int32_t blanked_at;
        bool exact;           // they are; otherwise they will be cleared before they are read
        uint16_t acted;       // writes in it
        uint8_t involved;     // objects that show or are placed, and kPlacing
    };

    int32_t clock_of(int block) const { return frame_start_ + 228 * kLines * block; }
    void apply(const Write* first, const Write* last, bool exact, int32_t clock);
    const Write* begin_block(const Write* next, const Write* last, bool exact, int32_t clock);
    int written_alike_until(const Write* next, const Write* last, int32_t clock);

    Tia& t_;
    Collider& collider_;

    // What looking for repetitions costs, a frame and each block that is run, in writes that act (measured over all games).
    // Where that is more than the writes it saves, frames are run without: so many at first, twice as many each time.
    static constexpr int kFrameCost = 15, kBlockCost = 5, kMostCredit = 300, kShortRest = 16, kLongRest = 1024;
    int resting_ = 0, rest_ = kShortRest, credit_ = kMostCredit;
    bool comparing_ = false;

    // The complete blocks of the frame before, which are replaced by those of this one up to `next_`.
    int known_ = 0, next_ = 0;
    unsigned latches_ = 0;
    int32_t frame_start_ = 0;
    const Write *log_ = nullptr, *log_before_ = nullptr;
    uint64_t written_ = 0;         // registers, in this block so far
    int acted_ = 0;                // writes, in front of it
    int agreed_ = -1, moved_ = 0;  // writes up to `agreed_` of the frame before are those of this one, `moved_` further on
    Block blocks_[kMostBlocks + 1];
    TiaCommon beginnings_[kMostBlocks + 1];
    TiaPlaces places_[kMostBlocks + 1];
};

}  // namespace atari
