#include "riot.hpp"

#include "raster.hpp"

namespace atari {

void Riot::reset(uint32_t word) {
    draw_timer(word);
    shift = 6;
    set_at = irq_at = 0;
    read_after_expiry = false;
    ddr_a = 0;
}

// A stamp without a further use is set to 0, so that states with the same future compare equal.
void Riot::rebase(uint32_t cycles) {
    rebase_stamp(set_at, cycles);
    if (read_after_expiry) rebase_stamp(irq_at, cycles);
    else irq_at = 0;
}

// The timer after expiry is as in ALE, which differs from the chip. The first read after expiry stores an offset. From
// then on the timer counts once an interval again.
uint8_t Riot::read_timer(uint32_t cycles) {
    const uint32_t delta = cycles - 1 - static_cast<uint32_t>(set_at);
    const uint32_t intervals = delta >> shift;
    const auto left = static_cast<int32_t>(timer - intervals - 1);
    if (left >= 0) return static_cast<uint8_t>(left);
    const auto past = static_cast<int32_t>((uint32_t{timer} << shift) - delta - 1);
    if (past <= -2 && !read_after_expiry) {
        read_after_expiry = true;
        irq_at = static_cast<int32_t>(cycles);
    }
    if (!read_after_expiry) return static_cast<uint8_t>(past);
    const uint32_t offset =
        static_cast<uint32_t>(irq_at) - static_cast<uint32_t>(set_at) - (static_cast<uint32_t>(timer) << shift);
    return static_cast<uint8_t>(timer - intervals - offset);
}

namespace {

// Returns the eight direction pins of both jacks, 1 if open: the left jack in the high nibble, the right one in the
// low.
uint8_t port_a(const Inputs& inputs, const ConsoleConfig& config) {
    uint8_t nibble[2];
    for (int side = 0; side < 2; ++side) {
        if (config.paddles[side]) {
            const int first = 2 * side + (config.swap_paddles ? 1 : 0), second = first ^ 1;
            const int pressed = (inputs.paddle_fire[second] ? 4 : 0) | (inputs.paddle_fire[first] ? 8 : 0);
            nibble[side] = static_cast<uint8_t>(0xf & ~pressed);
        } else {
            nibble[side] = static_cast<uint8_t>(0xf & ~inputs.stick[side]);
        }
    }
    const int left = config.swap_ports ? 1 : 0;
    return static_cast<uint8_t>(nibble[left] << 4 | nibble[left ^ 1]);
}

}  // namespace

uint8_t Riot::read(uint16_t address, uint32_t cycles, const Inputs& inputs, const ConsoleConfig& config) {
    switch (address & 7) {
        case 0: return port_a(inputs, config);
        case 1: return ddr_a;
        case 2: return inputs.switches;
        case 3: return 0;
        case 4:
        case 6: return read_timer(cycles);
        default: {
            const uint32_t delta = cycles - 1 - static_cast<uint32_t>(set_at);
            const auto left = static_cast<int32_t>(timer - (delta >> shift) - 1);
            return left >= 0 || read_after_expiry ? 0x00 : 0x80;
        }
    }
}

void Riot::write(uint16_t address, uint8_t value, uint32_t cycles) {
    static constexpr uint8_t kShift[4] = {0, 3, 6, 10};
    if ((address & 7) == 1) {
        ddr_a = value;
    } else if ((address & 7) >= 4 && (address & 0x14) == 0x14) {
        timer = value;
        shift = kShift[address & 3];
        set_at = static_cast<int32_t>(cycles);
        read_after_expiry = false;
    }
}

}  // namespace atari
