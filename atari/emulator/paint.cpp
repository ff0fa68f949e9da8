#include "paint.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "inline.hpp"
#include "state.hpp"

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

#if ATARI_WIDE
// The 32 pixels of a block, as bytes of 0x00 or 0xff. Read as 32 bits, they go from memory to all places at once.
WIDE inline __m256i bytes_of(const Mask& mask, int block) {
    const __m256i which = _mm256_setr_epi64x(0, 0x0101010101010101, 0x0202020202020202, 0x0303030303030303);
    const __m256i bit = _mm256_set1_epi64x(static_cast<int64_t>(0x8040201008040201));
    int bits;
    std::memcpy(&bits, reinterpret_cast<const char*>(mask.word) + 4 * block, sizeof bits);
    const __m256i spread = _mm256_shuffle_epi8(_mm256_set1_epi32(bits), which);
    return _mm256_cmpeq_epi8(_mm256_and_si256(spread, bit), bit);
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
        __m256i line = _mm256_blendv_epi8(background, colour_pf, bytes_of(layers.playfield, block));
        line = _mm256_blendv_epi8(line, colour1, bytes_of(layers.player1, block));
        line = _mm256_blendv_epi8(line, colour0, bytes_of(layers.player0, block));
        if (!whole) line = _mm256_blendv_epi8(_mm256_loadu_si256(pixels), line, bytes_of(span, block));
        _mm256_storeu_si256(pixels, line);
    }
}

// Here the sets of pixels are the masks of the instructions.
WIDER void paint_wider(uint8_t* row, const Layers& layers, const uint8_t colours[4], int first, int last) {
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

// Where the three times 64 bytes of 64 pixels come from: from red or green (64 and more), or from blue.
constexpr auto kInterleaved = [] {
    struct {
        uint8_t red_green[3][64] = {}, blue[3][64] = {};
        uint64_t is_blue[3] = {};
    } places;
    for (int i = 0; i < 192; ++i) {
        const auto pixel = static_cast<uint8_t>(i / 3);
        places.red_green[i / 64][i % 64] = static_cast<uint8_t>(i % 3 == 1 ? 64 + pixel : pixel);
        places.blue[i / 64][i % 64] = pixel;
        if (i % 3 == 2) places.is_blue[i / 64] |= 1ull << (i % 64);
    }
    return places;
}();

WIDER void to_rgb_wider(const uint8_t* picture, int rows, const Palette& palette, uint8_t* out) {
    uint8_t channels[3][256];
    for (int i = 0; i < 256; ++i)
        for (int channel = 0; channel < 3; ++channel) channels[channel][i] = static_cast<uint8_t>(palette.rgb[i] >> (16 - 8 * channel));
    WideTable tables[3];
    __m512i red_green[3], blue[3];
    for (int channel = 0; channel < 3; ++channel) {
        tables[channel] = wide_table(channels[channel]);
        red_green[channel] = _mm512_loadu_si512(kInterleaved.red_green[channel]);
        blue[channel] = _mm512_loadu_si512(kInterleaved.blue[channel]);
    }
    const int pixels = rows * kScreenWidth, whole = pixels / 64 * 64;
    const auto convert = [&](__m512i indices, auto store) WIDER {
        __m512i colour[3];
        for (int channel = 0; channel < 3; ++channel) colour[channel] = look_up(tables[channel], indices);
        for (int part = 0; part < 3; ++part) {
            const __m512i mixed = _mm512_permutex2var_epi8(colour[0], red_green[part], colour[1]);
            store(part, _mm512_mask_permutexvar_epi8(mixed, kInterleaved.is_blue[part], blue[part], colour[2]));
        }
    };
    for (int i = 0; i < whole; i += 64)
        convert(_mm512_loadu_si512(picture + i),
                [&](int part, __m512i bytes) WIDER { _mm512_storeu_si512(out + 3 * i + 64 * part, bytes); });
    if (whole == pixels) return;
    // Half of 64 are left.
    convert(_mm512_maskz_loadu_epi8(0xffffffff, picture + whole), [&](int part, __m512i bytes) WIDER {
        const __mmask64 inside = part == 0 ? ~0ull : part == 1 ? 0xffffffff : 0;
        _mm512_mask_storeu_epi8(out + 3 * whole + 64 * part, inside, bytes);
    });
}

WIDE inline __m256i load(const uint8_t* from) { return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(from)); }

