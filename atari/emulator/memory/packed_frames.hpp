// The bytes of compressed frames: chunks that are filled one by one, and become free in the same order.
#pragma once

#include <deque>
#include <functional>
#include <queue>
#include <vector>

#include "geometry.hpp"

namespace atari::memory {

class PackedFrames {
  public:
    PackedFrames(const Geometry& geometry, uint8_t* bytes);

    // Returns whether n rows with a final observation in each lane fit.
    bool has_space(size_t n = 1) const { return free_.size() >= n * chunks_of_row_; }
    // Returns whether the rows from `oldest` on leave space for a row. In a file they leave an eighth of the space to the
    // rows that are written before the next save, because the rows of the last save stay as they are.
    bool may_keep(int64_t oldest) const;
    // Frees the chunks that have no row from `oldest` on.
    void release(int64_t oldest);
    // Stores the code of a frame. `row` must not decrease, and `has_space` must have been true for the row.
    PackedFrame store(const uint8_t* code, size_t size, int64_t row);
    // The code of a frame; null if the frame, which may be from a damaged file, does not lie within one chunk.
    const uint8_t* find(PackedFrame frame) const;
    size_t used_bytes() const { return used_.size() * chunk_; }

    // `clear` removes all frames. Then `enter` adds the frames of a file one by one, and returns false for a frame that
    // does not lie within one chunk. At the end `finish_entering` makes the lists of chunks.
    void clear();
    bool enter(PackedFrame frame, int64_t row);
    void finish_entering();

  private:
    struct Chunk {
        size_t index;
        int64_t newest;  // the newest row in it
        size_t end;      // bytes in use
    };

    size_t chunk_, chunks_, chunks_of_row_, spare_;
    uint8_t* bytes_;
    std::deque<Chunk> used_;                                                 // by age
    std::priority_queue<size_t, std::vector<size_t>, std::greater<>> free_;  // the lowest first: few are ever touched
    std::vector<Chunk> entered_;                                             // by index
};

}  // namespace atari::memory
