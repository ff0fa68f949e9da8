// `AreaResize`: reduces a gray frame, equal to OpenCV's INTER_AREA in every byte.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "fast/simd.hpp"
#include "machine/state.hpp"

namespace atari {

// Reduces a gray frame, rows x 160, to height x width. Each result is the mean of the area that it covers. Immutable,
// so threads may share one.
//
// Heights are within 1..rows, widths within 1..160, and rows at most kFrameRows; `Resizer` checks them.
class AreaResize {
  public:
    // Returns how many source pixels a result covers in one direction, with OpenCV's rounding: the inverse of an
    // inverse. OpenCV sums blocks of pixels if both scales are whole numbers, which 1 / (1 / 210) is not.
    static double scale(int source, int target);

    struct Tap {  // the share of a source pixel in a result
        int source, result;
        float weight;
        bool first, last;  // whether it is the result's first or last tap
    };
    // Returns the taps of all results in one direction, in their order, with OpenCV's weights.
    static std::vector<Tap> taps(int source, int target);

    AreaResize(int rows, int height, int width, SimdLevel level);

    // Writes height x width bytes. `changes` is as `pool_gray` writes it; null if every row is new.
    void operator()(const uint8_t* frame, const uint32_t* changes, uint8_t* out) const {
        make_rows(frame, changes, out, 0, height_);
    }

    // Writes rows first .. last-1 of the result, and nothing after them. They depend on the frame's rows from `sources(first).first` to
    // `sources(last - 1).last`. If `changes` is not null, all bits must be set for the first of these rows.
    void make_rows(const uint8_t* frame, const uint32_t* changes, uint8_t* out, int first, int last) const;

    struct Sources {
        int first, last;
    };
    Sources sources(int result) const { return sources_[static_cast<size_t>(result)]; }

    // The n-th tap of each of eight or sixteen neighbouring results. `pixel` is counted from the start of the results'
    // window. Its upper bytes are 0x80, for which a byte shuffle returns zeros. Unused taps have weight 0.
    struct Taps {
        uint32_t pixel[16];
        float weight[16];
    };

  private:
    // Neighbouring results that are computed at once and depend on pixels close together.
    struct Window {
        int source, result, count;
    };

    void make_windows(const std::vector<Tap>& across);
    uint32_t changed_windows(uint32_t changes) const;
    template <int lanes>
    void store(const uint8_t* bytes, uint8_t* out, const uint8_t* end) const;
    template <auto across, int lanes>
    void run(const uint8_t* frame, const uint32_t* changes, uint8_t* out, int first, int last) const;
    void run_simd128(const uint8_t* frame, const uint32_t* changes, uint8_t* out, int first, int last) const;
    void run_avx2(const uint8_t* frame, const uint32_t* changes, uint8_t* out, int first, int last) const;
    void run_avx512(const uint8_t* frame, const uint32_t* changes, uint8_t* out, int first, int last) const;

    int height_, width_;
    SimdLevel level_;
    std::vector<Tap> down_;  // ordered by source, and so by result
    std::vector<Sources> sources_;
    std::vector<size_t> first_taps_;                // by result, an index into down_
    std::vector<Window> windows_;                   // 21 at most
    uint32_t windows_with_[kScreenWidth / 8] = {};  // by columns 8k .. 8k+7, the windows in them, a bit each
    std::vector<Taps> across_;                      // depth_ for each window
    int depth_ = 0;                                 // the largest number of taps that a result has in its row
};

}  // namespace atari