// `changes` and a copy, 32 bytes at a time.
WIDE inline uint32_t changes_wide(const uint8_t* row) {
    uint32_t same = 0;
    for (int k = 0; k < kScreenWidth / 8; k += 4, row += 32) {
        const __m256i equal = _mm256_cmpeq_epi64(load(row), load(row - kScreenWidth));
        same |= static_cast<uint32_t>(_mm256_movemask_pd(_mm256_castsi256_pd(equal))) << k;
    }
    return same ^ ((1u << kScreenWidth / 8) - 1);
}
WIDE inline void copy_wide(const uint8_t* from, uint8_t* to, std::size_t bytes) {
    for (std::size_t i = 0; i < bytes; i += 32) _mm256_storeu_si256(reinterpret_cast<__m256i*>(to + i), load(from + i));
}
#endif

inline void copy(const uint8_t* from, uint8_t* to, std::size_t bytes) { std::memcpy(to, from, bytes); }

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
template <int bytes, auto changes, auto copy, typename Convert>
INLINE void convert_changes(const uint8_t* picture, int rows, uint8_t* out, Convert&& convert) {
    constexpr int kOut = bytes * kScreenWidth;
    for (int row = 0; row < rows; ++row, picture += kScreenWidth, out += kOut) {
        uint32_t left = (1u << kScreenWidth / 8) - 1;
        if (row > 0) {
            left = changes(picture);
            copy(out - kOut, out, kOut);
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

std::vector<Painter> painters() {
    std::vector<Painter> found = {paint_plain};
#if ATARI_WIDE
    if (best_way() >= Way::kWide) found.push_back(paint_wide);
    if (best_way() >= Way::kWider) found.push_back(paint_wider);
#endif
    return found;
}

Painter best_painter() { return painters().back(); }

namespace {

template <auto changes, auto copy>
INLINE void to_rgb_by_changes(const uint8_t* picture, int rows, const Palette& palette, uint8_t* out) {
    uint64_t colours[256];  // red in the lowest byte
    for (int i = 0; i < 256; ++i) {
        const uint32_t rgb = palette.rgb[i];
        colours[i] = rgb >> 16 | (rgb & 0xff00) | (rgb & 0xff) << 16;
    }
    convert_changes<3, changes, copy>(picture, rows, out, [&](const uint8_t* from, uint8_t* to) {
        uint64_t c[8];
        for (int i = 0; i < 8; ++i) c[i] = colours[from[i]];
        // Word by word: gathered in memory first, they would be waited for.
        const auto put = [&](int word, uint64_t value) { std::memcpy(to + 8 * word, &value, 8); };
        put(0, c[0] | c[1] << 24 | c[2] << 48);
        put(1, c[2] >> 16 | c[3] << 8 | c[4] << 32 | c[5] << 56);
        put(2, c[5] >> 8 | c[6] << 16 | c[7] << 40);
    });
}

#if ATARI_WIDE
WIDE void to_rgb_wide(const uint8_t* picture, int rows, const Palette& palette, uint8_t* out) {
    to_rgb_by_changes<changes_wide, copy_wide>(picture, rows, palette, out);
}
#endif

}  // namespace

void to_rgb(const uint8_t* picture, int rows, const Palette& palette, uint8_t* out, Way way) {
#if ATARI_WIDE
    if (way == Way::kWider) return to_rgb_wider(picture, rows, palette, out);
    if (way == Way::kWide) return to_rgb_wide(picture, rows, palette, out);
#endif
    static_cast<void>(way);
    to_rgb_by_changes<changes, copy>(picture, rows, palette, out);
}

void to_gray(const uint8_t* picture, int rows, const Palette& palette, uint8_t* out) {
    convert_changes<1, changes, copy>(picture, rows, out, [&](const uint8_t* from, uint8_t* to) {
        for (int i = 0; i < 8; ++i) to[i] = palette.gray[from[i]];
    });
}

}  // namespace atari
