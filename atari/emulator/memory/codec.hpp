// A lossless codec for the frames of a 2600: they repeat the row above and the frame before, and are decoded by copies.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace atari::memory {

// The most bytes that `encode` writes for a frame of so many.
constexpr size_t most_encoded(size_t bytes) { return bytes + 1; }

// Memory that `encode` uses again at the next frame.
struct EncoderScratch {
    std::vector<uint8_t> above, code;
};

// Writes the frame to `out`, and returns how many bytes it took. `before` is the frame that the decoder will have, or
// null if it must have none. `pitch` is the distance of a pixel to the one below it.
size_t encode(const uint8_t* frame, const uint8_t* before, size_t bytes, size_t pitch, uint8_t* out,
              EncoderScratch& scratch);

// Turns the frame before, in `frame`, into the encoded one. Returns false if the code is damaged; `frame` then has any
// values. Reads and writes nothing else, whatever the code is.
bool decode(const uint8_t* code, size_t size, uint8_t* frame, size_t bytes, size_t pitch);

// Whether a code needs no frame before.
inline bool stands_alone(uint8_t first_byte) { return first_byte != 0; }

}  // namespace atari::memory
