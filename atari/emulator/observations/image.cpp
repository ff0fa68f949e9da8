#include "image.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <vector>

#include "area_resize.hpp"

namespace atari {
namespace {

// Rounds to nearest, ties to even: the last bit of so large a number is worth one.
uint8_t rounded(float value) { return static_cast<uint8_t>(std::bit_cast<uint32_t>(value + 12582912.0f)); }

// The weights of neighbouring source pixels in each result of a row: `depth` for each result, from pixel `first` on.
// Results with fewer taps have weights of 0, which add nothing.
struct Across {
    int depth = 0;
    std::vector<int> first;
    std::vector<float> weights;

    Across(int source, int target) : first(static_cast<size_t>(target)) {
        const std::vector<AreaResize::Tap> taps = AreaResize::taps(source, target);
        std::vector<int> counts(first.size());
        for (const AreaResize::Tap& tap : taps) depth = std::max(depth, ++counts[static_cast<size_t>(tap.result)]);
        weights.resize(first.size() * static_cast<size_t>(depth));
        for (const AreaResize::Tap& tap : taps) {
            const auto result = static_cast<size_t>(tap.result);
            if (tap.first) first[result] = std::min(tap.source, source - depth);
            weights[result * static_cast<size_t>(depth) + static_cast<size_t>(tap.source - first[result])] = tap.weight;
        }
    }

