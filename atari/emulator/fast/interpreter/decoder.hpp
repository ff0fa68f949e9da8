// Decodes a cartridge's code once: a decoded instruction for every byte of the image at which an instruction may begin.
//
// A decoded instruction names its handler. The operation and the kind of its operand select the handler, so that the
// handler decides nothing at run time that the decoder can decide. A jump into the middle of an instruction finds a
// decoded instruction there too, so no analysis of the program is needed. Rare instructions, and those whose effect
// depends on the bus, get the handler `kStep`: they fall back to the plain interpreter. Decoded instructions never
// change, so all machines with the cartridge share them.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "machine/cpu/opcodes.hpp"
#include "machine/state.hpp"
#include "machine/tia/tia_registers.hpp"

namespace atari {

class Cartridge;

// The kind of an operand, as far as the bytes of the instruction determine it.
// clang-format off
enum class Operand : uint8_t {
    Imp, Acc, Imm, Rel,
    Near, Far, Ind,    // jumps: within the 4 KiB bank, anywhere, through a pointer
    Ram, RamX, RamY,   // zero page: RAM; indexed, RAM or TIA by the index
    RamA,              // RAM by an address of two bytes
    Fixed,             // a constant: a byte of the image that this code always sees at this address
    Timer,             // INTIM
    Input,             // INPT0 .. INPT5 and the two addresses after them, in the zero page
    Dpc,               // the registers of the DPC chip
    RomX, RomY,        // indexed; every address in reach is plain image
    AnyX, AnyY,        // indexed, anywhere
    IndX, IndY,
    PortZ, PortA,      // anything else, by an address of one byte or two
    Tia,               // stores: a register for which writing an equal value again has no effect
    Strobe,            // stores: a register that acts at every write
    Motion,            // stores: HMP0 .. HMBL, which act when HMOVE is written
    Nusiz, Hmove, Ctrlpf, Grp0, Grp1, Wsync, Sound, Hmclr, Cxclr,
    TiaA, Grp0A, Grp1A,  // the same by an address of two bytes
    kCount
};
// clang-format on

// Returns the kind of operand of a store to a TIA register.
constexpr Operand stored_in(uint8_t reg) {
    switch (kTiaRegisters[reg].store) {
        case TiaStore::kWsync: return Operand::Wsync;
        case TiaStore::kValue: return Operand::Tia;
        case TiaStore::kNusiz: return Operand::Nusiz;
        case TiaStore::kCtrlpf: return Operand::Ctrlpf;
        case TiaStore::kGrp0: return Operand::Grp0;
        case TiaStore::kGrp1: return Operand::Grp1;
        case TiaStore::kStrobe: return Operand::Strobe;
        case TiaStore::kMotion: return Operand::Motion;
        case TiaStore::kHmove: return Operand::Hmove;
        case TiaStore::kHmclr: return Operand::Hmclr;
        case TiaStore::kCxclr: return Operand::Cxclr;
        case TiaStore::kSound: return Operand::Sound;
        default: return Operand::PortZ;
    }
}

constexpr auto kStoredIn = [] {
    std::array<Operand, 64> table{};
    for (uint8_t reg = 0; reg < 64; ++reg) table[reg] = stored_in(reg);
    return table;
}();

// Returns the length in bytes of an instruction with such an operand.
// clang-format off
constexpr int length_of(Operand operand) {
    switch (operand) {
        case Operand::Imp: case Operand::Acc: return 1;
        case Operand::Fixed: case Operand::RamA: case Operand::Timer: case Operand::Dpc: case Operand::RomX:
        case Operand::RomY: case Operand::AnyX: case Operand::AnyY: case Operand::PortA: case Operand::TiaA:
        case Operand::Grp0A: case Operand::Grp1A: case Operand::Near:
        case Operand::Far: case Operand::Ind: return 3;
        default: return 2;
    }
}

// The cycles of a read, a store and a read-modify-write, without page crossings.
constexpr uint32_t read_cost(Operand operand) {
    switch (operand) {
        case Operand::Imm: return 2;
        case Operand::Ram: case Operand::Input: case Operand::PortZ: return 3;
        case Operand::IndY: return 5;
        case Operand::IndX: return 6;
        default: return 4;
    }
}
constexpr uint32_t store_cost(Operand operand) {
    switch (operand) {
        case Operand::RamX: case Operand::RamY: case Operand::RamA: case Operand::PortA: case Operand::TiaA:
        case Operand::Grp0A: case Operand::Grp1A: return 4;
        case Operand::AnyX: case Operand::AnyY: return 5;
        case Operand::IndX: case Operand::IndY: return 6;
        default: return 3;
    }
}
// clang-format on
constexpr uint32_t modify_cost(Operand operand) {
    return operand == Operand::Acc ? 2 : operand == Operand::Ram ? 5 : 6;
}

enum Handler : uint16_t {
    kStep,        // falls back to the plain interpreter for one instruction
    kLoop,        // a loop whose rounds can be skipped, except the last (loops.hpp)
    kRamCode,     // an instruction in RAM, which may have changed since it was decoded
    kTranslated,  // only reached through `code`: translated code begins here (translated_code.hpp)
#define SINGLE(operation, operand) operation##_##operand,
#define PAIR(o1, k1, o2, k2) o1##_##k1##_##o2##_##k2,
#include "handlers.def"
    kHandlers
};

// Loops that only wait, count, or divide. They are skipped by arithmetic.
enum class Loop : uint8_t {
    kNone,
    kTimer,   // LDA, LDX or LDY of INTIM; BNE, BPL or BMI
    kExpiry,  // LDA, LDX, LDY or BIT of TIMINT; BPL
    kCountX,
    kCountY,  // DEX or DEY; BNE or BPL
    kLinesX,
    kLinesY,  // the same after a WSYNC
    kDivide,  // SBC of a constant; BCS
};

struct DecodedInstruction {
    const void* code;  // label of the handler, see `code_of`
    uint16_t handler;
    uint16_t operand;  // index into RAM, address, constant or register
    int16_t jump;      // to the target of a branch or near jump; under kLoop, the first instruction's handler
    uint8_t taken;     // cycles of the branch when it is taken; under kLoop, of one round
    Loop loop;         // under kLoop
};

// Returns the label of a handler in the fast interpreter, so that one indirect jump reaches it (interpreter.cpp).
// Returns null in builds that choose handlers by a switch.
const void* code_of(uint16_t handler);

bool is_branch(uint16_t handler);

// Returns whether both bytes of a zero-page pointer are in RAM. The second byte must not be the TIA's $0100.
constexpr bool pointer_in_ram(uint32_t zero_page) { return zero_page - 0x80 < 0x7f; }

// Decodes the instruction that begins at `bytes`, which is `available` bytes before the end of its slice or of RAM.
// `bank` is the image of the window that the instruction runs in. It is null if that window is not one bank, so that
// the operand's bytes may change.
DecodedInstruction decode(const uint8_t* bytes, int available, const Cartridge& cartridge, const uint8_t* bank);

// Returns a decoded instruction for each byte of the image, and one more, on which execution leaves the image.
std::vector<DecodedInstruction> decode_image(const Cartridge& cartridge);

}  // namespace atari
