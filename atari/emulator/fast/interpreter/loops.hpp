// Skips the rounds of loops that only wait, count, or divide, by arithmetic. The ordinary handlers run the last round.
// A round of such a loop changes only the cycle count and a register, so the result is the same. No round is skipped if
// the instruction limit may be near.
// (tests/emulator/test_fast_equals_plain.py, test_waiting_and_counting)
#pragma once

#include "handlers.hpp"

namespace atari {

// Returns the rounds whose branch is taken in a loop that counts down to 0 (BNE) or past 0 (BPL). Sets the counter to
// its value in the last round.
INLINE uint32_t Interpreter::rounds_of_count(uint32_t& counter, uint16_t branch) {
    const bool until_zero = branch == BNE_Rel;
    const uint32_t rounds = until_zero ? (counter - 1) & 0xff : counter <= 0x80 ? counter : 0;
    counter = (counter - rounds) & 0xff;
    return rounds;
}

// Returns the rounds, without the last, whose read comes before `end`. The first round's read is `passed` cycles after
// the timer was set.
INLINE uint32_t Interpreter::rounds_before(const R& r, uint32_t passed, uint32_t end) {
    return passed < end ? (end - 1 - passed) / r.at->taken : 0;
}

// BNE waits for 0, BPL for the value after 0, BMI for 127. Until then the timer is in [last, value].
INLINE uint32_t Interpreter::rounds_until_timer(const R& r, const FastConsole& c) {
    const Riot& riot = c.m_.riot;
    const uint16_t wait = r.at[3].handler;
    const uint32_t passed = r.cycles + 4 - 1 - static_cast<uint32_t>(riot.set_at);  // at the loop's first read
    const uint32_t value = riot.timer - (passed >> riot.shift) - 1;                 // the result of the first read
    const uint32_t last = wait == BNE_Rel ? 1 : wait == BPL_Rel ? 0 : 128;
    if (value > 255 || value < last || (wait == BPL_Rel && value > 127)) return 0;
    return rounds_before(r, passed, (riot.timer - last) << riot.shift);
}

// Bit 7 of TIMINT is set when the timer has expired, unless the timer was read since.
INLINE uint32_t Interpreter::rounds_until_expiry(const R& r, const FastConsole& c) {
    const Riot& riot = c.m_.riot;
    const uint32_t passed = r.cycles + 4 - 1 - static_cast<uint32_t>(riot.set_at);
    return riot.read_after_expiry ? 0 : rounds_before(r, passed, uint32_t{riot.timer} << riot.shift);
}

INLINE void Interpreter::skip_rounds(R& r, const FastConsole& c) {
    const R before = r;
    const Loop loop = r.at->loop;
    uint32_t rounds = 0;
    switch (loop) {
        case Loop::kCountX: rounds = rounds_of_count(r.x, r.at[1].handler); break;
        case Loop::kCountY: rounds = rounds_of_count(r.y, r.at[1].handler); break;
        case Loop::kLinesX: rounds = rounds_of_count(r.x, r.at[3].handler); break;
        case Loop::kLinesY: rounds = rounds_of_count(r.y, r.at[3].handler); break;
        case Loop::kTimer: rounds = rounds_until_timer(r, c); break;
        case Loop::kExpiry: rounds = rounds_until_expiry(r, c); break;
        case Loop::kDivide:
            if (c.m_.cpu.d || !r.carry || r.at->operand == 0) return;
            rounds = r.a / r.at->operand;
            r.a -= rounds * r.at->operand;
            break;
        default: return;
    }
    uint32_t end = r.cycles + rounds * r.at->taken, limit = c.cycle_limit_;
    if ((loop == Loop::kLinesX || loop == Loop::kLinesY) && rounds > 0) {
        end = line_start(c, r.cycles + 3) + kCyclesPerLine * (rounds - 1) + r.at->taken;
        limit = c.deadline_ - kCyclesPerLine;  // the first write at or after `deadline_` ends the frame
    }
    if (end < limit) r.cycles = end;
    else r = before;
}

}  // namespace atari
