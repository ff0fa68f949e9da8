#include "paint.hpp"

#include <cstring>

#include "machine/state.hpp"

namespace atari {
namespace {

#if ATARI_SIMD128
// The 16 pixels of a block, as bytes of 0x00 or 0xff.
TARGET_SIMD128 LEVEL_INLINE Bytes16 bytes_of_16(const Mask& mask, int block) {
    const uint64_t word = mask.word[block / 4];
    constexpr Words2 kWhich{0, repeated(1)}, kBit{0x8040201008040201, 0x8040201008040201};
    const uint64_t first = repeated(static_cast<uint8_t>(block % 4 * 2));
    const auto which = reinterpret_cast<Bytes16>(kWhich + Words2{first, first});
    const auto spread = look_up(reinterpret_cast<Bytes16>(Words2{word, word}), which);
    const auto bit = reinterpret_cast<Bytes16>(kBit);
    return reinterpret_cast<Bytes16>((spread & bit) == bit);
}

// `colour` where `mask` is set, elsewhere `below`.
TARGET_SIMD128 LEVEL_INLINE Bytes16 over(Bytes16 below, Bytes16 colour, Bytes16 mask) {
    return (colour & mask) | (below & ~mask);
}

TARGET_SIMD128 void paint_simd128(uint8_t* row, const Layers& layers, const uint8_t colours[4], int first, int last) {
    const Bytes16 none{};
    const Bytes16 colour0 = none + colours[0], colour1 = none + colours[1], colour_pf = none + colours[2];
    const Bytes16 background = none + colours[3];
    const bool whole = first == 0 && last == kScreenWidth;
    const Mask span = whole ? Mask{} : Mask::range(first, last);
    for (int block = first / 16; block <= (last - 1) / 16; ++block) {
        uint8_t* const pixels = row + 16 * block;
        Bytes16 line = over(background, colour_pf, bytes_of_16(layers.playfield, block));
        line = over(line, colour1, bytes_of_16(layers.player1, block));
        line = over(line, colour0, bytes_of_16(layers.player0, block));
        if (!whole) line = over(load16<Bytes16>(pixels), line, bytes_of_16(span, block));
        std::memcpy(pixels, &line, sizeof line);
    }
}
#endif

#if ATARI_X86_SIMD
// The 32 pixels of a block, as bytes of 0x00 or 0xff. A 32-bit read lets one instruction broadcast it from memory.
TARGET_AVX2 inline __m256i bytes_of(const Mask& mask, int block) {
    const __m256i which = _mm256_setr_epi64x(0, 0x0101010101010101, 0x0202020202020202, 0x0303030303030303);
    const __m256i bit = _mm256_set1_epi64x(static_cast<int64_t>(0x8040201008040201));
    int bits;
    std::memcpy(&bits, reinterpret_cast<const char*>(mask.word) + 4 * block, sizeof bits);
    const __m256i spread = _mm256_shuffle_epi8(_mm256_set1_epi32(bits), which);
    return _mm256_cmpeq_epi8(_mm256_and_si256(spread, bit), bit);
}

TARGET_AVX2 void paint_avx2(uint8_t* row, const Layers& layers, const uint8_t colours[4], int first, int last) {
    const __m256i colour0 = _mm256_set1_epi8(static_cast<char>(colours[0]));
    const __m256i colour1 = _mm256_set1_epi8(static_cast<char>(colours[1]));
    const __m256i colour_pf = _mm256_set1_epi8(static_cast<char>(colours[2]));
    const __m256i background = _mm256_set1_epi8(static_cast<char>(colours[3]));
    const bool whole = first == 0 && last == kScreenWidth;
    const Mask span = whole ? Mask{} : Mask::range(first, last);
    for (int block = first / 32; block <= (last - 1) / 32; ++block) {
        auto* pixels = reinterpret_cast<__m256i*>(row + 32 * block);
        __m256i line = _mm256_blendv_epi8(background, colour_pf, bytes_of(layers.playfield, block));
        line = _mm256_blendv_epi8(line, colour1, bytes_of(layers.player1, block));
        line = _mm256_blendv_epi8(line, colour0, bytes_of(layers.player0, block));
        if (!whole) line = _mm256_blendv_epi8(_mm256_loadu_si256(pixels), line, bytes_of(span, block));
        _mm256_storeu_si256(pixels, line);
    }
}

// The pixel sets serve directly as mask registers.
TARGET_AVX512 void paint_avx512(uint8_t* row, const Layers& layers, const uint8_t colours[4], int first, int last) {
    const __m512i colour0 = _mm512_set1_epi8(static_cast<char>(colours[0]));
    const __m512i colour1 = _mm512_set1_epi8(static_cast<char>(colours[1]));
    const __m512i colour_pf = _mm512_set1_epi8(static_cast<char>(colours[2]));
    const __m512i background = _mm512_set1_epi8(static_cast<char>(colours[3]));
    const Mask span = Mask::range(first, last);
    for (int word = first / 64; word <= (last - 1) / 64; ++word) {
        __m512i line = _mm512_mask_mov_epi8(background, layers.playfield.word[word], colour_pf);
        line = _mm512_mask_mov_epi8(line, layers.player1.word[word], colour1);
        line = _mm512_mask_mov_epi8(line, layers.player0.word[word], colour0);
        _mm512_mask_storeu_epi8(row + 64 * word, span.word[word], line);
    }
}

#endif

}  // namespace

void paint_scalar(uint8_t* row, const Layers& layers, const uint8_t colours[4], int first, int last) {
    uint64_t line[kScreenWidth / 8];
    const uint64_t c0 = repeated(colours[0]), c1 = repeated(colours[1]);
    const uint64_t cf = repeated(colours[2]), cb = repeated(colours[3]);
    for (int group = first / 8; group <= (last - 1) / 8; ++group) {
        const auto eight = [&](const Mask& mask) { return kByteMasks[mask.word[group / 8] >> (group % 8 * 8) & 0xff]; };
        const uint64_t m0 = eight(layers.player0), m1 = eight(layers.player1), mf = eight(layers.playfield);
        line[group] = (m0 & c0) | (m1 & c1) | (mf & cf) | (~(m0 | m1 | mf) & cb);
    }
    std::memcpy(row + first, reinterpret_cast<const uint8_t*>(line) + first, static_cast<size_t>(last - first));
}

std::vector<Painter> painters() {
    std::vector<Painter> found = {paint_scalar};
#if ATARI_SIMD128
    if (best_simd_level() >= SimdLevel::kSimd128) found.push_back(paint_simd128);
#endif
#if ATARI_X86_SIMD
    if (best_simd_level() >= SimdLevel::kAvx2) found.push_back(paint_avx2);
    if (best_simd_level() >= SimdLevel::kAvx512) found.push_back(paint_avx512);
#endif
    return found;
}

Painter chosen_painter() { return painters()[static_cast<size_t>(simd_level())]; }

}  // namespace atari
