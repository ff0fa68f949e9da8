// The 6507's opcodes as a table: operation, addressing form and cost of each, from opcodes.def.
#pragma once

#include <cstdint>

namespace atari {

enum Form : uint8_t { Imp, Acc, Imm, Zp, ZpX, ZpY, Abs, AbsX, AbsY, Ind, IndX, IndY, Rel };

// clang-format off
enum Operation : uint8_t {
    ADC, ANC, AND, ANE, ARR, ASL, ASR, BCC, BCS, BEQ, BIT, BMI, BNE, BPL, BRK, BVC, BVS, CLC, CLD, CLI, CLV, CMP, CPX,
    CPY, DCP, DEC, DEX, DEY, EOR, INC, INX, INY, ISB, JAM, JMP, JSR, LAS, LAX, LDA, LDX, LDY, LSR, LXA, NOP, ORA, PHA,
    PHP, PLA, PLP, RLA, ROL, ROR, RRA, RTI, RTS, SAX, SBC, SBX, SEC, SED, SEI, SHA, SHS, SHX, SHY, SLO, SRE, STA, STX,
    STY, TAX, TAY, TSX, TXA, TXS, TYA
};
// clang-format on

struct Opcode {
    Operation operation;
    Form form;
    uint8_t cost;     // cycles
    uint8_t penalty;  // 1 if crossing a page costs a cycle more
};

inline constexpr Opcode kOpcodes[256] = {
#define OPCODE(code, operation, form, cost, penalty) {operation, form, cost, penalty},
#include "opcodes.def"
#undef OPCODE
};

constexpr int length_of(Form form) {
    switch (form) {
        case Imp:
        case Acc: return 1;
        case Abs:
        case AbsX:
        case AbsY:
        case Ind: return 3;
        default: return 2;
    }
}

}  // namespace atari
