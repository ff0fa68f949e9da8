// The RIOT (6532): timer, and the ports of controllers and console switches. Its RAM is read by the bus directly.
#include "console.hpp"

namespace atari {

// The timer after expiry is as in ALE, which differs from the chip. The first read after expiry stores an offset. From
// then on the timer counts once an interval again.
uint8_t Console::read_timer() {
    Riot& riot = m_.riot;
    const uint32_t delta = m_.cycles - 1 - static_cast<uint32_t>(riot.set_at);
    const uint32_t intervals = delta >> riot.shift;
    const auto left = static_cast<int32_t>(riot.timer - intervals - 1);
    if (left >= 0) return static_cast<uint8_t>(left);
    const auto past = static_cast<int32_t>((uint32_t{riot.timer} << riot.shift) - delta - 1);
    if (past <= -2 && !riot.read_after_expiry) {
        riot.read_after_expiry = true;
        riot.irq_at = static_cast<int32_t>(m_.cycles);
    }
    if (!riot.read_after_expiry) return static_cast<uint8_t>(past);
    const uint32_t offset = static_cast<uint32_t>(riot.irq_at) - static_cast<uint32_t>(riot.set_at) -
                            (static_cast<uint32_t>(riot.timer) << riot.shift);
    return static_cast<uint8_t>(riot.timer - intervals - offset);
}

uint8_t Console::read_riot(uint16_t address) {
    switch (address & 7) {
        case 0: return switch_a();
        case 1: return m_.riot.ddr_a;
        case 2: return m_.inputs.switches;
        case 3: return 0;
        case 4:
        case 6: return read_timer();
        default: {
            const uint32_t delta = m_.cycles - 1 - static_cast<uint32_t>(m_.riot.set_at);
            const auto left = static_cast<int32_t>(m_.riot.timer - (delta >> m_.riot.shift) - 1);
            return left >= 0 || m_.riot.read_after_expiry ? 0x00 : 0x80;
        }
    }
}

void Console::write_riot(uint16_t address, uint8_t value) {
    static constexpr uint8_t kShift[4] = {0, 3, 6, 10};
    if ((address & 7) == 1) {
        m_.riot.ddr_a = value;
    } else if ((address & 7) >= 4 && (address & 0x14) == 0x14) {
        m_.riot.timer = value;
        m_.riot.shift = kShift[address & 3];
        m_.riot.set_at = static_cast<int32_t>(m_.cycles);
        m_.riot.read_after_expiry = false;
    }
}

// Returns the eight direction pins of both jacks, 1 if open: the left jack in the high nibble, the right one in the
// low.
uint8_t Console::switch_a() const {
    uint8_t nibble[2];
    for (int side = 0; side < 2; ++side) {
        if (config_.paddles[side]) {
            const int first = 2 * side + (config_.swap_paddles ? 1 : 0), second = first ^ 1;
            const int pressed = (m_.inputs.paddle_fire[second] ? 4 : 0) | (m_.inputs.paddle_fire[first] ? 8 : 0);
            nibble[side] = static_cast<uint8_t>(0xf & ~pressed);
        } else {
            nibble[side] = static_cast<uint8_t>(0xf & ~m_.inputs.stick[side]);
        }
    }
    const int left = config_.swap_ports ? 1 : 0;
    return static_cast<uint8_t>(nibble[left] << 4 | nibble[left ^ 1]);
}

}  // namespace atari
