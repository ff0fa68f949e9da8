// The sizes of a replay memory, and the layout of its one block of bytes, which is also its file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace atari::memory {

// The behaviour of a vector environment after the end of an episode; Gymnasium's `AutoresetMode`.
enum class Autoreset { kNextStep, kSameStep, kDisabled };

// One part of an observation: the image, or the RAM.
struct Part {
    size_t bytes;  // bytes of a frame
    size_t pitch;  // bytes from a pixel to the pixel below it
    int stack;     // the most frames in an observation
};

struct Geometry {
    int64_t lanes;
    int64_t rows;    // steps of a lane that can be sampled; a row is one step of all lanes
    int64_t margin;  // rows that can be written before they overwrite rows of the last saved state
    int64_t finals;  // space for final observations that have no row
    std::vector<Part> parts;
    size_t action_bytes;
    Autoreset autoreset;
    bool repeat_first;  // pad a stack with the first frame of the episode, not with zeros
    bool prioritised;
    double exponent;  // the exponent of priorities
    bool saved;       // whether the block is a file: rows then have checksums
    bool compressed;
    size_t packed_bytes;  // space for compressed frames

    // Throws std::invalid_argument if a number is out of range.
    void check() const;
    int most_frames() const;
    // Rows before the oldest step that its stack, or the decoding of this stack, may need.
    int64_t history() const;
    // Rows in the ring. The 2 are the pending row and the row that is being written.
    int64_t slots() const { return rows + history() + 2 + margin; }
    int64_t cells() const { return slots() * lanes; }
    // The most final observations of steps that can be sampled. In a file, an eighth of the space is for the steps before
    // the next save, because the final observations of the last save are not overwritten.
    int64_t kept_finals() const;
    size_t frame_bytes() const;  // bytes of a frame of all parts
};

// Rows are compressed in groups of 16: the first is decoded by itself, each other row from the row before.
constexpr int64_t kGroup = 16;

// The least `packed_bytes`: space for a few rows of frames that cannot be compressed.
size_t least_packed_bytes(const Geometry& geometry);

// A compressed frame lies within one chunk.
struct PackedFrame {
    uint64_t offset;
    uint32_t bytes;
    uint32_t unused;
};

// Byte offsets of the arrays in the block. Each begins at a multiple of 4096.
struct Layout {
    explicit Layout(const Geometry& geometry);

    size_t section_bytes;
    size_t sections[2];  // two places for the saved state, written in turn
    size_t actions, rewards, flags, checks;
    size_t final_owners, final_checks;
    std::vector<size_t> frames;  // by part: slots x lanes frames; if compressed, three rows of frames
    std::vector<size_t> finals;  // by part; empty if compressed
    std::vector<size_t> packed_frames, packed_finals;  // by part: tables of `PackedFrame`, which lie in `packed`
    size_t packed = 0;
    size_t bytes;
};

}  // namespace atari::memory
