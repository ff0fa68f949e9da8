// The making of a translation: which instructions there are, and machine code for each.
//
// In machine code A, X, Y, the flags and the cycles are in registers, as are the end of the log and the cycle from which
// on a write ends the frame. Cycles are added where somebody may ask for them: at jumps, and wherever a jump may lead.
// Between such places an instruction knows when it is translated how many are missing (`pending_`).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "assembler.hpp"
#include "handlers.hpp"

namespace atari {

// The registers of the machine code. Of the rest, r8 to r11 are for any use.
inline constexpr Reg kA = rax, kX = rcx, kY = rdx, kNz = rsi, kCarry = rdi;
inline constexpr Reg kConsole = rbx, kRam = rbp, kRegisters = r12, kCycles = r13, kOverlong = r14, kLog = r15;

inline Mem in_console(int32_t place) { return {kConsole, place}; }
inline Mem in_registers(int32_t place) { return {kRegisters, place}; }
inline Mem in_ram(int32_t place) { return {kRam, place}; }

// What an instruction is, by its handler: of a pair or a loop, what the first is.
struct Kind {
    Operation operation;
    Operand operand;
};
inline constexpr auto kKinds = [] {
    std::array<Kind, kHandlers> table{};
#define SINGLE(o, k) table[o##_##k] = {o, Operand::k};
#define PAIR(o1, k1, o2, k2) table[o1##_##k1##_##o2##_##k2] = {o1, Operand::k1};
#include "handlers.def"
    return table;
}();
inline Kind kind_of(const Record& record) {
    return kKinds[record.handler == kLoop ? static_cast<uint16_t>(record.jump) : record.handler];
}

// Whether machine code stores there, in the likely case.
constexpr bool is_stored_here(Operand operand) {
    switch (operand) {
        case Operand::Ram: case Operand::RamA: case Operand::RamX: case Operand::RamY:
        case Operand::AnyX: case Operand::AnyY: case Operand::IndY:
            return true;
        default:
            return operand >= Operand::Tia && operand != Operand::Cxclr;
    }
}

// The register that an indexed operand is indexed by.
inline Reg index_of(Operand operand) {
    return operand == Operand::RamX || operand == Operand::RomX || operand == Operand::AnyX ? kX : kY;
}

class Translator {
  public:
    Translator(const uint8_t* image, const std::vector<Record>& records);

    // The machine code, with a table in front of it: for each record where its instruction begins, from the beginning of
    // the table, or 0. `enter` is where to enter it, with such a place as third argument.
    std::vector<uint8_t> translate(std::size_t& enter);

  private:
    // translator.cpp: which instructions there are, their order, and what they share
    void find_instructions();
    void reach(std::size_t first, std::vector<bool>& covered);
    static bool ends_run(Operation operation) { return operation == JMP || operation == RTS; }
    std::size_t next_of(std::size_t place) const;
    std::size_t target_of(std::size_t place) const;
    void emit_run(std::size_t place);
    void emit_asides();
    void emit_entries();
    void emit_entry(std::size_t place);
    void assume_from(std::size_t place);
    // Whether the instruction here will be translated next, and nothing is known to lead there but the one before it.
    bool follows(std::size_t place) const {
        return is_instruction_[place] && !is_target_[place] && begins_[place] < 0;
    }
    void emit_common();
    void emit_call(Label& label, FastCpu::Step function);
    void emit_routine(uint16_t handler);
    void emit_push_status(Label& slow);
    void emit_read_input(Operand operand, Label& slow);
    void emit_pull_input(Label& slow);
    void emit_input(int32_t cost);
    void emit_far(Label& label, uint16_t handler);
    void find_target(uint16_t handler, Label& slow);
    void find_begin(Label& slow);
    void push_return_address();
    void find_record();
    void load_operand();
    void save_registers();
    void load_registers();
    std::vector<uint8_t> finish(std::size_t& enter);

    void add_pending();
    void call_handler(std::size_t place);
    void go_to(std::size_t target, bool backward);
    int32_t table_size() const { return static_cast<int32_t>((sizeof(int32_t) * (size_ + 1) + 15) / 16 * 16); }

    // translator_instructions.cpp: one instruction. False if its handler has to be called.
    struct Source {  // of a byte
        std::optional<uint8_t> constant;
        std::optional<Mem> memory;
        Reg reg;  // otherwise
    };
    void emit();
    void skip_rounds();
    bool emit_branch();
    bool emit_jump();
    bool emit_read();
    Source paged();
    bool read_fetcher();
    void indexed_ram();
    void add_page_crossing(Reg index);
    void read_into(Reg to, const Source& source);
    void combine(Alu what, Reg to, const Source& source);
    void operate(const Source& source);
    void set_nz(Reg of);
    bool replaces_nz_next() const;
    bool emit_modify();
    bool emit_implied();

    // translator_stores.cpp
    bool emit_store();
    void store_in_ram(Reg value);
    void emit_tia_store(Reg value);
    void look_ahead_for_writes();
    void emit_check_of_time(int32_t later, Label& late);
    void write_graphics(Reg value);
    void write_hmove();
    void keep(Reg value);
    void wait_for_line();
    void whole_lines(Reg cycles);
    void cycle_in_line(Reg to, int32_t later = 0);

    // What an instruction does aside of the likely way: its handler is called, and then it goes on behind itself, or, where
    // that is a jump, wherever it says.
    struct Aside {
        Label from;
        enum { kHandler, kEnterBehind, kJumpByHandler, kBranch, kLimit } what;
        std::size_t place;
        int32_t before, after;  // cycles missing before it and behind it
        std::optional<Reg> nz;  // what N and Z have to be made of
        Label back;
    };

    const uint8_t* const image_;
    const std::vector<Record>& records_;
    const std::size_t size_;
    std::vector<bool> is_instruction_, is_target_;
    std::vector<Label> handlers_;       // calls of them
    std::vector<Label> entries_;        // where each is entered with no cycles missing
    std::vector<int32_t> begins_;       // where it is when they are, so many:
    std::vector<uint16_t> missing_;
    std::vector<bool> assumes_;         // it builds on what those before it have done, or left out
    std::vector<uint16_t> until_write_;  // one before it has asked whether writes so far ahead are in time; or 0
    std::vector<Aside> asides_;
    Assembler a_;
    Label start_, skip_, dispatch_, return_, call_far_, jump_far_, jump_indirect_, leave_, left_, limit_, exit_;

    // The instruction that is being translated.
    std::size_t place_ = 0;
    Operation operation_ = NOP;
    Operand operand_ = Operand::Imp;
    uint16_t given_ = 0;
    int32_t pending_ = 0;
    Label slow_;
    std::optional<Reg> nz_in_;                  // N and Z are of this register, and have been left out
    struct KnownCarry {
        bool is_set;
        std::size_t since;  // the instruction that has set or cleared it
    };
    std::optional<KnownCarry> carry_;
    int32_t written_at_ = 0;                    // its write to the TIA comes so much later than kCycles
    std::size_t checked_at_ = 0, in_time_until_ = 0;  // that one has asked for all writes up to this one
};

}  // namespace atari
