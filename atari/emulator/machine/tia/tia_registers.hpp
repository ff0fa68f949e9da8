// The table of the TIA's registers: the timing of a write to each, its class in the write log, and the objects that it
// affects.
//
// All code that defers TIA writes uses this table: deferred rendering (deferred_renderer.cpp), deferred collisions
// (collider.cpp, collision_cache.cpp), the shadow copy (tia_shadow.hpp), the decoder, the handlers and the JIT
// translator. The reference TIA (tia.cpp) shares only names and delays, which are tested against ale-py.
#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>

#include "masks.hpp"
#include "machine/raster.hpp"

namespace atari {

// clang-format off
enum Register : uint8_t {
    VSYNC = 0x00, VBLANK, WSYNC, RSYNC, NUSIZ0, NUSIZ1, COLUP0, COLUP1, COLUPF, COLUBK, CTRLPF, REFP0, REFP1,
    PF0, PF1, PF2, RESP0, RESP1, RESM0, RESM1, RESBL, AUDC0, AUDC1, AUDF0, AUDF1, AUDV0, AUDV1,
    GRP0, GRP1, ENAM0, ENAM1, ENABL, HMP0, HMP1, HMM0, HMM1, HMBL, VDELP0, VDELP1, VDELBL, RESMP0, RESMP1,
    HMOVE, HMCLR, CXCLR,
    // Only in the write log (write_log.hpp):
    SAME_TIME,  // the next write comes at the same time as the one before
    PRIORITY,   // CTRLPF, but neither the reflection nor the ball's size changes
    STILL       // HMOVE, at its ordinary cycle and without a motion
};
// clang-format on

// The class of a register's writes in the write log. The decoder derives the kind of a store's operand from it.
enum class TiaStore : uint8_t {
    kNone,  // no register, or one without an effect on the frame
    kVsync,
    kVblank,
    kWsync,
    kValue,   // only holds its value: a write of an equal value changes nothing
    kNusiz,   // kValue, unless a strobe hides a copy, or the Cosmic Ark effect is active
    kCtrlpf,  // kValue, unless a late reflect is pending
    kGrp0,
    kGrp1,    // kValue, unless a delayed copy changes
    kStrobe,  // acts at every write
    kMotion,  // its value takes effect when HMOVE is written
    kHmove,
    kHmclr,
    kCxclr,
    kSound,
};

// The effect of a write on collisions.
enum class Collides : uint8_t {
    kNever,
    kByLook,  // changes the object's shape, not its position: may be deferred until the object could collide
    kTricks,  // only ends the Cosmic Ark effect or a strobe's hiding
    kAlways,  // later writes depend on its effect
};

// In a set of objects: a missile or the ball is placed, which may depend on the time of HMOVE.
inline constexpr unsigned kPlacing = 1u << 6;

struct TiaRegister {
    TiaStore store = TiaStore::kNone;
    uint8_t bits = 0;  // the bits of a value that the register has
    // The clocks after which a write takes effect, by the two low bits of its cycle in the line.
    std::array<uint8_t, 4> delay{};
    // A set of objects, and kPlacing: the objects that a write may make visible, or whose position or reflection it
    // sets or reads.
    uint8_t objects = 0;
    Collides collides = Collides::kAlways;
};

inline constexpr auto kTiaRegisters = [] {
    using enum TiaStore;
    using enum Collides;
    using Delay = std::array<uint8_t, 4>;
    constexpr Delay kNow{}, kOne{1, 1, 1, 1}, kEight{8, 8, 8, 8}, kPlayfield{4, 5, 2, 3};
    constexpr uint8_t P0 = 1 << kP0, P1 = 1 << kP1, M0 = 1 << kM0, M1 = 1 << kM1, BL = 1 << kBL, placing = kPlacing;
    struct Row {
        Register reg;
        TiaRegister facts;
    };
    constexpr Row kRows[] = {
        // register  store  bits  delay  objects  collides
        {VSYNC, {kVsync, 0x02}},
        {VBLANK, {kVblank, 0xc2, kOne}},
        {WSYNC, {kWsync}},
        {RSYNC, {kNone}},
        {NUSIZ0, {kNusiz, 0x37, kEight}},
        {NUSIZ1, {kNusiz, 0x37, kEight}},
        {COLUP0, {kValue, 0xfe, kNow, 0, kNever}},
        {COLUP1, {kValue, 0xfe, kNow, 0, kNever}},
        {COLUPF, {kValue, 0xfe, kNow, 0, kNever}},
        {COLUBK, {kValue, 0xfe, kNow, 0, kNever}},
        {CTRLPF, {kCtrlpf, 0x37}},
        {REFP0, {kValue, 0x08, kOne, P0, kByLook}},
        {REFP1, {kValue, 0x08, kOne, P1, kByLook}},
        {PF0, {kValue, 0xf0, kPlayfield, 0, kByLook}},
        {PF1, {kValue, 0xff, kPlayfield, 0, kByLook}},
        {PF2, {kValue, 0xff, kPlayfield, 0, kByLook}},
        {RESP0, {kStrobe, 0, kNow, P0}},
        {RESP1, {kStrobe, 0, kNow, P1}},
        {RESM0, {kStrobe, 0, kEight, M0 | placing}},
        {RESM1, {kStrobe, 0, kEight, M1 | placing}},
        {RESBL, {kStrobe, 0, kNow, BL | placing}},
        {AUDC0, {kSound, 0x0f}},
        {AUDC1, {kSound, 0x0f}},
        {AUDF0, {kSound, 0x1f}},
        {AUDF1, {kSound, 0x1f}},
        {AUDV0, {kSound, 0x0f}},
        {AUDV1, {kSound, 0x0f}},
        {GRP0, {kGrp0, 0xff, kOne, P0, kByLook}},
        {GRP1, {kGrp1, 0xff, kOne, P1, kByLook}},
        {ENAM0, {kValue, 0x02, kNow, M0, kByLook}},
        {ENAM1, {kValue, 0x02, kNow, M1, kByLook}},
        {ENABL, {kValue, 0x02, kNow, BL, kByLook}},
        {HMP0, {kMotion, 0xf0}},
        {HMP1, {kMotion, 0xf0}},
        {HMM0, {kMotion, 0xf0, kNow, placing}},  // the Cosmic Ark effect
        {HMM1, {kMotion, 0xf0}},
        {HMBL, {kMotion, 0xf0}},
        {VDELP0, {kValue, 0x01}},
        {VDELP1, {kValue, 0x01}},
        {VDELBL, {kValue, 0x01, kNow, BL}},
        {RESMP0, {kValue, 0x02, kNow, P0 | M0}},
        {RESMP1, {kValue, 0x02, kNow, P1 | M1}},
        {HMOVE, {kHmove, 0, kNow, placing}},
        {HMCLR, {kHmclr}},
        {CXCLR, {kCxclr}},
        {SAME_TIME, {kNone}},
        {PRIORITY, {kNone, 0x37, kNow, 0, kNever}},
        {STILL, {kNone, 0, kNow, placing, kTricks}},
    };
    std::array<TiaRegister, 64> table{};
    for (const Row& row : kRows) table[row.reg] = row.facts;
    return table;
}();

// Returns the register of an address below 0x80 or one of its mirrors.
inline constexpr uint8_t kRegisterMask = 0x3f;
constexpr uint8_t tia_register(unsigned address) { return address & kRegisterMask; }

constexpr uint8_t bits_of(uint8_t reg) { return kTiaRegisters[reg].bits; }

// Returns the delay of a register whose delay does not depend on the cycle.
constexpr int32_t delay_of(uint8_t reg) { return kTiaRegisters[reg].delay[0]; }

// Returns a set of registers as bits.
constexpr uint64_t set_of(std::initializer_list<uint8_t> registers) {
    uint64_t set = 0;
    for (const uint8_t reg : registers) set |= 1ull << reg;
    return set;
}
template <typename Holds>
constexpr uint64_t registers_where(Holds holds) {
    uint64_t set = 0;
    for (unsigned reg = 0; reg < kTiaRegisters.size(); ++reg) set |= uint64_t{holds(kTiaRegisters[reg])} << reg;
    return set;
}

// Bits of VBLANK and CTRLPF.
inline constexpr uint8_t kBlanks = 0x02;
inline constexpr uint8_t kReflects = 0x01, kScore = 0x02, kPlayfieldFirst = 0x04, kBallSize = 0x30;
// The bits of CTRLPF that change shapes and not only colours.
inline constexpr uint8_t kShapesOfCtrlpf = kReflects | kBallSize;

// Before this cycle of a line, a write to CTRLPF reflects the playfield at once. From this cycle on, the reflection
// takes effect at the line's end: a late reflect.
inline constexpr uint32_t kLateReflect = 49;

// The Cosmic Ark effect: HMM0 changes from 7 to 6 this many clocks after HMOVE, which leaves missile 0 moving.
inline constexpr uint8_t kArkMotion = 7;
inline constexpr uint32_t kArkClocks = 63;
constexpr bool may_play_ark(uint8_t reg, uint8_t old_value, uint8_t value) {
    return reg == HMM0 && old_value >> 4 == kArkMotion && value >> 4 == kArkMotion - 1;
}

// Returns whether an HMOVE at this cycle makes eight pixels at the left edge black.
constexpr bool hmove_blanks(uint32_t cycle_in_line) {
    return cycle_in_line <= 20 || cycle_in_line == kCyclesPerLine - 1;
}

// In the last cycle of a line, and in its first cycles up to this number, HMOVE moves objects by their motions alone.
inline constexpr uint32_t kOrdinaryHmoveCycles = 4;
constexpr bool is_ordinary_hmove(uint32_t cycle) { return (cycle + 1) % kCyclesPerLine <= kOrdinaryHmoveCycles; }

}  // namespace atari
