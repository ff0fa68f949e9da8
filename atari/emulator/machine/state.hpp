// The state of the machine's chips as one trivially copyable struct without pointers.
//
// A snapshot of a `Console` also has the RAM of the cartridge, if any, and the two framebuffers. A snapshot of a
// `FastConsole` also has its `FrameHistory`: deferred frames and deferred collisions. The ROM image is constant, and
// object masks are derived, so neither is part of the state.
#pragma once

#include <cstdint>
#include <type_traits>
#include <vector>

#include "machine/cartridge/cartridge.hpp"
#include "machine/cpu/cpu.hpp"
#include "inputs.hpp"
#include "riot.hpp"
#include "machine/tia/sound.hpp"
#include "machine/tia/tia_state.hpp"

namespace atari {

struct Machine {
    uint32_t cycles;
    uint8_t bus;  // the byte last on the data bus
    Cpu cpu;
    Riot riot;
    Tia tia;
    CartridgeState cart;
    Inputs inputs;
    Sound sound;
    uint64_t random_words;  // drawn from the machine's generator
};

static_assert(std::is_trivially_copyable_v<Machine>);

// A snapshot in memory. Each class of console has its own snapshot class and restores only that.
struct ConsoleSnapshot {
    virtual ~ConsoleSnapshot() = default;

    Machine machine;
    std::vector<uint8_t> cart_ram;
    std::vector<uint8_t> framebuffers[2];  // the last bytes of each; `FastConsole` omits rows that it renders again
};

}  // namespace atari
