// The frames of a replay memory: a ring of rows, plain or compressed, and the final observations that have no row.
#pragma once

#include <memory>
#include <vector>

#include "codec.hpp"
#include "packed_frames.hpp"

namespace atari::memory {

// Rows that are not complete, and the row before them, are always plain; `row` returns them.
class Frames {
  public:
    Frames(const Geometry& geometry, const Layout& layout, uint8_t* block);

    // The frames of a row, lane by lane. If compressed, only the last stored row and the two rows after it have any.
    uint8_t* row(size_t part, int64_t row) const;
    // The offset of a row's frames in the block.
    size_t row_offset(size_t part, int64_t row) const { return static_cast<size_t>(this->row(part, row) - block_); }
    // The number of rows that have a place; and the place of a row, which is the same in all parts.
    int64_t places() const { return packed_ ? 3 : slots_; }
    int64_t place(int64_t row) const { return row % places(); }
    // Stores a row, whose frames are complete, and compresses it if the memory is compressed.
    void store(int64_t row);
    // Stores the frame after the frame of (row, lane), where `row` is the next row to store, or the last stored row.
    void store_final(size_t part, int64_t entry, int64_t row, int64_t lane, const uint8_t* frame);
    // A checksum of a stored row, or of a final observation, without the frames from which it is decoded.
    uint64_t check(int64_t row, uint64_t seed) const;
    uint64_t check_final(int64_t entry, uint64_t seed) const;

    PackedFrames* packed() const { return packed_.get(); }
    // Enters the frames of a file that was opened: rows `first` to `head` - 1, and final observations `first_final` to
    // `finals` - 1. Returns whether they can be read.
    bool reload(int64_t first, int64_t head, int64_t first_final, int64_t finals, const int64_t* owners);

    // Reads frames for one thread. Rows in ascending order are the fastest.
    class Reader {
      public:
        explicit Reader(const Frames& frames);
        // `head` is the pending row, which is plain. `ahead` is null, or a plain frame that is read soon.
        void read(size_t part, int64_t row, int64_t lane, int64_t head, uint8_t* to, const uint8_t* ahead = nullptr);
        void read_final(size_t part, int64_t entry, int64_t row, int64_t lane, int64_t head, uint8_t* to);

      private:
        const std::vector<uint8_t>& decode(size_t part, int64_t row, int64_t lane);
        struct Decoded {
            int64_t row = -1, lane = -1;
            std::vector<uint8_t> frame;
        };
        const Frames& frames_;
        std::vector<Decoded> decoded_;  // by part
    };

  private:
    size_t cell(int64_t row, int64_t lane) const { return static_cast<size_t>(row % slots_ * geometry_.lanes + lane); }
    size_t final_slot(int64_t entry) const { return static_cast<size_t>(entry % geometry_.finals); }
    PackedFrame* packed_table(size_t offset) const { return reinterpret_cast<PackedFrame*>(block_ + offset); }
    PackedFrame pack(size_t part, int64_t row, const uint8_t* frame, const uint8_t* before);

    const Geometry& geometry_;
    const Layout& layout_;
    uint8_t* const block_;
    const int64_t slots_;
    std::unique_ptr<PackedFrames> packed_;
    std::vector<uint8_t> code_;
    EncoderScratch scratch_;
};

}  // namespace atari::memory
