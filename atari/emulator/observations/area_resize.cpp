#include "area_resize.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace atari {
namespace {

constexpr int kMostResults = 8 * 21;  // upper bound of padded results: at most 21 windows of 8 are needed, or 10 of 16

// Returns the number of results that are computed at once, in one window of pixels.
constexpr int lanes_of(SimdLevel level) { return level == SimdLevel::kAvx512 ? 16 : 8; }

// Returns the number of pixels in a window: those of a register, or the whole row.
constexpr int reach_of(SimdLevel level) {
    return level == SimdLevel::kAvx512 ? 64 : level == SimdLevel::kScalar ? kScreenWidth : 16;
}

// Returns `level`, or scalar code if the results of so narrow an image need more pixels than a register holds.
SimdLevel level_for(int width, SimdLevel level) {
    return kScreenWidth / width + 2 > reach_of(level) ? SimdLevel::kScalar : level;
}

// Computes neighbouring results of a row. The sums are float32, and each product is rounded before it is added, in the
// order of the pixels. In ties, which are frequent in games, the last bit of the sum decides.
void across_scalar(const uint8_t* pixels, const AreaResize::Taps* taps, int depth, float* __restrict results) {
    constexpr int lanes = lanes_of(SimdLevel::kScalar);
    float sums[lanes] = {};
    for (int n = 0; n < depth; ++n)
        for (int i = 0; i < lanes; ++i) {
            const float value = pixels[taps[n].pixel[i] & 0xff];  // unused taps read pixel 0x80 of the row
            sums[i] += value * taps[n].weight[i];
        }
    std::memcpy(results, sums, sizeof sums);
}

LEVEL_INLINE void multiply(const float* __restrict line, float weight, int count, float* __restrict sum) {
    for (int i = 0; i < count; ++i) sum[i] = weight * line[i];
}

LEVEL_INLINE void add(const float* __restrict line, float weight, int count, float* __restrict sum) {
    for (int i = 0; i < count; ++i) sum[i] += weight * line[i];
}

// Rounds to nearest, ties to even: the last bit of so large a number is worth one.
LEVEL_INLINE void round(const float* __restrict sum, int count, uint8_t* __restrict bytes) {
    for (int i = 0; i < count; ++i) bytes[i] = static_cast<uint8_t>(std::bit_cast<uint32_t>(sum[i] + 12582912.0f));
}

#if ATARI_SIMD128
TARGET_SIMD128 LEVEL_INLINE Floats4 chosen_pixels(Bytes16 window, const uint32_t* pixels) {
    const Bytes16 chosen = look_up(window, load16<Bytes16>(pixels));
    return __builtin_convertvector(reinterpret_cast<Integers4>(chosen), Floats4);
}

TARGET_SIMD128 inline void across_simd128(const uint8_t* pixels, const AreaResize::Taps* taps, int depth,
                                          float* results) {
    const auto window = load16<Bytes16>(pixels);
    Floats4 sums[2] = {};
    for (int n = 0; n < depth; ++n)
        for (int half : {0, 1})
            sums[half] += chosen_pixels(window, taps[n].pixel + 4 * half) * load16<Floats4>(taps[n].weight + 4 * half);
    std::memcpy(results, sums, sizeof sums);
}
#endif

#if ATARI_X86_SIMD
TARGET_AVX2 inline __m256i load(const void* from) { return _mm256_loadu_si256(static_cast<const __m256i*>(from)); }

TARGET_AVX2 inline void across_avx2(const uint8_t* pixels, const AreaResize::Taps* taps, int depth, float* results) {
    const __m256i window = _mm256_broadcastsi128_si256(_mm_loadu_si128(reinterpret_cast<const __m128i*>(pixels)));
    __m256 sums = _mm256_setzero_ps();
    for (int n = 0; n < depth; ++n) {
        const __m256 values = _mm256_cvtepi32_ps(_mm256_shuffle_epi8(window, load(taps[n].pixel)));
        sums = _mm256_add_ps(sums, _mm256_mul_ps(values, _mm256_loadu_ps(taps[n].weight)));
    }
    _mm256_storeu_ps(results, sums);
}

TARGET_AVX512 inline void across_avx512(const uint8_t* pixels, const AreaResize::Taps* taps, int depth,
                                        float* results) {
    const __m512i window = _mm512_loadu_si512(pixels);
    __m512 sums = _mm512_setzero_ps();
    for (int n = 0; n < depth; ++n) {
        const __m512i chosen =
            _mm512_maskz_permutexvar_epi8(0x1111111111111111, _mm512_loadu_si512(taps[n].pixel), window);
        sums = _mm512_add_ps(sums, _mm512_mul_ps(_mm512_cvtepi32_ps(chosen), _mm512_loadu_ps(taps[n].weight)));
    }
    _mm512_storeu_ps(results, sums);
}

#endif

}  // namespace

