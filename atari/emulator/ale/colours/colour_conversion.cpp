#include "colour_conversion.hpp"

#include <bit>
#include <cstring>

#include "fast/changed_columns.hpp"
#include "machine/inline.hpp"
#include "machine/state.hpp"

namespace atari {
namespace {

#if ATARI_X86_SIMD
// The source of each of the 192 RGB bytes of 64 pixels. Indices below 64 are into red, indices from 64 on are into
// green. `is_blue` marks the bytes that come from blue.
constexpr auto kInterleaved = [] {
    struct {
        uint8_t red_green[3][64] = {}, blue[3][64] = {};
        uint64_t is_blue[3] = {};
    } sources;
    for (int i = 0; i < 192; ++i) {
        const auto pixel = static_cast<uint8_t>(i / 3);
        sources.red_green[i / 64][i % 64] = static_cast<uint8_t>(i % 3 == 1 ? 64 + pixel : pixel);
        sources.blue[i / 64][i % 64] = pixel;
        if (i % 3 == 2) sources.is_blue[i / 64] |= 1ull << (i % 64);
    }
    return sources;
}();

TARGET_AVX512 void to_rgb_avx512(const uint8_t* framebuffer, int rows, const Palette& palette, uint8_t* out) {
    uint8_t channels[3][256];
    for (int i = 0; i < 256; ++i)
        for (int channel = 0; channel < 3; ++channel)
            channels[channel][i] = static_cast<uint8_t>(palette.rgb[i] >> (16 - 8 * channel));
    Avx512Table tables[3];
    __m512i red_green[3], blue[3];
    for (int channel = 0; channel < 3; ++channel) {
        tables[channel] = avx512_table(channels[channel]);
        red_green[channel] = _mm512_loadu_si512(kInterleaved.red_green[channel]);
        blue[channel] = _mm512_loadu_si512(kInterleaved.blue[channel]);
    }
    const int pixels = rows * kScreenWidth, whole = pixels / 64 * 64;
    const auto convert = [&](__m512i indices, auto store) TARGET_AVX512 {
        __m512i colour[3];
        for (int channel = 0; channel < 3; ++channel) colour[channel] = look_up(tables[channel], indices);
        for (int part = 0; part < 3; ++part) {
            const __m512i mixed = _mm512_permutex2var_epi8(colour[0], red_green[part], colour[1]);
            store(part, _mm512_mask_permutexvar_epi8(mixed, kInterleaved.is_blue[part], blue[part], colour[2]));
        }
    };
    for (int i = 0; i < whole; i += 64) {
        const __m512i indices = _mm512_loadu_si512(framebuffer + i);
        uint8_t* const to = out + 3 * i;
        // Most groups of pixels repeat the group above, and a copy is cheaper than looking colours up.
        if (i >= kScreenWidth &&
            _mm512_cmpneq_epi64_mask(indices, _mm512_loadu_si512(framebuffer + i - kScreenWidth)) == 0) {
            for (int part = 0; part < 192; part += 64)
                _mm512_storeu_si512(to + part, _mm512_loadu_si512(to + part - 3 * kScreenWidth));
        } else {
            convert(indices,
                    [&](int part, __m512i bytes) TARGET_AVX512 { _mm512_storeu_si512(to + 64 * part, bytes); });
        }
    }
    if (whole == pixels) return;
    // A row has 160 pixels, so the rest of a framebuffer is always 32 pixels.
    convert(_mm512_maskz_loadu_epi8(0xffffffff, framebuffer + whole), [&](int part, __m512i bytes) TARGET_AVX512 {
        const __mmask64 inside = part == 0 ? ~0ull : part == 1 ? 0xffffffff : 0;
        _mm512_mask_storeu_epi8(out + 3 * whole + 64 * part, inside, bytes);
    });
}

TARGET_AVX2 inline void copy_avx2(const uint8_t* from, uint8_t* to, std::size_t bytes) {
    for (std::size_t i = 0; i < bytes; i += 32)
        _mm256_storeu_si256(reinterpret_cast<__m256i*>(to + i), load32(from + i));
}
#endif

inline void copy(const uint8_t* from, uint8_t* to, std::size_t bytes) { std::memcpy(to, from, bytes); }

// Calls `convert(from, to)` for each group of eight pixels that differs from the group above. The other groups are
// copied from the row above. In games most rows repeat the row above in most of their columns.
template <int bytes, auto changes, auto copy, typename Convert>
INLINE void convert_changes(const uint8_t* framebuffer, int rows, uint8_t* out, Convert&& convert) {
    constexpr int kOut = bytes * kScreenWidth;
    for (int row = 0; row < rows; ++row, framebuffer += kScreenWidth, out += kOut) {
        uint32_t left = kAllColumns;
        if (row > 0) {
            left = changes(framebuffer);
            copy(out - kOut, out, kOut);
        }
        for (; left != 0; left &= left - 1) {
            const int column = 8 * std::countr_zero(left);
            convert(framebuffer + column, out + bytes * column);
        }
    }
}

void to_rgb_scalar(const uint8_t* framebuffer, int rows, const Palette& palette, uint8_t* out) {
    uint64_t colours[256];  // red in the lowest byte
    for (int i = 0; i < 256; ++i) {
        const uint32_t rgb = palette.rgb[i];
        colours[i] = rgb >> 16 | (rgb & 0xff00) | (rgb & 0xff) << 16;
    }
    convert_changes<3, changed_columns<const uint8_t*>, copy>(
        framebuffer, rows, out, [&](const uint8_t* from, uint8_t* to) {
            uint64_t c[8];
            for (int i = 0; i < 8; ++i) c[i] = colours[from[i]];
            // Words are assembled in registers: byte stores before a wide load would stall store forwarding.
            const auto put = [&](int word, uint64_t value) { std::memcpy(to + 8 * word, &value, 8); };
            put(0, c[0] | c[1] << 24 | c[2] << 48);
            put(1, c[2] >> 16 | c[3] << 8 | c[4] << 32 | c[5] << 56);
            put(2, c[5] >> 8 | c[6] << 16 | c[7] << 40);
        });
}

#if ATARI_SIMD128
using Words4 = uint32_t __attribute__((vector_size(16)));

// The 12 RGB bytes of four pixels, and zeros.
TARGET_SIMD128 LEVEL_INLINE Words4 four_to_rgb(const uint8_t* from, const uint32_t* rgb) {
    constexpr Bytes16 kOrder = {2, 1, 0, 6, 5, 4, 10, 9, 8, 14, 13, 12, 128, 128, 128, 128};
    const Words4 colours = {rgb[from[0]], rgb[from[1]], rgb[from[2]], rgb[from[3]]};
    return reinterpret_cast<Words4>(look_up(reinterpret_cast<Bytes16>(colours), kOrder));
}

TARGET_SIMD128 LEVEL_INLINE void eight_to_rgb(const uint8_t* from, const uint32_t* rgb, uint8_t* to) {
    const Words4 first = four_to_rgb(from, rgb), second = four_to_rgb(from + 4, rgb);
    const uint32_t last = second[2];
    std::memcpy(to, &first, 16);  // the zeros too, which the next bytes replace
    std::memcpy(to + 12, &second, 8);
    std::memcpy(to + 20, &last, 4);
}

TARGET_SIMD128 void to_rgb_simd128(const uint8_t* framebuffer, int rows, const Palette& palette, uint8_t* out) {
    const auto convert = [&](const uint8_t* from, uint8_t* to) TARGET_SIMD128 { eight_to_rgb(from, palette.rgb, to); };
    convert_changes<3, changed_columns_simd128<const uint8_t*>, copy>(framebuffer, rows, out, convert);
}
#endif

#if ATARI_X86_SIMD
TARGET_AVX2 void to_rgb_avx2(const uint8_t* framebuffer, int rows, const Palette& palette, uint8_t* out) {
    const auto convert = [&](const uint8_t* from, uint8_t* to) TARGET_AVX2 { eight_to_rgb(from, palette.rgb, to); };
    convert_changes<3, changed_columns_avx2<>, copy_avx2>(framebuffer, rows, out, convert);
}
#endif

}  // namespace

void to_rgb(const uint8_t* framebuffer, int rows, const Palette& palette, uint8_t* out, SimdLevel level) {
#if ATARI_X86_SIMD
    if (level == SimdLevel::kAvx512) return to_rgb_avx512(framebuffer, rows, palette, out);
    if (level == SimdLevel::kAvx2) return to_rgb_avx2(framebuffer, rows, palette, out);
#endif
#if ATARI_SIMD128
    if (level == SimdLevel::kSimd128) return to_rgb_simd128(framebuffer, rows, palette, out);
#endif
    static_cast<void>(level);
    to_rgb_scalar(framebuffer, rows, palette, out);
}

void to_gray(const uint8_t* framebuffer, int rows, const Palette& palette, uint8_t* out) {
    convert_changes<1, changed_columns<const uint8_t*>, copy>(framebuffer, rows, out,
                                                              [&](const uint8_t* from, uint8_t* to) {
                                                                  for (int i = 0; i < 8; ++i)
                                                                      to[i] = palette.gray[from[i]];
                                                              });
}

}  // namespace atari
