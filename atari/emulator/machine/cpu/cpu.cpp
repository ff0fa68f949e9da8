#include "cpu.hpp"

namespace atari {
namespace {

// Decimal mode, invalid digits included: converts two digits to a number, and a number to two digits.
int from_digits(int byte) { return (byte >> 4) * 10 + (byte & 15); }
int to_digits(int number) { return (number % 100 / 10) << 4 | number % 10; }

}  // namespace

uint8_t Cpu::status() const { return static_cast<uint8_t>(n << 7 | v << 6 | 0x30 | d << 3 | i << 2 | z << 1 | c); }

void Cpu::set_status(uint8_t value) {
    n = value & 0x80;
    v = value & 0x40;
    d = value & 0x08;
    i = value & 0x04;
    z = value & 0x02;
    c = value & 0x01;
}

void Cpu::adc(uint8_t operand) {
    const uint8_t old = a;
    if (d) {
        const int sum = from_digits(old) + from_digits(operand) + c;
        c = sum > 99;
        a = static_cast<uint8_t>(to_digits(sum & 0xff));
        v = (old ^ a) & (a ^ operand) & 0x80;
    } else {
        const int sum = old + operand + c;
        c = sum > 255;
        a = static_cast<uint8_t>(sum);
        v = (old ^ a) & (operand ^ a) & 0x80;
    }
    set_nz(a);
}

void Cpu::sbc(uint8_t operand) {
    if (!d) return adc(static_cast<uint8_t>(~operand));
    const uint8_t old = a;
    int difference = from_digits(old) - from_digits(operand) - !c;
    if (difference < 0) difference += 100;
    // With invalid digits the value may still be negative. ALE then reads before the start of a table, with this
    // result.
    a = static_cast<uint8_t>(difference >= 0 ? to_digits(difference) : from_digits(256 + difference));
    c = old >= operand + !c;
    v = (old ^ a) & (a ^ operand) & 0x80;
    set_nz(a);
}

void Cpu::arr(uint8_t operand) {
    const int masked = a & operand;
    int result = masked >> 1 | c << 7;
    if (d) {
        n = c;
        z = result == 0;
        v = (masked ^ result) & 0x40;
        if ((masked & 15) + (masked & 1) > 5) result = (result & 0xf0) | ((result + 6) & 15);
        c = (masked & 0xf0) + (masked & 0x10) > 0x50;
        if (c) result = (result + 0x60) & 0xff;
    } else {
        set_nz(static_cast<uint8_t>(result));
        c = result & 0x40;
        v = (result >> 6 ^ result >> 5) & 1;
    }
    a = static_cast<uint8_t>(result);
}

}  // namespace atari
