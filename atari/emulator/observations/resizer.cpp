#include "resizer.hpp"

#include <cmath>
#include <cstring>
#include <stdexcept>
#include <string>

namespace atari {

Resizer::Resizer(int rows, int height, int width, SimdLevel level) : rows_(rows), height_(height), width_(width) {
    if (rows < 1 || rows > kFrameRows || height < 1 || height > rows || width < 1 || width > kScreenWidth)
        throw std::invalid_argument("a frame of " + std::to_string(rows) + " x 160 pixels cannot be made " +
                                    std::to_string(height) + " x " + std::to_string(width) +
                                    ": the height must be within 1.." + std::to_string(rows) +
                                    ", the width within 1..160");
    const double down = AreaResize::scale(rows, height), across = AreaResize::scale(kScreenWidth, width);
    if (down != std::floor(down) || across != std::floor(across)) resize_.emplace(rows, height, width, level);
}

void Resizer::operator()(const uint8_t* frame, const uint32_t* changes, uint8_t* out) const {
    if (resize_) (*resize_)(frame, changes, out);
    else if (height_ == rows_ && width_ == kScreenWidth)
        std::memcpy(out, frame, static_cast<size_t>(rows_) * kScreenWidth);
    else sum_blocks(frame, out);
}

// OpenCV rounds halves up in blocks of 2 x 2. In other blocks it rounds to even, after a multiplication in float.
void Resizer::sum_blocks(const uint8_t* frame, uint8_t* out) const {
    const int down = rows_ / height_, across = kScreenWidth / width_;
    const float share = static_cast<float>(1.0 / (down * across));
    for (int y = 0; y < height_; ++y)
        for (int x = 0; x < width_; ++x) {
            const uint8_t* block = frame + kScreenWidth * down * y + across * x;
            int sum = 0;
            for (int row = 0; row < down; ++row, block += kScreenWidth)
                for (int column = 0; column < across; ++column) sum += block[column];
            *out++ = static_cast<uint8_t>(down == 2 && across == 2 ? (sum + 2) >> 2
                                                                   : std::lrint(static_cast<float>(sum) * share));
        }
}

}  // namespace atari
