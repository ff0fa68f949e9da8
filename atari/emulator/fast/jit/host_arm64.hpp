// Translated code on arm64: the registers that it uses, its entry and exit, and its calls. The calling convention is the
// same on all systems, as far as it matters here. Register x18 belongs to the system on some.
#pragma once

#include <cstdint>

#include "assembler_arm64.hpp"

namespace atari::arm64 {

inline constexpr char kProcessor[] = "arm64";

// The registers t0 to t3 are free for any use.
inline constexpr Reg kA = numbered(3), kX = numbered(4), kY = numbered(5), kNz = numbered(6), kCarry = numbered(7);
inline constexpr Reg kConsole = numbered(19), kRam = numbered(20), kRegisters = numbered(21), kCycles = numbered(22),
                     kLog = numbered(23);
inline constexpr Reg t0 = numbered(8), t1 = numbered(9), t2 = numbered(10), t3 = numbered(11);
inline constexpr Reg kResult = numbered(0);
inline constexpr Reg kReturn = numbered(24);  // the link register of a routine, while it calls a function

// The registers that a function must keep, as far as translated code changes them, in pairs.
inline constexpr Reg kKept[][2] = {{numbered(29), kLink}, {kConsole, kRam}, {kRegisters, kCycles}, {kLog, kReturn}};

// Begins translated code, a function of the registers, the console and an entry. The entry is then in t0.
inline void enter(Assembler& a) {
    a.add_to_stack(-int32_t{sizeof kKept / 2 * 16});
    for (uint32_t i = 0; i < std::size(kKept); ++i) a.store_pair(kKept[i][0], kKept[i][1], i);
    a.move64(kRegisters, numbered(0));
    a.move64(kConsole, numbered(1));
    a.move64(t0, numbered(2));
}

// Ends translated code. The result is in kResult.
inline void leave(Assembler& a) {
    for (uint32_t i = 0; i < std::size(kKept); ++i) a.load_pair(kKept[i][0], kKept[i][1], i);
    a.add_to_stack(int32_t{sizeof kKept / 2 * 16});
    a.ret();
}

// A routine leaves translated code by itself: nothing of its call is on the stack.
inline void call_routine_or_exit(Assembler& a, JumpLabel& routine, JumpLabel&) { a.call(routine); }
inline void return_to_caller(Assembler& a) { a.ret(); }

// In a routine, calls a function of the registers and the console. If the result is not 0, translated code ends with
// it.
inline void call_function(Assembler& a, uintptr_t function, JumpLabel& exit) {
    a.move64(kReturn, kLink);
    a.move64(numbered(0), kRegisters);
    a.move64(numbered(1), kConsole);
    a.move64(t1, uint64_t{function});
    a.call(t1);
    a.move64(kLink, kReturn);
    a.test(kResult);
    a.jump(If::not_zero, exit);
}

}  // namespace atari::arm64
