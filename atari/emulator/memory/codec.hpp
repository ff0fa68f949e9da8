// A lossless codec for the frames of a 2600, which repeat the row above or the frame before. Decoding copies.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace atari::memory {

// The most bytes that `encode` writes for a frame of `bytes` bytes.
constexpr size_t most_encoded(size_t bytes) { return bytes + 1; }

// Memory that `encode` reuses for the next frame.
struct EncoderScratch {
    std::vector<uint8_t> above, code;
};

// Writes the frame to `out`, and returns the number of bytes written. `before` is the frame that the decoder starts
// from, or null if the code must stand alone. `pitch` is the distance from a pixel to the pixel below it.
size_t encode(const uint8_t* frame, const uint8_t* before, size_t bytes, size_t pitch, uint8_t* out,
              EncoderScratch& scratch);

// Turns the frame before, in `frame`, into the encoded frame. Returns false if the code is damaged; `frame` then has
// any values. Reads and writes within these arrays for every code.
bool decode(const uint8_t* code, size_t size, uint8_t* frame, size_t bytes, size_t pitch);

// Returns whether a code needs no frame before it.
inline bool stands_alone(uint8_t first_byte) { return first_byte != 0; }

}  // namespace atari::memory
