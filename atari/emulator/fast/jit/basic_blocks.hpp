// The basic blocks of a cartridge's code, for the JIT translator (translator.hpp), with the block-entry state of each
// instruction.
//
// A block is a straight line of 6502 instructions that jumps enter only at the first one, its leader. It is an extended
// basic block: a taken branch leaves it, and the block continues if the branch is not taken. `find_blocks` decides what
// an instruction leaves to later instructions of its block, before any code is emitted; struct `EntryState` holds the
// result.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "fast/interpreter/decoder.hpp"

namespace atari {

// An instruction's operation and operand, by its handler. For a superinstruction or a loop, its first instruction
// counts.
struct Kind {
    Operation operation;
    Operand operand;
};
inline constexpr auto kKinds = [] {
    std::array<Kind, kHandlers> table{};
#define SINGLE(o, k) table[o##_##k] = {o, Operand::k};
#define PAIR(o1, k1, o2, k2) table[o1##_##k1##_##o2##_##k2] = {o1, Operand::k1};
#include "fast/interpreter/handlers.def"
    return table;
}();

// Returns the handler of a decoded instruction; for a loop, the handler of its first instruction.
inline uint16_t handler_of(const DecodedInstruction& instruction) {
    return instruction.handler == kLoop ? static_cast<uint16_t>(instruction.jump) : instruction.handler;
}
inline Kind kind_of(const DecodedInstruction& instruction) { return kKinds[handler_of(instruction)]; }

enum class CpuRegister : uint8_t { A, X, Y };

// The block-entry state: what holds when an instruction is reached from the instruction before it in its block. At a
// leader it is empty. Code that enters the block elsewhere has to establish it (`Translator::emit_entry`).
struct EntryState {
    // Cycles of earlier instructions of the block that have not been added to the cycle counter.
    int32_t cycles = 0;
    // If not empty, N and Z are those of this register, and kNz is out of date.
    std::optional<CpuRegister> nz;
    // The value of the carry, if this instruction or a later one of the block relies on it.
    std::optional<bool> carry;

    // Returns whether only the preceding instructions of the block can establish this state.
    bool needs_block() const { return nz || carry; }
    bool empty() const { return !cycles && !needs_block(); }
};

struct BlockInstruction {
    std::size_t place;  // offset of the first byte in the image
    Operation operation;
    Operand operand;
    uint16_t given;   // the operand's value, as in the decoded instruction
    bool loops;       // begins a loop whose rounds are skipped, except the last
    bool is_inlined;  // translated code runs it; otherwise it calls the handler

    EntryState entry;
    int32_t cycles_after = 0;  // not yet added after the instruction: `entry.cycles` of the next one
    bool omits_nz = false;     // N and Z are replaced before anything reads them
};

struct Block {
    std::vector<BlockInstruction> instructions;  // at least one
    std::size_t next = 0;                        // the place after the last instruction
    bool ends_in_jump = false;                   // JMP or RTS: `next` is not reached
    bool falls_through = false;                  // the next block of the list begins at `next`
};

inline bool is_jump(Operation operation) { return operation == JMP || operation == JSR || operation == RTS; }

std::size_t next_place(const std::vector<DecodedInstruction>& decoded, std::size_t place);
// Returns the target of a branch or a near jump.
std::size_t target_place(const std::vector<DecodedInstruction>& decoded, std::size_t place);

// Returns whether translated code stores to such an operand inline, in the likely case.
constexpr bool is_stored_inline(Operand operand) {
    switch (operand) {
        case Operand::Ram:
        case Operand::RamA:
        case Operand::RamX:
        case Operand::RamY:
        case Operand::AnyX:
        case Operand::AnyY:
        case Operand::IndY: return true;
        default: return operand >= Operand::Tia && operand != Operand::Cxclr;
    }
}

// Returns all blocks of an image, with the block-entry state of each instruction. Each decodable instruction that the
// search finds is in exactly one block. `decoded` has one more element than the image has bytes.
std::vector<Block> find_blocks(const uint8_t* image, const std::vector<DecodedInstruction>& decoded);

}  // namespace atari
