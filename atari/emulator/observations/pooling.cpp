#include "pooling.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

#include "fast/changed_columns.hpp"
#include "machine/state.hpp"

namespace atari {
namespace {

void pool_eight(const uint8_t* early, const uint8_t* late, const uint8_t* table, uint8_t* out) {
    uint64_t early_word, late_word;
    std::memcpy(&early_word, early, 8);
    std::memcpy(&late_word, late, 8);
    if (early_word != late_word)
        for (int i = 0; i < 8; ++i) out[i] = std::max(table[early[i]], table[late[i]]);
    else if (early_word != std::rotl(early_word, 8))
        for (int i = 0; i < 8; ++i) out[i] = table[early[i]];
    else std::memset(out, table[early[0]], 8);
}

void pool_eight_pairs(const uint8_t* early, const uint8_t* late, const uint8_t* table, uint8_t* out) {
    uint64_t early_word, late_word;
    std::memcpy(&early_word, early, 8);
    std::memcpy(&late_word, late, 8);
    if (early_word != std::rotl(early_word, 8) || late_word != std::rotl(late_word, 8))
        for (int i = 0; i < 8; ++i) out[i] = table[early[i] << 8 | late[i]];
    else std::memset(out, table[early[0] << 8 | late[0]], 8);
}

template <auto changes_of, auto eight>
LEVEL_INLINE void pool(const uint8_t* early, const uint8_t* late, int rows, const uint8_t* table, uint8_t* out,
                       uint32_t* changes) {
    for (int row = 0; row < rows; ++row) {
        uint32_t left = kAllColumns;
        if (row > 0) {
            left = changes_of(early, late);
            std::memcpy(out, out - kScreenWidth, kScreenWidth);
        }
        changes[row] = left;
        for (; left != 0; left &= left - 1) {
            const int column = 8 * std::countr_zero(left);
            eight(early + column, late + column, table, out + column);
        }
        early += kScreenWidth;
        late += kScreenWidth;
        out += kScreenWidth;
    }
}

#if ATARI_SIMD128
template <auto eight>
TARGET_SIMD128 void pool_simd128(const uint8_t* early, const uint8_t* late, int rows, const uint8_t* table,
                                 uint8_t* out, uint32_t* changes) {
    pool<changed_columns_simd128<const uint8_t*, const uint8_t*>, eight>(early, late, rows, table, out, changes);
}
#endif

#if ATARI_X86_SIMD
// A row as two vectors of 64 pixels and one half-filled vector.
struct Avx512Row {
    __m512i part[3];
};

TARGET_AVX512 inline Avx512Row load_row(const uint8_t* from) {
    const __m256i rest = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(from + 128));
    return {{_mm512_loadu_si512(from), _mm512_loadu_si512(from + 64), _mm512_castsi256_si512(rest)}};
}

TARGET_AVX512 inline void store_row(uint8_t* to, const Avx512Row& row) {
    _mm512_storeu_si512(to, row.part[0]);
    _mm512_storeu_si512(to + 64, row.part[1]);
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(to + 128), _mm512_castsi512_si256(row.part[2]));
}

TARGET_AVX512 inline uint32_t changes_avx512(const Avx512Row& a, const Avx512Row& b) {
    uint32_t changes = 0;
    for (int part = 0; part < 3; ++part)
        changes |= uint32_t{_mm512_cmpneq_epi64_mask(a.part[part], b.part[part])} << (8 * part);
    return changes & kAllColumns;  // the last vector is half filled
}

TARGET_AVX512 void pool_avx512(const uint8_t* early, const uint8_t* late, int rows, const uint8_t* table, uint8_t* out,
                               uint32_t* changes) {
    const Avx512Table grays = avx512_table(table);
    Avx512Row early_above{}, late_above{}, pooled{};
    for (int row = 0; row < rows; ++row, early += kScreenWidth, late += kScreenWidth, out += kScreenWidth) {
        const Avx512Row early_row = load_row(early), late_row = load_row(late);
        changes[row] =
            row > 0 ? changes_avx512(early_row, early_above) | changes_avx512(late_row, late_above) : kAllColumns;
        if (changes[row])
            for (int part = 0; part < 3; ++part)
                pooled.part[part] =
                    _mm512_max_epu8(look_up(grays, early_row.part[part]), look_up(grays, late_row.part[part]));
        store_row(out, pooled);
        early_above = early_row;
        late_above = late_row;
    }
}

template <auto eight>
TARGET_AVX2 void pool_avx2(const uint8_t* early, const uint8_t* late, int rows, const uint8_t* table, uint8_t* out,
                           uint32_t* changes) {
    pool<changed_columns_avx2<const uint8_t*>, eight>(early, late, rows, table, out, changes);
}
#endif

template <auto eight>
void pool_at([[maybe_unused]] SimdLevel level, const uint8_t* early, const uint8_t* late, int rows,
             const uint8_t* table, uint8_t* out, uint32_t* changes) {
#if ATARI_X86_SIMD
    if (level >= SimdLevel::kAvx2) return pool_avx2<eight>(early, late, rows, table, out, changes);
#endif
#if ATARI_SIMD128
    if (level == SimdLevel::kSimd128) return pool_simd128<eight>(early, late, rows, table, out, changes);
#endif
    pool<changed_columns<const uint8_t*, const uint8_t*>, eight>(early, late, rows, table, out, changes);
}

}  // namespace

void pool_gray(const uint8_t* early, const uint8_t* late, int rows, const uint8_t* table, uint8_t* out,
               uint32_t* changes, SimdLevel level) {
#if ATARI_X86_SIMD
    if (level == SimdLevel::kAvx512) return pool_avx512(early, late, rows, table, out, changes);
#endif
    pool_at<pool_eight>(level, early, late, rows, table, out, changes);
}

void pool_pairs(const uint8_t* early, const uint8_t* late, int rows, const uint8_t* table, uint8_t* out,
                uint32_t* changes, SimdLevel level) {
    pool_at<pool_eight_pairs>(level, early, late, rows, table, out, changes);
}

}  // namespace atari
