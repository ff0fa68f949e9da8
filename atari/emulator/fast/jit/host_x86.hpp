// Translated code on x86-64: the registers that it uses, its entry and exit, and its calls, by the calling convention of
// Unix or that of Windows.
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>

#include "assembler_x86.hpp"

namespace atari::x86 {

inline constexpr char kProcessor[] = "x86-64";

// The registers t0 to t3 are free for any use.
inline constexpr Reg kA = rax, kX = rcx, kY = rdx, kNz = rsi, kCarry = rdi;
inline constexpr Reg kConsole = rbx, kRam = rbp, kRegisters = r12, kCycles = r13, kLog = r14;
inline constexpr Reg t0 = r8, t1 = r9, t2 = r10, t3 = r11;
inline constexpr Reg kResult = rax;

// The first three arguments of a function, and the registers that a function must keep, as far as translated code
// changes them. With an odd number of them, 8 bytes align the stack for calls in routines.
#if defined(_WIN32)
inline constexpr Reg kArguments[] = {rcx, rdx, r8};
inline constexpr Reg kKept[] = {rbx, rbp, rsi, rdi, r12, r13, r14};
inline constexpr int8_t kShadowSpace = 32;  // the bytes on the stack that a function's caller leaves free for it
#else
inline constexpr Reg kArguments[] = {rdi, rsi, rdx};
inline constexpr Reg kKept[] = {rbx, rbp, r12, r13, r14};
inline constexpr int8_t kShadowSpace = 0;
#endif
static_assert(std::size(kKept) % 2 == 1);

// Begins translated code, a function of the registers, the console and an entry. The entry is then in t0.
inline void enter(Assembler& a) {
    for (const Reg reg : kKept) a.push(reg);
    a.add_to_stack(-8);
    a.move64(kRegisters, kArguments[0]);
    a.move64(kConsole, kArguments[1]);
    if (kArguments[2] != t0) a.move64(t0, kArguments[2]);
}

// Ends translated code. The result is in kResult.
inline void leave(Assembler& a) {
    a.add_to_stack(8);
    for (std::size_t i = std::size(kKept); i-- > 0;) a.pop(kKept[i]);
    a.ret();
}

// A routine returns with the carry set if translated code must exit: calls and returns are balanced, because a hardware
// shadow stack requires that.
inline void call_routine_or_exit(Assembler& a, JumpLabel& routine, JumpLabel& exit) {
    a.call(routine);
    a.jump(If::below, exit);
}

// Returns from a routine, with the carry clear. Addition to the cycle count, logical operations and moves leave it so.
inline void return_to_caller(Assembler& a) { a.ret(); }

// In a routine, calls a function of the registers and the console. If the result is not 0, the routine's caller exits
// with it.
inline void call_function(Assembler& a, uintptr_t function, JumpLabel&) {
    a.move64(kArguments[0], kRegisters);
    a.move64(kArguments[1], kConsole);
    a.move64(t1, uint64_t{function});
    if (kShadowSpace) a.add_to_stack(-kShadowSpace);
    a.call(t1);
    if (kShadowSpace) a.add_to_stack(kShadowSpace);
    a.test(kResult);  // clears the carry
    const ShortJump stays = a.jump_short(If::zero);
    a.set_carry();
    a.ret();
    a.bind_short(stays);
}

}  // namespace atari::x86
