#include "translator.hpp"

#include <algorithm>
#include <cstring>

#include "offsets.hpp"
#include "translated_code.hpp"

namespace atari {

Translator::Translator(const uint8_t* image, const std::vector<DecodedInstruction>& decoded, bool far)
    : decoded_(decoded), size_(decoded.size() - 1), blocks_(find_blocks(image, decoded)), instructions_(size_ + 1),
      code_at_(size_ + 1), entries_(size_ + 1), handlers_(kHandlers), a_(far) {
    for (const Block& block : blocks_)
        for (const BlockInstruction& instruction : block.instructions) instructions_[instruction.place] = &instruction;
}

std::vector<uint8_t> Translator::translate(std::size_t& start) {
    emit_common();
    for (const Block& block : blocks_) emit_block(block);
    for (const BlockInstruction* instruction : instructions_)
        if (instruction) emit_entry(*instruction);
    emit_slow_paths();
    for (uint16_t handler = 0; handler < kHandlers; ++handler)
        if (handlers_[handler].has_jumps()) emit_routine(handler);
    return finish(start);
}

void Translator::emit_block(const Block& block) {
    for (const BlockInstruction& instruction : block.instructions) {
        code_at_[instruction.place] = a_.here();
        emit(instruction);
    }
    const int32_t cycles = block.instructions.back().cycles_after;
    if (block.ends_in_jump) return;
    if (block.falls_through) add_cycles(cycles);
    else go_to(block.next, cycles, false);
}

// Emits a jump to any instruction, translated or not, with `cycles` not yet added.
void Translator::go_to(std::size_t target, int32_t cycles, bool backward) {
    add_cycles(cycles);
    if (!instructions_[target]) {
        a_.move(t0, static_cast<uint32_t>(target));
        a_.jump(leave_);
        return;
    }
    if (backward) {
        a_.compare(kCycles, in_console(Offsets::cycle_limit()));
        a_.jump(If::below, entries_[target]);
        a_.move(t0, static_cast<uint32_t>(target));
        a_.jump(limit_);
        return;
    }
    a_.jump(entries_[target]);
}

void Translator::add_cycles(int32_t cycles) {
    if (cycles) a_.alu(Alu::add, kCycles, cycles);
}

// Emits a call of the instruction's handler, which adds all cycles. Translated code ends if the handler returns anything
// but kNext.
void Translator::call_handler(std::size_t place) {
    a_.move(t0, static_cast<uint32_t>(place));
    call_routine(handler_of(decoded_[place]));
}

void Translator::call_routine(uint16_t handler) { call_routine_or_exit(a_, handlers_[handler], exit_); }

// Emits the entry for code that does not come from the preceding instruction. The entry establishes the block-entry
// state. If only the block can do that, the entry calls the handler and continues at the next instruction.
void Translator::emit_entry(const BlockInstruction& instruction) {
    const EntryState& state = instruction.entry;
    JumpLabel& entry = entries_[instruction.place];
    JumpLabel code{code_at_[instruction.place]};
    if (state.empty()) return a_.bind(entry, code.at);
    a_.bind(entry);
    if (!state.needs_block()) {
        a_.alu(Alu::sub, kCycles, state.cycles);
        return a_.jump(code);
    }
    call_handler(instruction.place);
    go_to(next_place(decoded_, instruction.place), 0, false);
}

void Translator::emit_slow_paths() {
    for (SlowPath& path : slow_paths_) {
        a_.bind(path.from);
        add_cycles(path.cycles);
        switch (path.what) {
            case SlowPath::kHandler:
                if (path.nz) a_.move(kNz, reg_of(*path.nz));
                call_handler(path.place);
                if (path.cycles_after) a_.alu(Alu::sub, kCycles, path.cycles_after);
                a_.jump(path.back);
                break;
            case SlowPath::kJumpByHandler:
                call_handler(path.place);
                a_.jump(dispatch_);
                break;
            case SlowPath::kBranchTaken: go_to(path.place, 0, false); break;
        }
    }
}

void Translator::save_registers() {
    a_.store_two(in_registers(Offsets::cycles()), kCycles, kA);
    a_.store_two(in_registers(Offsets::x()), kX, kY);
    a_.store_two(in_registers(Offsets::nz()), kNz, kCarry);
    a_.store64(in_console(Offsets::log_end()), kLog);
}

void Translator::load_registers() {
    a_.load_two(kCycles, kA, in_registers(Offsets::cycles()));
    a_.load_two(kX, kY, in_registers(Offsets::x()));
    a_.load_two(kNz, kCarry, in_registers(Offsets::nz()));
    a_.load64(kLog, in_console(Offsets::log_end()));
}

// Emits a routine that calls a function of the registers and the console, for the decoded instruction whose index is in
// t0. If that function returns anything but kNext, translated code ends with that result.
void Translator::emit_call(JumpLabel& label, Interpreter::Step function) {
    a_.bind(label);
    find_instruction();
    save_registers();
    call_function(a_, reinterpret_cast<uintptr_t>(function), exit_);
    load_registers();
    return_to_caller(a_);
}

// Turns the index in t0 into the address of the decoded instruction.
void Translator::find_instruction() {
    a_.shift64(ShiftDirection::left, t0, kInstructionShift);
    a_.alu64(Alu::add, t0, in_console(Offsets::first_instruction()));
    a_.store64(in_registers(Offsets::at()), t0);
}

void Translator::emit_common() {
    a_.bind(start_);
    enter(a_);
    a_.address64(kRam, in_console(Offsets::ram()));
    load_registers();
    a_.jump(t0);

    emit_call(skip_, &Interpreter::skip_loop);
    emit_far(return_, RTS_Imp);
    emit_far(jump_far_, JMP_Far);
    emit_far(call_far_, JSR_Far);
    emit_far(jump_indirect_, JMP_Ind);

    a_.bind(dispatch_);  // continues at the decoded instruction to which a handler has jumped
    a_.load64(t0, in_registers(Offsets::at()));
    a_.alu64(Alu::sub, t0, in_console(Offsets::first_instruction()));
    a_.compare64(t0, static_cast<int32_t>(sizeof(DecodedInstruction) * size_));
    a_.jump(If::not_below, left_);
    a_.shift64(ShiftDirection::right, t0, kInstructionShift - kTableShift);
    a_.address_before(t1, table_size());
    a_.load(t0, Mem{t1, 0, t0});
    a_.test(t0);
    a_.jump(If::zero, left_);
    a_.address64(t0, Mem{t1, 0, t0});
    a_.jump(t0);

    a_.bind(limit_);  // t0 is the index of the decoded instruction at which translated code ends
    find_instruction();
    save_registers();
    a_.move(kResult, uint32_t{kLimit});
    a_.jump(exit_);
    a_.bind(leave_);
    find_instruction();
    a_.bind(left_);
    save_registers();
    a_.move(kResult, uint32_t{kNext});
    a_.bind(exit_);
    leave(a_);
}

// Emits the routine that calls a handler. For some frequent handlers it first tries the likely cases inline.
void Translator::emit_routine(uint16_t handler) {
    JumpLabel slow;
    a_.bind(handlers_[handler]);
    const auto [operation, operand] = kKinds[handler];
    if (operation == PHP) emit_push_status(slow);
    if (operation == PLA) emit_pull_input(slow);
    if (operation == LDA) emit_read_input(operand, slow);
    emit_call(slow, Interpreter::step_of(handler));
}

// PHP, into RAM or a TIA register.
void Translator::emit_push_status(JumpLabel& slow) {
    constexpr uint64_t kValues = registers_where([](const TiaRegister& reg) { return reg.store == TiaStore::kValue; });
    const auto pushed = [&] {
        a_.alu8(Alu::sub, in_console(Offsets::sp()), uint8_t{1});
        a_.alu(Alu::add, kCycles, 3);
        return_to_caller(a_);
    };
    a_.move(t2, kNz);
    a_.shift(ShiftDirection::right, t2, 1);
    a_.alu(Alu::or_, t2, kNz);
    a_.alu(Alu::and_, t2, 0x80);
    a_.set_if_not_zero(t3, in_console(Offsets::overflow()));
    a_.shift(ShiftDirection::left, t3, 6);
    a_.alu(Alu::or_, t2, t3);
    a_.alu8(Alu::or_, t2, in_console(Offsets::modes()));
    a_.shift(ShiftDirection::right, t2, 2);
    a_.shift_in_if_zero8(t2, kNz);
    a_.address(t2, Mem{kCarry, 0, t2, 2});

    a_.load8(t1, in_console(Offsets::sp()));
    a_.test8(t1);
    const ShortJump in_ram = a_.jump_short(If::sign);
    a_.compare8(in_console(Offsets::watches_tia()), uint8_t{0});
    a_.jump(If::not_zero, slow);
    a_.move64(t3, kValues);
    a_.test_bit64(t3, t1);
    a_.jump(If::bit_clear, slow);
    check_deadline(3, slow);
    a_.alu(Alu::and_, t1, kRegisterMask);
    a_.compare8(Mem{kConsole, Offsets::shadow(), t1}, t2);
    const ShortJump same = a_.jump_short(If::zero);
    a_.store8(Mem{kConsole, Offsets::shadow(), t1}, t2);
    a_.address(t3, Mem{kCycles, 3});
    a_.store(in_log(Offsets::write_cycle()), t3);
    a_.store(in_log(Offsets::write_reg()), t1);
    a_.store8(in_log(Offsets::write_value()), t2);
    a_.address64(kLog, in_log(kWriteSize));
    a_.bind_short(same);
    pushed();
    a_.bind_short(in_ram);
    a_.store8(Mem{kRam, -0x80, t1}, t2);
    pushed();
}

// Loads the operand of the instruction whose index is in t0 into t1.
void Translator::load_operand() {
    a_.move64(t1, t0);
    a_.shift64(ShiftDirection::left, t1, kInstructionShift);
    a_.alu64(Alu::add, t1, in_console(Offsets::first_instruction()));
    a_.load16(t1, Mem{t1, Offsets::instruction_operand()});
}

// Loads the TIA input at the address in t1 into A: bit 7 is the input, the other bits come from the bus, in t2.
void Translator::emit_input(int32_t cost) {
    a_.alu(Alu::add, kCycles, cost);
    a_.alu(Alu::and_, t1, 7);
    a_.set_bit_7_if_reached(kA, kCycles, Mem{kConsole, Offsets::inputs(), t1, 8});
    a_.alu(Alu::and_, t2, 0x3f);
    a_.alu(Alu::or_, kA, t2);
    a_.move(kNz, kA);
    return_to_caller(a_);
}

// LDA with an index that leads to an input.
void Translator::emit_read_input(Operand operand, JumpLabel& slow) {
    if (operand != Operand::RamX && operand != Operand::AnyX && operand != Operand::AnyY) return;
    load_operand();
    a_.move(t2, t1);
    a_.alu(Alu::add, t1, operand == Operand::AnyY ? kY : kX);
    a_.move(t3, t1);
    a_.alu(Alu::and_, t3, operand == Operand::RamX ? 0x88 : 0x1088);
    a_.compare(t3, 8);
    a_.jump(If::not_zero, slow);
    a_.compare8(in_console(Offsets::watches_tia()), uint8_t{0});
    a_.jump(If::not_zero, slow);
    if (operand != Operand::RamX) {
        a_.move(t3, t2);
        a_.alu(Alu::xor_, t3, t1);
        a_.test(t3, uint32_t{0xff00});
        a_.jump(If::not_zero, slow);  // page crossing
        a_.shift(ShiftDirection::right, t2, 8);
    }
    emit_input(4);
}

// PLA from an input, if the byte that is read first is an input too.
void Translator::emit_pull_input(JumpLabel& slow) {
    const auto require_input = [&] {
        a_.move(t2, t1);
        a_.alu(Alu::and_, t2, 0x88);
        a_.compare(t2, 8);
        a_.jump(If::not_zero, slow);
    };
    a_.load8(t1, in_console(Offsets::sp()));
    require_input();
    a_.alu(Alu::add, t1, 1);
    require_input();
    a_.compare8(in_console(Offsets::watches_tia()), uint8_t{0});
    a_.jump(If::not_zero, slow);
    a_.store8(in_console(Offsets::sp()), t1);
    a_.move(t2, uint32_t{0x68});
    emit_input(4);
}

// Loads the target of an RTS, JMP or JSR into t1. t0 is the index of the instruction.
void Translator::find_target(uint16_t handler, JumpLabel& slow) {
    if (handler == RTS_Imp) {
        a_.load8(t0, in_console(Offsets::sp()));
        a_.address(t1, Mem{t0, -0x80});
        a_.compare(t1, 0x7e);
        a_.jump(If::not_below, slow);
        a_.load16(t1, Mem{kRam, 1 - 0x80, t0});
        a_.extract(t2, t1, 6, 8);  // the byte there is read too
        a_.test64(Mem{kConsole, Offsets::pages(), t2, 8});
        a_.jump(If::zero, slow);
        a_.alu(Alu::add, t1, 1);
        a_.alu(Alu::and_, t1, 0xffff);
    } else {
        load_operand();
    }
    if (handler == JSR_Far) {
        a_.compare8(in_console(Offsets::sp()), uint8_t{0x81});
        a_.jump(If::below, slow);
    }
    if (handler == JMP_Ind) {
        a_.move(t2, t1);
        a_.alu(Alu::and_, t2, 0x1280);
        a_.compare(t2, 0x80);
        a_.jump(If::not_zero, slow);
        a_.alu(Alu::and_, t1, 0x7f);
        a_.compare(t1, 0x7f);
        a_.jump(If::zero, slow);
        a_.load16(t1, Mem{kRam, 0, t1});
    }
}

// Emits RTS, JMP or JSR to an address that is computed at run time. t0 is the index of the instruction.
void Translator::emit_far(JumpLabel& label, uint16_t handler) {
    JumpLabel slow;
    a_.bind(label);
    a_.store(in_registers(Offsets::at()), t0);  // for the slow path and for `push_return_address`
    find_target(handler, slow);
    find_entry(slow);
    if (handler == RTS_Imp) a_.alu8(Alu::add, in_console(Offsets::sp()), uint8_t{2});
    if (handler == JSR_Far) push_return_address();
    a_.alu(Alu::and_, t1, 0xfc00);
    a_.store(in_console(Offsets::origin()), t1);
    a_.shift64(ShiftDirection::left, t2, kInstructionShift);
    a_.alu64(Alu::add, t2, in_console(Offsets::first_instruction()));
    a_.store64(in_console(Offsets::base_instruction()), t2);
    a_.alu(Alu::add, kCycles, handler == JMP_Far ? 3 : handler == JMP_Ind ? 5 : 6);
    a_.move(t0, uint32_t{0});
    a_.compare(kCycles, in_console(Offsets::cycle_limit()));
    a_.jump(If::not_below, limit_);
    a_.jump(t3);
    a_.bind(slow);
    a_.load(t0, in_registers(Offsets::at()));
    call_routine(handler);
    a_.jump(dispatch_);
}

// Loads the entry for the address in t1 into t3, and the image offset of its 1 KiB segment into t2. Jumps to `slow`
// if there is no entry. Uses t0.
void Translator::find_entry(JumpLabel& slow) {
    a_.extract(t2, t1, 10, 4);
    a_.load(t3, in_console(Offsets::code_segments()));
    a_.test_bit(t3, t2);
    a_.jump(If::bit_clear, slow);
    a_.load(t2, Mem{kConsole, Offsets::segments(), t2, 4});
    a_.move(t3, t1);
    a_.alu(Alu::and_, t3, 0x3ff);
    a_.alu(Alu::add, t3, t2);
    a_.address_before(t0, table_size());
    a_.load(t3, Mem{t0, 0, t3, sizeof(TableEntry)});
    a_.test(t3);
    a_.jump(If::zero, slow);
    a_.address64(t3, Mem{t0, 0, t3});
}

// Pushes the return address of the JSR whose index is in `at`.
void Translator::push_return_address() {
    a_.load64(t0, in_console(Offsets::first_instruction()));
    a_.alu64(Alu::sub, t0, in_console(Offsets::base_instruction()));
    a_.shift(ShiftDirection::right, t0, kInstructionShift);
    a_.alu(Alu::add, t0, in_registers(Offsets::at()));
    a_.alu(Alu::add, t0, in_console(Offsets::origin()));
    a_.alu(Alu::add, t0, 2);
    a_.save(t1);
    a_.load8(t1, in_console(Offsets::sp()));
    a_.store16(Mem{kRam, -0x81, t1}, t0);
    a_.restore(t1);
    a_.alu8(Alu::sub, in_console(Offsets::sp()), uint8_t{2});
}

std::vector<uint8_t> Translator::finish(std::size_t& start) {
    const auto table = static_cast<std::size_t>(table_size());
    std::vector<uint8_t> code(table + a_.size());
    start = table + static_cast<std::size_t>(start_.at);
    for (std::size_t place = 0; place < size_; ++place) {
        const TableEntry entry = instructions_[place] ? entries_[place].at + table_size() : 0;
        std::memcpy(code.data() + sizeof entry * place, &entry, sizeof entry);
    }
    std::copy(a_.bytes().begin(), a_.bytes().end(), code.begin() + table_size());
    return code;
}

void TranslatedCode::make(const uint8_t* image, const std::vector<DecodedInstruction>& decoded) {
    if constexpr (!kTranslates) return;
    try {
        code_.fill(Translator(image, decoded, false).translate(start_));
    } catch (const JumpTooFar&) {  // a large image on a processor whose shorter jumps do not reach all code
        code_.fill(Translator(image, decoded, true).translate(start_));
    }
}

}  // namespace atari
