#include "paint.hpp"

#include <array>
#include <bit>
#include <cstring>

#include "state.hpp"

#if defined(__x86_64__) && defined(__GNUC__)
#include <immintrin.h>
#define ATARI_AVX2 1
#define WIDE __attribute__((target("avx2")))
#else
#define ATARI_AVX2 0
#endif

namespace atari {
namespace {

static_assert(std::endian::native == std::endian::little, "eight pixels are handled as one little-endian word");

// Eight bits as eight bytes of 0x00 or 0xff, lowest bit first.
constexpr auto kByteMasks = [] {
    std::array<uint64_t, 256> table{};
    for (uint64_t byte = 0; byte < 256; ++byte)
        for (int bit = 0; bit < 8; ++bit)
            if (byte & (1u << bit)) table[byte] |= uint64_t{0xff} << (8 * bit);
    return table;
}();

constexpr uint64_t repeated(uint8_t byte) { return byte * 0x0101010101010101ull; }

#if ATARI_AVX2
// 32 bits as 32 bytes of 0x00 or 0xff.
WIDE inline __m256i bytes_of(uint32_t bits) {
    const __m256i which = _mm256_setr_epi64x(0, 0x0101010101010101, 0x0202020202020202, 0x0303030303030303);
    const __m256i bit = _mm256_set1_epi64x(static_cast<int64_t>(0x8040201008040201));
    const __m256i spread = _mm256_shuffle_epi8(_mm256_set1_epi32(static_cast<int>(bits)), which);
    return _mm256_cmpeq_epi8(_mm256_and_si256(spread, bit), bit);
}

WIDE inline uint32_t block_of(const Mask& mask, int block) {
    return static_cast<uint32_t>(mask.word[block / 2] >> (block % 2 * 32));
}

WIDE void paint_wide(uint8_t* row, const Layers& layers, const uint8_t colours[4], int first, int last) {
    const __m256i colour0 = _mm256_set1_epi8(static_cast<char>(colours[0]));
    const __m256i colour1 = _mm256_set1_epi8(static_cast<char>(colours[1]));
    const __m256i colour_pf = _mm256_set1_epi8(static_cast<char>(colours[2]));
    const __m256i background = _mm256_set1_epi8(static_cast<char>(colours[3]));
    const bool whole = first == 0 && last == kScreenWidth;
    const Mask span = whole ? Mask{} : Mask::range(first, last);
    for (int block = first / 32; block <= (last - 1) / 32; ++block) {
        auto* pixels = reinterpret_cast<__m256i*>(row + 32 * block);
        __m256i line = _mm256_blendv_epi8(background, colour_pf, bytes_of(block_of(layers.playfield, block)));
        line = _mm256_blendv_epi8(line, colour1, bytes_of(block_of(layers.player1, block)));
        line = _mm256_blendv_epi8(line, colour0, bytes_of(block_of(layers.player0, block)));
        if (!whole) line = _mm256_blendv_epi8(_mm256_loadu_si256(pixels), line, bytes_of(block_of(span, block)));
        _mm256_storeu_si256(pixels, line);
    }
}
#endif

// Bit k for columns 8k .. 8k+7 of a row that differ from the row above.
inline uint32_t changes(const uint8_t* row) {
    uint8_t any = 0;  // of all columns, without a branch: the compiler makes vectors of this
    for (int x = 0; x < kScreenWidth; ++x) any |= static_cast<uint8_t>(row[x] ^ row[x - kScreenWidth]);
    if (any == 0) return 0;
    uint32_t found = 0;
    for (int k = 0; k < kScreenWidth / 8; ++k)
        found |= uint32_t{std::memcmp(row + 8 * k, row + 8 * k - kScreenWidth, 8) != 0} << k;
    return found;
}

// Calls `convert(from, to)` for every eight pixels that differ from those above them; others are copied. Most rows of a
// game's picture repeat the row above, and most of the others do so nearly everywhere.
template <int bytes, typename Convert>
void convert_changes(const uint8_t* picture, int rows, uint8_t* out, Convert&& convert) {
    constexpr int kOut = bytes * kScreenWidth;
    for (int row = 0; row < rows; ++row, picture += kScreenWidth, out += kOut) {
        uint32_t left = (1u << kScreenWidth / 8) - 1;
        if (row > 0) {
            left = changes(picture);
            std::memcpy(out, out - kOut, kOut);
        }
        for (; left != 0; left &= left - 1) {
            const int column = 8 * std::countr_zero(left);
            convert(picture + column, out + bytes * column);
        }
    }
}

}  // namespace

void paint_plain(uint8_t* row, const Layers& layers, const uint8_t colours[4], int first, int last) {
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

Painter best_painter() {
#if ATARI_AVX2
    if (__builtin_cpu_supports("avx2")) return paint_wide;
#endif
    return paint_plain;
}

void to_rgb(const uint8_t* picture, int rows, const Palette& palette, uint8_t* out) {
    uint64_t colours[256];  // red in the lowest byte
    for (int i = 0; i < 256; ++i) {
        const uint32_t rgb = palette.rgb[i];
        colours[i] = rgb >> 16 | (rgb & 0xff00) | (rgb & 0xff) << 16;
    }
    convert_changes<3>(picture, rows, out, [&](const uint8_t* from, uint8_t* to) {
        uint64_t c[8];
        for (int i = 0; i < 8; ++i) c[i] = colours[from[i]];
        const uint64_t words[3] = {c[0] | c[1] << 24 | c[2] << 48, c[2] >> 16 | c[3] << 8 | c[4] << 32 | c[5] << 56,
                                   c[5] >> 8 | c[6] << 16 | c[7] << 40};
        std::memcpy(to, words, sizeof words);
    });
}

void to_gray(const uint8_t* picture, int rows, const Palette& palette, uint8_t* out) {
    convert_changes<1>(picture, rows, out, [&](const uint8_t* from, uint8_t* to) {
        for (int i = 0; i < 8; ++i) to[i] = palette.gray[from[i]];
    });
}

}  // namespace atari
