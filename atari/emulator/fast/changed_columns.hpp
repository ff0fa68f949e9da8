// Compares rows of pixels with the rows above them: most rows of a game repeat the row above in most columns.
#pragma once

#include <cstdint>
#include <cstring>

#include "machine/state.hpp"
#include "simd.hpp"

namespace atari {

inline constexpr uint32_t kAllColumns = (1u << kScreenWidth / 8) - 1;

// The functions take the rows of one frame or of several. They return a set of bits: bit k is set if a row differs from
// the row above it, which lies before it in memory, in columns 8k .. 8k+7.
template <typename... Rows>
inline uint32_t changed_columns(Rows... rows) {
    uint8_t differences = 0;  // one byte for all columns; no branch, so that the compiler vectorizes the loop
    for (int x = 0; x < kScreenWidth; ++x)
        differences |= static_cast<uint8_t>(((rows[x] ^ rows[x - kScreenWidth]) | ...));
    if (differences == 0) return 0;
    uint32_t found = 0;
    for (int k = 0; k < kScreenWidth / 8; ++k) {
        const auto differs = [k](const uint8_t* row) {
            return std::memcmp(row + 8 * k, row + 8 * k - kScreenWidth, 8) != 0;
        };
        found |= uint32_t{(differs(rows) || ...)} << k;
    }
    return found;
}

#if ATARI_SIMD128
template <typename... Rows>
TARGET_SIMD128 inline uint32_t changed_columns_simd128(Rows... rows) {
    Words2 found{}, bits{1, 2};
    for (int x = 0; x < kScreenWidth; x += 16, bits <<= 2) {
        const Words2 differences = ((load16<Words2>(rows + x) ^ load16<Words2>(rows + x - kScreenWidth)) | ...);
        found |= reinterpret_cast<Words2>(differences != Words2{}) & bits;
    }
    return static_cast<uint32_t>(found[0] | found[1]);
}
#endif

#if ATARI_X86_SIMD
TARGET_AVX2 LEVEL_INLINE __m256i load32(const void* from) {
    return _mm256_loadu_si256(static_cast<const __m256i*>(from));
}

TARGET_AVX2 LEVEL_INLINE __m256i equal_to_above(const uint8_t* pixels) {
    return _mm256_cmpeq_epi64(load32(pixels), load32(pixels - kScreenWidth));
}

template <typename... Rows>
TARGET_AVX2 inline uint32_t changed_columns_avx2(const uint8_t* first, Rows... others) {
    uint32_t same = 0;
    for (int k = 0; k < kScreenWidth / 8; k += 4) {
        __m256i equal = equal_to_above(first + 8 * k);
        ((equal = _mm256_and_si256(equal, equal_to_above(others + 8 * k))), ...);
        same |= static_cast<uint32_t>(_mm256_movemask_pd(_mm256_castsi256_pd(equal))) << k;
    }
    return same ^ kAllColumns;
}
#endif

}  // namespace atari
