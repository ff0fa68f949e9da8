// Levels of SIMD instructions, chosen at run time. The results of all levels are equal.
#pragma once

#include <cstdint>

#if defined(__x86_64__) && defined(__GNUC__)
#ifndef __clang__
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"  // the header of GCC 12 causes warnings
#include <immintrin.h>
#pragma GCC diagnostic pop
#else
#include <immintrin.h>
#endif
#define ATARI_X86_SIMD 1
#define TARGET_AVX2 __attribute__((target("avx2")))
#define TARGET_AVX512 __attribute__((target("avx512f,avx512bw,avx512vl,avx512vbmi")))
#else
#define ATARI_X86_SIMD 0
#endif

namespace atari {

enum class SimdLevel { kScalar, kAvx2, kAvx512 };

// The highest level that this processor supports.
inline SimdLevel best_simd_level() {
#if ATARI_X86_SIMD
    static const SimdLevel best = [] {
        const bool avx512 = __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl") &&
                            __builtin_cpu_supports("avx512vbmi");
        return avx512 ? SimdLevel::kAvx512 : __builtin_cpu_supports("avx2") ? SimdLevel::kAvx2 : SimdLevel::kScalar;
    }();
    return best;
#else
    return SimdLevel::kScalar;
#endif
}

#if ATARI_X86_SIMD
// A table of 256 bytes.
struct Avx512Table {
    __m512i part[4];
};

TARGET_AVX512 inline Avx512Table avx512_table(const uint8_t* table) {
    return {{_mm512_loadu_si512(table), _mm512_loadu_si512(table + 64), _mm512_loadu_si512(table + 128),
             _mm512_loadu_si512(table + 192)}};
}

// One of its bytes for each of 64 indices.
TARGET_AVX512 inline __m512i look_up(const Avx512Table& table, __m512i indices) {
    const __m512i low = _mm512_permutex2var_epi8(table.part[0], indices, table.part[1]);
    const __m512i high = _mm512_permutex2var_epi8(table.part[2], indices, table.part[3]);
    return _mm512_mask_mov_epi8(low, _mm512_movepi8_mask(indices), high);
}
#endif

}  // namespace atari
