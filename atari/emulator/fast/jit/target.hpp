// The processor for which the translator emits code: its assembler, and its registers and calls (host_*.hpp).
#pragma once

#if defined(__aarch64__) || defined(_M_ARM64)
#include "host_arm64.hpp"
namespace atari {
using namespace arm64;
inline constexpr bool kHasAssembler = true;
}  // namespace atari
#else
#include "host_x86.hpp"
namespace atari {
using namespace x86;
#if defined(__x86_64__) || defined(_M_X64)
inline constexpr bool kHasAssembler = true;
#else
inline constexpr bool kHasAssembler = false;
#endif
}  // namespace atari
#endif

namespace atari {

// The entries of blocks are reached through the labels of the decoded instructions (interpreter.cpp), which only GCC
// and Clang have.
#if (defined(__GNUC__) || defined(__clang__)) && !defined(ATARI_NO_COMPUTED_GOTO)
inline constexpr bool kTranslates = kHasAssembler && sizeof(void*) == 8;
#else
inline constexpr bool kTranslates = false;
#endif

}  // namespace atari
