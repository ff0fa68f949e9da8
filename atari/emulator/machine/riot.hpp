// The RIOT (6532): RAM, timer, and the ports of controllers and console switches.
//
// `Riot` needs no other chip. The timer does not count: it is computed from the cycle of the last write and the present
// cycle, which each access brings along.
#pragma once

#include <cstdint>

#include "console_config.hpp"
#include "flag.hpp"
#include "inputs.hpp"

namespace atari {

struct Riot {
    uint8_t ram[128];  // the bus accesses it directly
    uint8_t timer;     // the written value
    uint8_t shift;     // 0, 3, 6 or 10
    uint8_t ddr_a;
    Flag read_after_expiry;
    int32_t set_at;  // cycle of the last write
    int32_t irq_at;  // cycle of the first read after expiry

    uint8_t read(uint16_t address, uint32_t cycles, const Inputs& inputs, const ConsoleConfig& config);
    void write(uint16_t address, uint8_t value, uint32_t cycles);
    // Resets the timer at cycle 0, with a random word. RAM keeps its contents.
    void reset(uint32_t word);
    // Draws the timer's first value from a random word.
    void draw_timer(uint32_t word) { timer = static_cast<uint8_t>(25 + word % 75); }
    // Makes cycle number `cycles` number 0.
    void rebase(uint32_t cycles);

  private:
    uint8_t read_timer(uint32_t cycles);
};

}  // namespace atari
