// Instruction sets that not every processor has. They are chosen at run time; results are the same in all.
#pragma once

#include <cstdint>

#if defined(__x86_64__) && defined(__GNUC__)
#ifndef __clang__
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"  // the header of GCC 12 warns of itself
#include <immintrin.h>
#pragma GCC diagnostic pop
#else
#include <immintrin.h>
#endif
#define ATARI_WIDE 1
#define WIDE __attribute__((target("avx2")))
#define WIDER __attribute__((target("avx512f,avx512bw,avx512vl,avx512vbmi")))
#else
#define ATARI_WIDE 0
#endif

namespace atari {

enum class Way { kPlain, kWide, kWider };

// The fastest of this processor.
inline Way best_way() {
#if ATARI_WIDE
    static const Way best = [] {
        const bool wider = __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl") &&
                           __builtin_cpu_supports("avx512vbmi");
        return wider ? Way::kWider : __builtin_cpu_supports("avx2") ? Way::kWide : Way::kPlain;
    }();
    return best;
#else
    return Way::kPlain;
#endif
}

#if ATARI_WIDE
// A table of 256 bytes.
struct WideTable {
    __m512i part[4];
};

WIDER inline WideTable wide_table(const uint8_t* table) {
    return {{_mm512_loadu_si512(table), _mm512_loadu_si512(table + 64), _mm512_loadu_si512(table + 128),
             _mm512_loadu_si512(table + 192)}};
}

// One of its bytes for each of 64 indices.
WIDER inline __m512i look_up(const WideTable& table, __m512i indices) {
    const __m512i low = _mm512_permutex2var_epi8(table.part[0], indices, table.part[1]);
    const __m512i high = _mm512_permutex2var_epi8(table.part[2], indices, table.part[3]);
    return _mm512_mask_mov_epi8(low, _mm512_movepi8_mask(indices), high);
}
#endif

}  // namespace atari
