// The JIT translator: makes translated code of a cartridge's basic blocks (basic_blocks.hpp) when the cartridge is
// loaded.
//
// Translated code keeps A, X, Y, the flags and the cycle count in registers of the host, as well as the end of the
// write log. Cycles are added where something may read the count: at jumps and at the end of blocks. Between those,
// each instruction's block-entry state (`EntryState`) holds the number of cycles not yet added. Unlikely cases are in
// slow paths, out of line after all blocks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "basic_blocks.hpp"
#include "fast/interpreter/handlers.hpp"
#include "target.hpp"

namespace atari {

inline Mem in_console(int32_t offset) { return {kConsole, offset}; }
inline Mem in_registers(int32_t offset) { return {kRegisters, offset}; }
inline Mem in_ram(int32_t offset) { return {kRam, offset}; }
inline Mem in_log(int32_t offset) { return {kLog, offset}; }  // from the next entry on

constexpr Reg reg_of(CpuRegister reg) { return reg == CpuRegister::A ? kA : reg == CpuRegister::X ? kX : kY; }

// Returns the index register of an indexed operand.
inline Reg index_of(Operand operand) {
    return operand == Operand::RamX || operand == Operand::RomX || operand == Operand::AnyX ? kX : kY;
}

class Translator {
  public:
    // If `far`, jumps reach any distance. Otherwise `translate` may throw `JumpTooFar`.
    Translator(const uint8_t* image, const std::vector<DecodedInstruction>& decoded, bool far);

    // Returns the translated code. It begins with a table: by decoded instruction, the offset of its entry from the
    // start of the table, or 0. `start` is the offset of the function to call; its third argument is an entry.
    std::vector<uint8_t> translate(std::size_t& start);

  private:
    // translator.cpp: blocks, their entries and slow paths, and shared routines
    void emit_block(const Block& block);
    void emit_entry(const BlockInstruction& instruction);
    void emit_slow_paths();
    void emit_common();
    void emit_call(JumpLabel& label, Interpreter::Step function);
    void emit_routine(uint16_t handler);
    void emit_push_status(JumpLabel& slow);
    void emit_read_input(Operand operand, JumpLabel& slow);
    void emit_pull_input(JumpLabel& slow);
    void emit_input(int32_t cost);
    void emit_far(JumpLabel& label, uint16_t handler);
    void find_target(uint16_t handler, JumpLabel& slow);
    void find_entry(JumpLabel& slow);
    void push_return_address();
    void find_instruction();
    void load_operand();
    void save_registers();
    void load_registers();
    std::vector<uint8_t> finish(std::size_t& start);

    void add_cycles(int32_t cycles);
    void call_handler(std::size_t place);
    void call_routine(uint16_t handler);
    void go_to(std::size_t target, int32_t cycles, bool backward);
    int32_t table_size() const { return static_cast<int32_t>((sizeof(int32_t) * (size_ + 1) + 15) / 16 * 16); }

    // translator_instructions.cpp: one instruction
    void emit(const BlockInstruction& instruction);
    void emit_inline();
    void skip_rounds();
    void emit_branch();
    void emit_jump();
    void emit_read();
    Byte paged();
    Byte dpc();
    void indexed_ram();
    void add_page_crossing(Reg index);
    void operate(const Byte& source);
    void set_nz(Reg of);
    void emit_modify();
    void emit_implied();

    // translator_stores.cpp
    void emit_store();
    void store_in_ram(Reg value);
    void emit_tia_store(Reg value);
    void check_deadline(int32_t later, JumpLabel& past_deadline);
    void write_graphics(Reg value);
    void write_hmove();
    void append_write(Reg value);
    void wait_for_line();
    void whole_lines(Reg cycles);
    void cycle_in_line(Reg to, int32_t later = 0);

    // An out-of-line stub for an unlikely case.
    struct SlowPath {
        JumpLabel from;
        enum {
            kHandler,        // the handler runs the instruction, and the block continues at `back`
            kJumpByHandler,  // the handler jumps
            kBranchTaken,    // the branch to `place` is taken
        } what;
        std::size_t place;
        int32_t cycles, cycles_after;   // not yet added at `from`, and at `back`
        std::optional<CpuRegister> nz;  // the register from which N and Z must be computed
        JumpLabel back;
    };

    const std::vector<DecodedInstruction>& decoded_;
    const std::size_t size_;
    const std::vector<Block> blocks_;
    std::vector<const BlockInstruction*> instructions_;  // by place; null where no block has one
    std::vector<int32_t> code_at_;                       // by place: the code, which expects the block-entry state
    std::vector<JumpLabel> entries_;                     // by place: the entry, which establishes that state
    std::vector<JumpLabel> handlers_;                    // by handler: the routine that calls it
    std::vector<SlowPath> slow_paths_;
    Assembler a_;
    JumpLabel start_, skip_, dispatch_, return_, call_far_, jump_far_, jump_indirect_, leave_, left_, limit_, exit_;

    // The instruction that is being translated.
    const BlockInstruction* at_ = nullptr;
    int32_t cycles_ = 0;    // cycles not yet added to kCycles at the start of the instruction
    int32_t write_at_ = 0;  // cycles from kCycles to its TIA write
    JumpLabel slow_;        // the start of its slow path
};

}  // namespace atari
