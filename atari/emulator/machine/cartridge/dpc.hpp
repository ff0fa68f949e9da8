// The DPC chip of Pitfall II: eight data fetchers, a random number generator and three square waves.
//
// Its registers are at offsets 0x00 .. 0x7f of the window: the lower half is read, the upper half is written.
#pragma once

#include <array>
#include <cstdint>

#include "cartridge.hpp"

namespace atari {

// By present random number, the next one.
inline constexpr auto kDpcRandom = [] {
    std::array<uint8_t, 256> table{};
    for (unsigned random = 0; random < 256; ++random) {
        const unsigned bit = ~(random >> 7 ^ random >> 5 ^ random >> 4 ^ random >> 3) & 1;
        table[random] = static_cast<uint8_t>(random << 1 | bit);
    }
    return table;
}();

// The generator advances at every access of the cartridge that is not plain ROM.
void clock_dpc_random(CartridgeState& cart);
// Reads a register, which also advances the generator. `image` is the cartridge's: the fetchers read its last 2 KiB.
uint8_t read_dpc(CartridgeState& cart, const uint8_t* image, unsigned offset, uint32_t cycles);
void write_dpc(CartridgeState& cart, unsigned offset, uint8_t value);

}  // namespace atari