AreaResize::AreaResize(int rows, int height, int width, SimdLevel level)
    : height_(height), width_(width), level_(level_for(width, level)) {
    down_ = taps(rows, height);
    std::stable_sort(down_.begin(), down_.end(), [](const Tap& a, const Tap& b) { return a.source < b.source; });
    for (size_t i = 0; i < down_.size(); ++i) {
        if (down_[i].first) {
            sources_.push_back({down_[i].source, down_[i].source});
            first_taps_.push_back(i);
        }
        sources_.back().last = down_[i].source;
    }
    make_windows(taps(kScreenWidth, width));
}

double AreaResize::scale(int source, int target) { return 1.0 / (static_cast<double>(target) / source); }

// OpenCV computes the weights in doubles, leaves slivers out, and rounds to float.
std::vector<AreaResize::Tap> AreaResize::taps(int source, int target) {
    std::vector<Tap> all;
    const double scale = AreaResize::scale(source, target);
    for (int i = 0; i < target; ++i) {
        const double start = i * scale, end = start + scale, extent = std::min(scale, source - start);
        const int whole_end = std::min(static_cast<int>(std::floor(end)), source - 1);
        const int whole_start = std::min(static_cast<int>(std::ceil(start)), whole_end);
        const size_t first = all.size();
        const auto add = [&](int pixel, double part) {
            all.push_back({pixel, i, static_cast<float>(part / extent), false, false});
        };
        if (whole_start - start > 1e-3) add(whole_start - 1, whole_start - start);
        for (int pixel = whole_start; pixel < whole_end; ++pixel) add(pixel, 1.0);
        if (end - whole_end > 1e-3) add(whole_end, std::min({end - whole_end, 1.0, extent}));
        all[first].first = all.back().last = true;
    }
    return all;
}

void AreaResize::make_windows(const std::vector<Tap>& across) {
    const int lanes = lanes_of(level_), reach = reach_of(level_);
    for (auto tap = across.begin(); tap != across.end();) {
        const auto last = std::find_if(tap, across.end(), [](const Tap& t) { return t.last; });
        if (windows_.empty() || windows_.back().count == lanes || last->source >= windows_.back().source + reach)
            windows_.push_back({std::min(tap->source, kScreenWidth - reach), tap->result, 0});
        ++windows_.back().count;
        depth_ = std::max(depth_, static_cast<int>(last - tap) + 1);
        tap = last + 1;
    }
    Taps unused{};
    std::fill_n(unused.pixel, 16, 0x80808080u);
    across_.assign(windows_.size() * static_cast<size_t>(depth_), unused);
    Taps* place = across_.data();
    for (size_t k = 0; k < windows_.size(); ++k) {
        const Window& window = windows_[k];
        Taps* taps = place;
        for (const Tap& tap : across) {
            const int i = tap.result - window.result;
            if (i < 0 || i >= window.count) continue;
            if (tap.first) taps = place;
            taps->pixel[i] = 0x80808000u | static_cast<uint32_t>(tap.source - window.source);
            taps->weight[i] = tap.weight;
            ++taps;
            windows_with_[tap.source / 8] |= 1u << k;
        }
        place += depth_;
    }
}

