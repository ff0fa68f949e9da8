// Collisions of a frame, found in its write log as the log grows. Only blocks that differ from the previous frame are
// run.
//
// A frame is cut into blocks of lines. If a block has the same beginning state and the same TIA writes as in the
// previous frame, it has the same end state. The collider (collider.hpp) then resumes after the block. Registers that
// take no part in the block may differ, such as the position of an object that does not show.
//
// tests/emulator/test_fast_equals_plain.py compares this with the reference TIA.
#pragma once

#include <cstdint>

#include "collider.hpp"
#include "line_difference.hpp"

namespace atari {

class CollisionCache {
  public:
    CollisionCache(Tia& tia, Collider& collider) : t_(tia), collider_(collider) {}

    // Begins a frame whose TIA writes will be at `log`, after the collider began it. The previous frame's log must stay
    // valid.
    void begin(const TiaWrite* log, unsigned latches);

    // Applies all TIA writes up to `clock` and brings the collider to that clock. Collisions before `collisions_from`
    // are left out, because a CXCLR will clear them.
    void apply(const TiaWrite* first, const TiaWrite* last, const TiaWrite* collisions_from, int32_t clock);

    // To be called if the next frame cannot reuse the collisions of the blocks so far. That is so if the collisions
    // change by other means, or if the previous frame is not available any more.
    void forget() {
        comparing_ = false;
        next_ = known_ = 0;
    }

  private:
    static constexpr int kLines = 8;
    static constexpr int kMostBlocks = kMostLines / kLines;

    struct Block {
        uint16_t first;       // index of the block's first TIA write
        uint16_t collisions;  // latches at the block's beginning
        int32_t blanked_at;
        bool exact;        // `collisions` is exact; otherwise the latches will be cleared before they are read
        uint16_t acted;    // number of TIA writes in the block that acted
        uint8_t involved;  // objects that show or are placed, and kPlacing
    };

    int32_t clock_of(int block) const { return frame_start_ + kClocksPerLine * kLines * block; }
    void apply(const TiaWrite* first, const TiaWrite* last, bool exact, int32_t clock);
    const TiaWrite* note_written(const TiaWrite* write, const TiaWrite* last, int32_t clock);
    const TiaWrite* begin_block(const TiaWrite* next, const TiaWrite* last, bool exact, int32_t clock);
    int written_alike_until(const TiaWrite* next, const TiaWrite* last, int32_t clock);

    Tia& t_;
    Collider& collider_;

    // Costs of the search for repeated blocks, per frame and per block that is run, in TIA writes that act. If the
    // search costs more than it saves, it is off for kShortRest frames. Each further rest is twice as long, up to
    // kLongRest.
    static constexpr int kFrameCost = 15, kBlockCost = 5, kMostCredit = 300, kShortRest = 16, kLongRest = 1024;
    int resting_ = 0, rest_ = kShortRest, credit_ = kMostCredit;
    bool comparing_ = false;

    // `known_`: complete blocks of the previous frame. Blocks of the current frame replace them up to `next_`.
    int known_ = 0, next_ = 0;
    unsigned latches_ = 0;
    int32_t frame_start_ = 0;
    const TiaWrite *log_ = nullptr, *log_before_ = nullptr;
    uint64_t written_ = 0;  // registers written in the current block so far
    int acted_ = 0;         // TIA writes that acted before the current block
    // The log contains the previous frame's writes up to `agreed_`, `moved_` entries further on.
    int agreed_ = -1, moved_ = 0;
    Block blocks_[kMostBlocks + 1];
    TiaCommon beginnings_[kMostBlocks + 1];
    TiaPlaces places_[kMostBlocks + 1];
};

}  // namespace atari