    // Writes the results of a row. Each product is rounded before it is added, in the order of the pixels.
    template <int channels>
    void run(const uint8_t* row, float* out) const {
        const float* weight = weights.data();
        for (const int from : first) {
            const uint8_t* pixel = row + static_cast<size_t>(from) * channels;
            float sums[channels] = {};
            for (int n = 0; n < depth; ++n, ++weight, pixel += channels)
                for (int c = 0; c < channels; ++c) sums[c] += static_cast<float>(pixel[c]) * *weight;
            out = std::copy_n(sums, channels, out);
        }
    }
    void run(const uint8_t* row, int channels, float* out) const {
        if (channels == 1) return run<1>(row, out);
        if (channels == 3) return run<3>(row, out);
        const float* weight = weights.data();
        for (const int from : first) {
            std::fill_n(out, channels, 0.0f);
            for (int n = 0; n < depth; ++n, ++weight) {
                const uint8_t* const pixel = row + static_cast<size_t>(from + n) * static_cast<size_t>(channels);
                for (int c = 0; c < channels; ++c) out[c] += static_cast<float>(pixel[c]) * *weight;
            }
            out += channels;
        }
    }
};

// Rows of games often repeat the row above: their results are computed once.
void average_areas(const uint8_t* image, ImageSize from, int channels, ImageSize to, uint8_t* out) {
    const Across across(from.columns, to.columns);
    const size_t bytes = static_cast<size_t>(from.columns) * static_cast<size_t>(channels);
    const size_t results = static_cast<size_t>(to.columns) * static_cast<size_t>(channels);
    std::vector<float> line(results), sum(results);
    const uint8_t* held = nullptr;  // the row whose results are in `line`
    for (const AreaResize::Tap& tap : AreaResize::taps(from.rows, to.rows)) {
        const uint8_t* const row = image + bytes * static_cast<size_t>(tap.source);
        if (row != held && (!held || std::memcmp(row, held, bytes) != 0)) across.run(row, channels, line.data());
        held = row;
        if (tap.first)
            for (size_t i = 0; i < results; ++i) sum[i] = tap.weight * line[i];
        else
            for (size_t i = 0; i < results; ++i) sum[i] += tap.weight * line[i];
        if (!tap.last) continue;
        for (size_t i = 0; i < results; ++i) out[i] = rounded(sum[i]);
        out += results;
    }
}

// OpenCV rounds halves up in blocks of 2 x 2 of 1, 3 or 4 channels, and else to even, after a multiplication in float.
void average_blocks(const uint8_t* image, ImageSize from, int channels, ImageSize to, uint8_t* out) {
    const int down = from.rows / to.rows, across = from.columns / to.columns;
    const bool halves_up = down == 2 && across == 2 && (channels == 1 || channels == 3 || channels == 4);
    const float share = 1.0f / (static_cast<float>(down) * static_cast<float>(across));
    const auto step = static_cast<size_t>(channels), bytes = static_cast<size_t>(from.columns) * step;
    for (int y = 0; y < to.rows; ++y, image += bytes * static_cast<size_t>(down))
        for (int x = 0; x < to.columns; ++x)
            for (size_t c = 0; c < step; ++c) {
                const uint8_t* block = image + static_cast<size_t>(across) * static_cast<size_t>(x) * step + c;
                int64_t sum = 0;
                for (int row = 0; row < down; ++row, block += bytes)
                    for (int column = 0; column < across; ++column) sum += block[static_cast<size_t>(column) * step];
                *out++ = static_cast<uint8_t>(halves_up ? (sum + 2) >> 2 : rounded(static_cast<float>(sum) * share));
            }
}

// A result between two neighbours of the source, with weights in units of 2**-11.
struct Between {
    uint32_t first, second;
    int weights[2];
};

std::vector<Between> between(int source, int target) {
    std::vector<Between> all;
    const double inverse = static_cast<double>(target) / source, scale = 1.0 / inverse;
    for (int i = 0; i < target; ++i) {
        int at = static_cast<int>(std::floor(i * scale));
        float share = static_cast<float>((i + 1) - (at + 1) * inverse);
        share = share <= 0 ? 0.0f : share - std::floor(share);
        if (at >= source - 1) at = source - 1, share = 0.0f;
        const auto weight = [](float part) { return static_cast<int>(std::lrint(part * 2048.0f)); };
        all.push_back({static_cast<uint32_t>(at),
                       static_cast<uint32_t>(std::min(at + 1, source - 1)),
                       {weight(1.0f - share), weight(share)}});
    }
    return all;
}

// Writes the results of a row between its pixels, in units of 2**-7: at most 255 * 2**7. `fixed` is the number of
// channels if the compiler is to know it, else 0.
template <size_t fixed>
void interpolate_row(const uint8_t* row, const std::vector<Between>& across, size_t channels, int16_t* line) {
    const size_t count = fixed ? fixed : channels;
    for (const Between& place : across) {
        const uint8_t *first = row + place.first * count, *second = row + place.second * count;
        for (size_t c = 0; c < count; ++c)
            line[c] = static_cast<int16_t>((first[c] * place.weights[0] + second[c] * place.weights[1]) >> 4);
        line += count;
    }
}

// OpenCV drops the lower bits of each product before it adds them.
void blend(const int16_t* upper, const int16_t* lower, const int* weights, size_t count, uint8_t* __restrict out) {
    const auto above = static_cast<int16_t>(weights[0]), below = static_cast<int16_t>(weights[1]);
    for (size_t i = 0; i < count; ++i)
        out[i] = static_cast<uint8_t>((((above * upper[i]) >> 16) + ((below * lower[i]) >> 16) + 2) >> 2);
}

// Rows of games often repeat the row above: their results are copied.
void interpolate(const uint8_t* image, ImageSize from, int channels, ImageSize to, uint8_t* out) {
    const std::vector<Between> across = between(from.columns, to.columns);
    const auto step = static_cast<size_t>(channels), bytes = static_cast<size_t>(from.columns) * step;
    const size_t results = static_cast<size_t>(to.columns) * step;
    std::vector<int16_t> upper(results), lower(results);
    const auto row_of = channels == 1 ? interpolate_row<1> : channels == 3 ? interpolate_row<3> : interpolate_row<0>;
    const uint8_t *in_upper = nullptr, *in_lower = nullptr;  // the rows whose results they are
    const auto fill = [&](std::vector<int16_t>& line, const uint8_t* row, const uint8_t* known,
                          const std::vector<int16_t>& its_line) {
        if (known && std::memcmp(row, known, bytes) == 0) line = its_line;
        else row_of(row, across, step, line.data());
    };
    for (const Between& down : between(from.rows, to.rows)) {
        const uint8_t *first = image + bytes * down.first, *second = image + bytes * down.second;
        if (first != in_upper && first == in_lower) {
            std::swap(upper, lower);
            std::swap(in_upper, in_lower);
        }
        if (first != in_upper) fill(upper, first, in_lower, lower);
        in_upper = first;
        if (second != in_lower) fill(lower, second, in_upper, upper);
        in_lower = second;
        blend(upper.data(), lower.data(), down.weights, results, out);
        out += results;
    }
}

// Rows of games often repeat the row above.
LEVEL_INLINE void to_gray(const uint8_t* rgb, size_t rows, size_t columns, uint8_t* __restrict out) {
    for (size_t row = 0; row < rows; ++row, rgb += 3 * columns, out += columns) {
        if (row > 0 && std::memcmp(rgb, rgb - 3 * columns, 3 * columns) == 0) std::memcpy(out, out - columns, columns);
        else
            for (size_t i = 0; i < columns; ++i) out[i] = gray_of(rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2]);
    }
}

#if ATARI_SIMD128
TARGET_SIMD128 void to_gray_simd128(const uint8_t* rgb, size_t rows, size_t columns, uint8_t* out) {
    to_gray(rgb, rows, columns, out);
}
#endif

#if ATARI_X86_SIMD
TARGET_AVX2 void to_gray_avx2(const uint8_t* rgb, size_t rows, size_t columns, uint8_t* out) {
    to_gray(rgb, rows, columns, out);
}
#endif

}  // namespace

void resize_image(const uint8_t* image, ImageSize from, int channels, ImageSize to, uint8_t* out) {
    if (from == to) {
        std::memcpy(out, image, static_cast<size_t>(from.rows) * from.columns * channels);
        return;
    }
    const double down = AreaResize::scale(from.rows, to.rows), across = AreaResize::scale(from.columns, to.columns);
    if (down < 1 || across < 1) interpolate(image, from, channels, to, out);
    else if (down == std::floor(down) && across == std::floor(across)) average_blocks(image, from, channels, to, out);
    else average_areas(image, from, channels, to, out);
}

void rgb_to_gray(const uint8_t* rgb, size_t rows, size_t columns, uint8_t* out, [[maybe_unused]] SimdLevel level) {
#if ATARI_X86_SIMD
    if (level >= SimdLevel::kAvx2) return to_gray_avx2(rgb, rows, columns, out);
#endif
#if ATARI_SIMD128
    if (level == SimdLevel::kSimd128) return to_gray_simd128(rgb, rows, columns, out);
#endif
    to_gray(rgb, rows, columns, out);
}

}  // namespace atari
