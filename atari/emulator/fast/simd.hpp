// Levels of SIMD instructions, chosen at run time. The results of all levels are equal.
#pragma once

#include <cstdint>
#include <cstring>

// MSVC has neither vector extensions nor functions for other processors than the oldest: there all is scalar.
#if (defined(__x86_64__) || defined(_M_X64)) && (defined(__GNUC__) || defined(__clang__))
#ifndef __clang__
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"  // the header of GCC 12 causes warnings
#include <immintrin.h>
#pragma GCC diagnostic pop
#else
#include <immintrin.h>
#endif
#define ATARI_X86_SIMD 1
#define ATARI_SIMD128 1
#define TARGET_SIMD128 __attribute__((target("sse4.1")))
#define TARGET_AVX2 __attribute__((target("avx2")))
#define TARGET_AVX512 __attribute__((target("avx512f,avx512bw,avx512vl,avx512vbmi")))
#elif defined(__aarch64__) && (defined(__GNUC__) || defined(__clang__))
#include <arm_neon.h>
#define ATARI_X86_SIMD 0
#define ATARI_SIMD128 1
#define TARGET_SIMD128  // every arm64 processor has NEON
#elif defined(__wasm_simd128__)
#include <wasm_simd128.h>
#define ATARI_X86_SIMD 0
#define ATARI_SIMD128 1
#define TARGET_SIMD128  // a WebAssembly module with SIMD does not load where it is missing
#else
#define ATARI_X86_SIMD 0
#define ATARI_SIMD128 0
#endif

// A loop that is inlined into functions of several levels, so that each uses the instructions of its level.
#if ATARI_SIMD128
#define LEVEL_INLINE __attribute__((always_inline)) inline
#else
#define LEVEL_INLINE inline
#endif

namespace atari {

enum class SimdLevel { kScalar, kSimd128, kAvx2, kAvx512 };

// The highest level that this processor supports.
inline SimdLevel best_simd_level() {
#if ATARI_X86_SIMD
    static const SimdLevel best = [] {
        const bool avx512 = __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl") &&
                            __builtin_cpu_supports("avx512vbmi");
        if (avx512) return SimdLevel::kAvx512;
        if (__builtin_cpu_supports("avx2")) return SimdLevel::kAvx2;
        return __builtin_cpu_supports("sse4.1") ? SimdLevel::kSimd128 : SimdLevel::kScalar;
    }();
    return best;
#elif ATARI_SIMD128
    return SimdLevel::kSimd128;
#else
    return SimdLevel::kScalar;
#endif
}

// The level that is used: the highest one, or the one that the environment variable ATARI_SIMD names when it is first
// asked. `check_simd_level` throws std::invalid_argument if the variable names no level that this processor supports.
SimdLevel simd_level();
void check_simd_level();

// A level's name for ATARI_SIMD: scalar, simd128, avx2 or avx512.
const char* name_of(SimdLevel level);

#if ATARI_SIMD128
// 16 bytes, by the vector extensions of GCC and Clang: NEON, SSE4.1, or WebAssembly's SIMD.
using Bytes16 = uint8_t __attribute__((vector_size(16)));
using Words2 = uint64_t __attribute__((vector_size(16)));
using Integers4 = int32_t __attribute__((vector_size(16)));
using Floats4 = float __attribute__((vector_size(16)));

template <typename Vector>
TARGET_SIMD128 LEVEL_INLINE Vector load16(const void* from) {
    Vector vector;
    std::memcpy(&vector, from, sizeof vector);
    return vector;
}

// One of the table's bytes for each index, and 0 for indices from 128 on. Indices from 16 to 127 are not allowed.
TARGET_SIMD128 LEVEL_INLINE Bytes16 look_up(Bytes16 table, Bytes16 indices) {
#if ATARI_X86_SIMD
    return reinterpret_cast<Bytes16>(
        _mm_shuffle_epi8(reinterpret_cast<__m128i>(table), reinterpret_cast<__m128i>(indices)));
#elif defined(__wasm_simd128__)
    return reinterpret_cast<Bytes16>(
        wasm_i8x16_swizzle(reinterpret_cast<v128_t>(table), reinterpret_cast<v128_t>(indices)));
#else
    return vqtbl1q_u8(table, indices);
#endif
}
#endif

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
