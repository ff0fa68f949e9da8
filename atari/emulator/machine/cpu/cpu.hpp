// The 6507: its registers, and its instructions on any bus.
//
// The processor adds an instruction's whole cost right after the opcode fetch. So every access of an instruction
// happens at the cycle count of its end.
#pragma once

#include <cstdint>

#include "machine/flag.hpp"

namespace atari {

inline constexpr int kInstructionLimit = 25000;  // instructions in a frame, at most

struct Cpu {
    uint16_t pc;
    uint8_t a, x, y, sp;
    Flag n, v, d, i, z, c;
    Flag stop;                  // the TIA has ended the frame
    Flag jammed;                // by an illegal opcode; only a reset ends it
    Flag last_access_was_read;  // WSYNC halts only then

    // Add to A and subtract from it, in the mode that D selects.
    void adc(uint8_t operand);
    void sbc(uint8_t operand);

    // Runs the next instruction. A bus has `uint8_t read(uint16_t)`, `void write(uint16_t, uint8_t)`, and
    // `void spend(int)`, which counts cycles. Defined in cpu_instructions.hpp.
    void run_instruction(auto& bus);
    // Runs instructions until the frame ends, at most `kInstructionLimit`.
    void run_frame(auto& bus);

  private:
    void set_nz(uint8_t value) {
        n = value & 0x80;
        z = value == 0;
    }
    void compare(uint8_t reg, uint8_t operand) {
        c = reg >= operand;
        set_nz(static_cast<uint8_t>(reg - operand));
    }
    void arr(uint8_t operand);
    uint8_t status() const;
    void set_status(uint8_t value);

    template <int operation>
    uint8_t modify(uint8_t old);
    template <int operation, int form>
    void execute(auto& bus, int penalty);
    template <int form>
    uint16_t effective_address(auto& bus, int penalty);
    uint8_t fetch(auto& bus) { return bus.read(pc++); }
    void push(auto& bus, uint8_t value) { bus.write(static_cast<uint16_t>(0x100 | sp--), value); }
    uint8_t pull(auto& bus) { return bus.read(static_cast<uint16_t>(0x100 | ++sp)); }
    void branch(auto& bus, bool taken);
};

}  // namespace atari
