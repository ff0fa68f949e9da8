#include "averaging.hpp"

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <memory>

namespace atari {
namespace {

uint8_t mixed(uint32_t a, uint32_t b, const Palette& palette) {
    int channel[3];
    for (int k = 0; k < 3; ++k) {
        const int first = static_cast<int>(a >> (8 * k) & 0xff), second = static_cast<int>(b >> (8 * k) & 0xff);
        const int high = std::max(first, second), low = std::min(first, second);
        channel[k] = std::min(255, (high - low) * 77 / 100 + low) & ~3;
    }
    int nearest = 0, least = 1 << 20;
    for (int index = 0; index < 256; index += 2) {
        int distance = 0;
        for (int k = 0; k < 3; ++k)
            distance += std::abs(static_cast<int>(palette.rgb[index] >> (8 * k) & 0xff) - channel[k]);
        if (distance < least) {
            least = distance;
            nearest = index;
        }
    }
    return static_cast<uint8_t>(nearest);
}

using Table = uint8_t[128][128];

// Returns the blend table of a palette. The first call makes it, and nothing destroys it: threads may average frames
// while the process exits. There is no lock, which another thread could hold when the process is forked.
const Table& table(const Palette& palette) {
    static std::atomic<const Table*> tables[3];  // for NTSC, PAL and SECAM
    std::atomic<const Table*>& made = tables[&palette == &PAL ? 1 : &palette == &SECAM ? 2 : 0];
    if (const Table* const table = made.load(std::memory_order_acquire)) return *table;
    std::unique_ptr<Table[]> table(new Table[1]);
    for (int a = 0; a < 128; ++a)
        for (int b = 0; b < 128; ++b) table[0][a][b] = mixed(palette.rgb[2 * a], palette.rgb[2 * b], palette);
    const Table* first = nullptr;  // made by another thread meanwhile
    return made.compare_exchange_strong(first, &table[0]) ? *table.release() : *first;
}

}  // namespace

void average_framebuffers(const uint8_t* current, const uint8_t* previous, size_t count, const Palette& palette,
                          uint8_t* out) {
    const Table& blend = table(palette);
    for (size_t i = 0; i < count; ++i) out[i] = blend[current[i] >> 1][previous[i] >> 1];
}

}  // namespace atari
