// Makes a picture smaller, to any size that OpenCV's INTER_AREA makes by taking means, and equal to it in every byte.
//
// `AreaResize` does what matters. Left over are sizes that divide the picture's, for which OpenCV sums whole blocks of
// pixels, and the size of the picture itself.
#pragma once

#include <optional>

#include "observation.hpp"

namespace atari {

class Scaler {
  public:
    // From rows x 160. Throws std::invalid_argument if the size is not served: more than the picture's, or narrower than
    // 11 without dividing it.
    Scaler(int rows, int height, int width);

    // `changes` as `pool_gray` tells them; null takes every row for a new one.
    void operator()(const uint8_t* picture, const uint32_t* changes, uint8_t* out) const;

    // What can make single rows of the result, or null.
    const AreaResize* by_rows() const { return resize_ ? &*resize_ : nullptr; }

  private:
    void sum_blocks(const uint8_t* picture, uint8_t* out) const;

    int rows_, height_, width_;
    std::optional<AreaResize> resize_;
};

}  // namespace atari
