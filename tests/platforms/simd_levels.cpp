// Compares the levels of SIMD instructions that this processor supports with scalar code, on random frames: painted
// lines, pooled frames, resized frames, RGB. tests/emulator does so in Python; this program also runs where there is none.
//
// usage: simd_levels
#include <array>
#include <cstdint>
#include <cstdio>
#include <random>
#include <vector>

#include "ale/colours/colour_conversion.hpp"
#include "fast/simd.hpp"
#include "fast/tia/paint.hpp"
#include "observations/resizer.hpp"
#include "observations/pooling.hpp"

namespace atari {
namespace {

constexpr int kRows = 210;
constexpr size_t kPixels = size_t{kRows} * kScreenWidth;
using Frame = std::vector<uint8_t>;
using Random = std::minstd_rand;

// Rows of few colours; some repeat the row above, some differ from it in one pixel, as in games.
Frame random_frame(Random& random) {
    Frame frame(kPixels);
    for (size_t i = 0; i < kPixels; ++i) {
        const size_t row = i / kScreenWidth;
        const bool noise = row % 7 == 0 || (row % 5 == 0 && i % kScreenWidth == row % kScreenWidth);
        if (row == 0 || noise) frame[i] = static_cast<uint8_t>(random() % (row % 2 ? 256 : 3));
        else frame[i] = frame[i - kScreenWidth];
    }
    return frame;
}

// All results of a level for the frames of a seed.
std::vector<Frame> results(unsigned seed, SimdLevel level) {
    Random random(seed);
    const Frame early = random_frame(random), late = seed % 3 ? random_frame(random) : early;
    std::vector<Frame> found;
    Frame gray(kPixels), pairs(kPixels), table(256), pair_table(65536), rgb(3 * kPixels);
    for (uint8_t& value : table) value = static_cast<uint8_t>(random());
    for (uint8_t& value : pair_table) value = static_cast<uint8_t>(random());
    std::vector<uint32_t> changes(kRows), pair_changes(kRows);
    pool_gray(early.data(), late.data(), kRows, table.data(), gray.data(), changes.data(), level);
    pool_pairs(early.data(), late.data(), kRows, pair_table.data(), pairs.data(), pair_changes.data(), level);
    to_rgb(early.data(), kRows, palette_of("NTSC"), rgb.data(), level);
    for (const auto& [height, width] :
         {std::pair{84, 84}, {64, 64}, {42, 42}, {210, 11}, {100, 159}, {7, 3}, {12, 11}}) {
        Frame small(static_cast<size_t>(height * width)), whole = small;
        const Resizer resize(kRows, height, width, level);
        resize(gray.data(), changes.data(), small.data());
        resize(gray.data(), nullptr, whole.data());
        found.push_back(small);
        found.push_back(whole);
    }
    for (const auto& bits : {changes, pair_changes}) found.emplace_back(bits.begin(), bits.end());
    for (int i = 0; i < 40; ++i) {
        Frame row(kScreenWidth, 7);
        Layers layers{};
        Mask* const masks[] = {&layers.player0, &layers.player1, &layers.playfield};
        for (int x = 0; x < kScreenWidth; ++x)  // disjoint sets
            if (const auto which = random() % 4; which < 3) masks[which]->word[x / 64] |= uint64_t{1} << (x % 64);
        const int first = static_cast<int>(random() % kScreenWidth);
        const int last = first + 1 + static_cast<int>(random() % static_cast<unsigned>(kScreenWidth - first));
        const uint8_t colours[4] = {1, 2, 3, 4};
        const bool whole = i % 4 == 0;
        painters()[static_cast<size_t>(level)](row.data(), layers, colours, whole ? 0 : first,
                                               whole ? kScreenWidth : last);
        found.push_back(row);
    }
    found.insert(found.end(), {gray, pairs, rgb});
    return found;
}

}  // namespace
}  // namespace atari

int main() {
    using namespace atari;
    const int levels = static_cast<int>(best_simd_level());
    int wrong = 0;
    for (unsigned seed = 1; seed <= 60; ++seed) {
        const std::vector<Frame> expected = results(seed, SimdLevel::kScalar);
        for (int number = 1; number <= levels; ++number) {
            const auto level = static_cast<SimdLevel>(number);
            if (results(seed, level) == expected) continue;
            std::printf("%s differs from scalar code, seed %u\n", name_of(level), seed);
            ++wrong;
        }
    }
    std::printf("levels up to %s, 60 seeds, %d differ\n", name_of(best_simd_level()), wrong);
    return wrong > 0;
}
