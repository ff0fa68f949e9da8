// `Resizer`: reduces a frame to any size for which OpenCV's INTER_AREA takes means, equal to OpenCV in every byte.
//
// `AreaResize` serves most sizes. This class adds the sizes with whole scales in both directions, for which OpenCV sums
// blocks of pixels and rounds differently (105 x 80 of 210 x 160), and the frame's own size.
//
// A `SimdLevel` other than the chosen one is for tests: the results are the same.
#pragma once

#include <optional>

#include "area_resize.hpp"

namespace atari {

class Resizer {
  public:
    // Takes frames of rows x 160. Throws std::invalid_argument if the size is not within 1 x 1 .. rows x 160: for larger
    // sizes, INTER_AREA interpolates.
    Resizer(int rows, int height, int width, SimdLevel level = simd_level());

    // Writes height x width bytes. `changes` is as `pool_gray` writes it; null if every row is new.
    void operator()(const uint8_t* frame, const uint32_t* changes, uint8_t* out) const;

    // Returns the resizer of single rows; null if this size is served by sums of blocks or by a copy.
    const AreaResize* area_resize() const { return resize_ ? &*resize_ : nullptr; }

  private:
    void sum_blocks(const uint8_t* frame, uint8_t* out) const;

    int rows_, height_, width_;
    std::optional<AreaResize> resize_;
};

}  // namespace atari