// Returns the set of windows that reach into changed columns.
LEVEL_INLINE uint32_t AreaResize::changed_windows(uint32_t changes) const {
    uint32_t windows = 0;
    for (; changes != 0; changes &= changes - 1) windows |= windows_with_[std::countr_zero(changes)];
    return windows;
}

// Copies a row of results to `out`, and writes nothing from `end` on. Where there is room, all lanes of a window are
// copied: the next window, or the next row, overwrites those after the window's results.
template <int lanes>
LEVEL_INLINE void AreaResize::store(const uint8_t* bytes, uint8_t* out, const uint8_t* end) const {
    const bool room = end - out >= width_ + lanes;
    for (const Window& window : windows_) {
        if (room) std::memcpy(out + window.result, bytes, lanes);
        else std::copy_n(bytes, window.count, out + window.result);
        bytes += lanes;
    }
}

// The results of a source row are computed once, where the row changes. They are then added to the sums of the one or
// two result rows to which the source row contributes.
template <auto across, int lanes>
LEVEL_INLINE void AreaResize::run(const uint8_t* frame, const uint32_t* changes, uint8_t* out, int first,
                                  int last) const {
    float line[kMostResults], sum[kMostResults];
    uint8_t bytes[kMostResults];
    const Window* const windows = windows_.data();
    const Taps* const taps = across_.data();
    const int count = static_cast<int>(windows_.size()), depth = depth_;
    const uint32_t all = (1u << count) - 1;
    int row = sources(first).first - 1;  // the source row that `line` holds
    for (size_t i = first_taps_[static_cast<size_t>(first)]; i < down_.size() && down_[i].result < last; ++i) {
        const Tap& tap = down_[i];
        while (row < tap.source) {
            const uint8_t* const pixels = frame + kScreenWidth * ++row;
            for (uint32_t left = changes ? changed_windows(changes[row]) : all; left != 0; left &= left - 1) {
                const int k = std::countr_zero(left);
                across(pixels + windows[k].source, taps + depth * k, depth, line + lanes * k);
            }
        }
        if (tap.first) multiply(line, tap.weight, lanes * count, sum);
        else add(line, tap.weight, lanes * count, sum);
        if (!tap.last) continue;
        round(sum, lanes * count, bytes);
        store<lanes>(bytes, out + width_ * tap.result, out + width_ * last);
    }
}

#if ATARI_SIMD128
TARGET_SIMD128 void AreaResize::run_simd128(const uint8_t* frame, const uint32_t* changes, uint8_t* out, int first,
                                            int last) const {
    run<across_simd128, lanes_of(SimdLevel::kSimd128)>(frame, changes, out, first, last);
}
#endif

#if ATARI_X86_SIMD
TARGET_AVX2 void AreaResize::run_avx2(const uint8_t* frame, const uint32_t* changes, uint8_t* out, int first,
                                      int last) const {
    run<across_avx2, lanes_of(SimdLevel::kAvx2)>(frame, changes, out, first, last);
}

TARGET_AVX512 void AreaResize::run_avx512(const uint8_t* frame, const uint32_t* changes, uint8_t* out, int first,
                                          int last) const {
    run<across_avx512, lanes_of(SimdLevel::kAvx512)>(frame, changes, out, first, last);
}
#endif

void AreaResize::make_rows(const uint8_t* frame, const uint32_t* changes, uint8_t* out, int first, int last) const {
#if ATARI_X86_SIMD
    if (level_ == SimdLevel::kAvx512) return run_avx512(frame, changes, out, first, last);
    if (level_ == SimdLevel::kAvx2) return run_avx2(frame, changes, out, first, last);
#endif
#if ATARI_SIMD128
    if (level_ == SimdLevel::kSimd128) return run_simd128(frame, changes, out, first, last);
#endif
    run<across_scalar, lanes_of(SimdLevel::kScalar)>(frame, changes, out, first, last);
}

}  // namespace atari
