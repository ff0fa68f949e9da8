// Runs a `Program`: the stack machine of game rules and of writes.
#pragma once

#include <algorithm>
#include <cstdint>

#include "program.hpp"

namespace atari {

// The part of a host whose programs may not act, and read no cartridge and no generator: they call none of these.
struct PassiveHost {
    static uint8_t xbyte(int64_t) { return 0; }
    static uint32_t random() { return 0; }
    static void spend(int) {}
    static void press_select(int64_t) {}
    static void soft_reset() {}
    static void act(int) {}
};

// `host` has the variables, and the functions that the operations need: byte, xbyte and random. Programs that may act
// also need spend, press_select, soft_reset and act.
template <typename Host>
void evaluate(const Program& program, Host&& host) {
    int64_t stack[kMaxStack];
    int64_t* top = stack;  // one past the last value
    const Instruction* const first = program.begin();
    const auto byte = [&](int64_t address) { return int64_t{host.byte(address)}; };
    const auto signed8 = [](int64_t value) { return int64_t{static_cast<int8_t>(value)}; };
    const auto wrap = [](uint64_t value) { return static_cast<int64_t>(value); };
    // Returns the sum of `term` over the bytes lo..hi of RAM.
    const auto sum = [&](int64_t low, int64_t high, auto&& term) {
        int64_t total = 0;
        for (int64_t address = low & 0xff; address <= (high & 0xff); ++address) total += term(byte(address));
        return total;
    };
    for (const Instruction* next = first;;) {
        const auto [op, argument] = *next++;
        const auto binary = [&](auto&& operation) {
            --top;
            top[-1] = operation(top[-1], top[0]);
        };
        switch (op) {
            case Op::kPush: *top++ = argument; break;
            case Op::kLoad: *top++ = host.variables[argument]; break;
            case Op::kStore: host.variables[argument] = static_cast<int32_t>(*--top); break;
            case Op::kRam: top[-1] = byte(top[-1]); break;
            case Op::kXram: top[-1] = int64_t{host.xbyte(top[-1])}; break;
            case Op::kAdd: binary([&](int64_t a, int64_t b) { return wrap(uint64_t(a) + uint64_t(b)); }); break;
            case Op::kSubtract: binary([&](int64_t a, int64_t b) { return wrap(uint64_t(a) - uint64_t(b)); }); break;
            case Op::kMultiply: binary([&](int64_t a, int64_t b) { return wrap(uint64_t(a) * uint64_t(b)); }); break;
            case Op::kDivide: binary([](int64_t a, int64_t b) { return b > 0 ? a / b - (a % b < 0) : 0; }); break;
            case Op::kModulo:
                binary([](int64_t a, int64_t b) { return b > 0 ? a % b + (a % b < 0 ? b : 0) : 0; });
                break;
            case Op::kAnd: binary([](int64_t a, int64_t b) { return a & b; }); break;
            case Op::kOr: binary([](int64_t a, int64_t b) { return a | b; }); break;
            case Op::kXor: binary([](int64_t a, int64_t b) { return a ^ b; }); break;
            case Op::kShiftLeft: binary([&](int64_t a, int64_t b) { return wrap(uint64_t(a) << (b & 31)); }); break;
            case Op::kShiftRight: binary([](int64_t a, int64_t b) { return a >> (b & 31); }); break;
            case Op::kEqual: binary([](int64_t a, int64_t b) -> int64_t { return a == b; }); break;
            case Op::kNotEqual: binary([](int64_t a, int64_t b) -> int64_t { return a != b; }); break;
            case Op::kLess: binary([](int64_t a, int64_t b) -> int64_t { return a < b; }); break;
            case Op::kLessEqual: binary([](int64_t a, int64_t b) -> int64_t { return a <= b; }); break;
            case Op::kGreater: binary([](int64_t a, int64_t b) -> int64_t { return a > b; }); break;
            case Op::kGreaterEqual: binary([](int64_t a, int64_t b) -> int64_t { return a >= b; }); break;
            case Op::kNegate: top[-1] = wrap(0 - uint64_t(top[-1])); break;
            case Op::kInvert: top[-1] = ~top[-1]; break;
            case Op::kNot: top[-1] = top[-1] == 0; break;
            case Op::kJump:
                // A jump backwards is a loop. It costs a frame and one more for every 64 instructions of its body, so
                // that the budget ends it.
                if (first + argument < next) host.spend(1 + static_cast<int>(next - first - argument) / 64);
                next = first + argument;
                break;
            case Op::kJumpIfZero:
                if (*--top == 0) next = first + argument;
                break;
            case Op::kJumpIfZeroElsePop:
                if (top[-1] == 0) next = first + argument;
                else --top;
                break;
            case Op::kJumpIfNotZeroElsePop:
                if (top[-1] != 0) next = first + argument;
                else --top;
                break;
            case Op::kBcd: {
                int64_t value = 0;
                for (int i = 0; i < argument; ++i) {  // the most significant byte is on top
                    const int64_t digits = byte(*--top);
                    value = 100 * value + 10 * (digits >> 4) + (digits & 15);
                }
                *top++ = value;
                break;
            }
            case Op::kSigned8: top[-1] = signed8(top[-1]); break;
            case Op::kCount: {
                top -= argument;
                const int64_t *values = top + 2, *end = top + argument;
                const int64_t found =
                    sum(top[0], top[1], [&](int64_t b) { return int64_t{std::find(values, end, b) != end}; });
                *top++ = found;
                break;
            }
            case Op::kSame:
                binary([&](int64_t low, int64_t high) {
                    return int64_t{sum(low, high, [&](int64_t b) { return int64_t{b != byte(low)}; }) == 0};
                });
                break;
            case Op::kPositiveSum:
                binary([&](int64_t low, int64_t high) {
                    return sum(low, high, [&](int64_t b) { return std::max<int64_t>(signed8(b), 0); });
                });
                break;
            case Op::kNegativeSum:
                binary([&](int64_t low, int64_t high) {
                    return sum(low, high, [&](int64_t b) { return std::max<int64_t>(-signed8(b), 0); });
                });
                break;
            case Op::kRandom: *top++ = host.random(); break;
            case Op::kRandomBetween:
                binary([&](int64_t low, int64_t high) {
                    const uint64_t count = uint64_t(high) - uint64_t(low) + 1;
                    return high < low ? low : wrap(uint64_t(low) + (host.random() * count >> 32));
                });
                break;
            case Op::kPressSelect: host.press_select(*--top); break;
            case Op::kSoftReset: host.soft_reset(); break;
            case Op::kAct: host.act(argument); break;
            case Op::kFail: host.spend(-1); break;
            case Op::kEnd: return;
        }
    }
}

}  // namespace atari
