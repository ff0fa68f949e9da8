#include "translator.hpp"

#include <algorithm>
#include <cstring>

#include "offsets.hpp"
#include "translated_code.hpp"

namespace atari {

Translator::Translator(const uint8_t* image, const std::vector<DecodedInstruction>& decoded)
    : decoded_(decoded), size_(decoded.size() - 1), blocks_(find_blocks(image, decoded)), instructions_(size_ + 1),
      code_at_(size_ + 1), entries_(size_ + 1), handlers_(kHandlers) {
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
        if (handlers_[handler].last_jump >= 0) emit_routine(handler);
    return finish(start);
}

void Translator::emit_block(const Block& block) {
    for (const BlockInstruction& instruction : block.instructions) {
        code_at_[instruction.place] = static_cast<int32_t>(a_.size());
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
        a_.move(r8, static_cast<uint32_t>(target));
        a_.jump(leave_);
        return;
    }
    if (backward) {
        a_.alu(Alu::cmp, kCycles, in_console(Offsets::cycle_limit()));
        slow_paths_.push_back({{}, SlowPath::kLimit, target, 0, 0, {}, {}});
        a_.jump(If::not_below, slow_paths_.back().from);
    }
    a_.jump(entries_[target]);
}

void Translator::add_cycles(int32_t cycles) {
    if (cycles) a_.alu(Alu::add, kCycles, cycles);
}

// Emits a call of the instruction's handler, which adds all cycles. Translated code ends if the handler's routine
// returns with the carry set.
void Translator::call_handler(std::size_t place) {
    a_.move(r8, static_cast<uint32_t>(place));
    call_routine(handler_of(decoded_[place]));
}

void Translator::call_routine(uint16_t handler) {
    a_.call(handlers_[handler]);
    a_.jump(If::below, exit_);
}

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
            case SlowPath::kLimit:
                a_.move(r8, static_cast<uint32_t>(path.place));
                a_.jump(limit_);
                break;
        }
    }
}

void Translator::save_registers() {
    a_.store(in_registers(Offsets::cycles()), kCycles);
    a_.store(in_registers(Offsets::a()), kA);
    a_.store(in_registers(Offsets::x()), kX);
    a_.store(in_registers(Offsets::y()), kY);
    a_.store(in_registers(Offsets::nz()), kNz);
    a_.store(in_registers(Offsets::carry()), kCarry);
    a_.store64(in_console(Offsets::log_end()), kLog);
}

void Translator::load_registers() {
    a_.load(kCycles, in_registers(Offsets::cycles()));
    a_.load(kA, in_registers(Offsets::a()));
    a_.load(kX, in_registers(Offsets::x()));
    a_.load(kY, in_registers(Offsets::y()));
    a_.load(kNz, in_registers(Offsets::nz()));
    a_.load(kCarry, in_registers(Offsets::carry()));
    a_.load64(kLog, in_console(Offsets::log_end()));
}

// Emits a routine that calls a function of the registers and the console, for the decoded instruction whose index is in
// r8. If that function returns anything but kNext, the routine returns with the carry set and the result in rax. Calls
// and returns are balanced: a hardware shadow stack requires that.
void Translator::emit_call(JumpLabel& label, Interpreter::Step function) {
    a_.bind(label);
    find_instruction();
    save_registers();
    a_.move64(rdi, kRegisters);
    a_.move64(rsi, kConsole);
    a_.move64(r9, reinterpret_cast<uintptr_t>(function));
    a_.call(r9);
    a_.test(rax, rax);  // clears the carry
    const ShortJump stays = a_.jump_short(If::zero);
    a_.set_carry();
    a_.ret();
    a_.bind_short(stays);
    load_registers();  // leaves the carry clear
    a_.ret();
}

// Turns the index in r8 into the address of the decoded instruction.
void Translator::find_instruction() {
    a_.shift64(ShiftDirection::left, r8, kInstructionShift);
    a_.alu64(Alu::add, r8, in_console(Offsets::first_instruction()));
    a_.store64(in_registers(Offsets::at()), r8);
}

void Translator::emit_common() {
    // An odd number, and 8 bytes, align the stack for the calls in routines.
    static constexpr Reg kSaved[] = {rbx, rbp, r12, r13, r14};
    a_.bind(start_);  // arguments: registers, console, entry
    for (const Reg reg : kSaved) a_.push(reg);
    a_.add_to_stack(-8);
    a_.move64(kRegisters, rdi);
    a_.move64(kConsole, rsi);
    a_.move64(r8, rdx);
    a_.address64(kRam, in_console(Offsets::ram()));
    load_registers();
    a_.jump(r8);

    emit_call(skip_, &Interpreter::skip_loop);
    emit_far(return_, RTS_Imp);
    emit_far(jump_far_, JMP_Far);
    emit_far(call_far_, JSR_Far);
    emit_far(jump_indirect_, JMP_Ind);

    a_.bind(dispatch_);  // continues at the decoded instruction to which a handler has jumped
    a_.load64(r8, in_registers(Offsets::at()));
    a_.alu64(Alu::sub, r8, in_console(Offsets::first_instruction()));
    a_.alu64(Alu::cmp, r8, static_cast<int32_t>(sizeof(DecodedInstruction) * size_));
    a_.jump(If::not_below, left_);
    a_.shift64(ShiftDirection::right, r8, kInstructionShift - kTableShift);
    a_.address_of(r9, start_);
    a_.load(r8, Mem{r9, -table_size(), r8});
    a_.test(r8, r8);
    a_.jump(If::zero, left_);
    a_.address64(r8, Mem{r9, -table_size(), r8});
    a_.jump(r8);

    a_.bind(limit_);  // r8 is the index of the decoded instruction at which translated code ends
    find_instruction();
    save_registers();
    a_.move(rax, uint32_t{kLimit});
    a_.jump(exit_);
    a_.bind(leave_);
    find_instruction();
    a_.bind(left_);
    save_registers();
    a_.move(rax, uint32_t{kNext});
    a_.bind(exit_);
    a_.add_to_stack(8);
    for (int i = 4; i >= 0; --i) a_.pop(kSaved[i]);
    a_.ret();
}

// Emits the routine that calls a handler. For some frequent handlers it first tries the likely cases inline, which
// return with the carry clear.
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
    a_.move(r10, kNz);
    a_.shift(ShiftDirection::right, r10, 1);
    a_.alu(Alu::or_, r10, kNz);
    a_.alu(Alu::and_, r10, 0x80);
    a_.alu8(Alu::cmp, in_console(Offsets::overflow()), uint8_t{1});  // sets the carry if V is clear
    a_.alu(Alu::sbb, r11, r11);
    a_.alu(Alu::add, r11, 1);
    a_.shift(ShiftDirection::left, r11, 6);
    a_.alu(Alu::or_, r10, r11);
    a_.alu8(Alu::or_, r10, in_console(Offsets::modes()));
    a_.shift(ShiftDirection::right, r10, 2);
    a_.alu8(Alu::cmp, kNz, uint8_t{1});  // sets the carry if Z is set
    a_.alu(Alu::adc, r10, r10);
    a_.address(r10, Mem{kCarry, 0, r10, 2});

    a_.load8(r9, in_console(Offsets::sp()));
    a_.test8(r9, r9);
    const ShortJump in_ram = a_.jump_short(If::sign);
    a_.alu8(Alu::cmp, in_console(Offsets::watches_tia()), uint8_t{0});
    a_.jump(If::not_zero, slow);
    a_.move64(r11, kValues);
    a_.test_bit64(r11, r9);
    a_.jump(If::not_below, slow);
    check_deadline(3, slow);
    a_.alu(Alu::and_, r9, kRegisterMask);
    a_.alu8(Alu::cmp, Mem{kConsole, Offsets::shadow(), r9}, r10);
    const ShortJump same = a_.jump_short(If::zero);
    a_.store8(Mem{kConsole, Offsets::shadow(), r9}, r10);
    a_.address(r11, Mem{kCycles, 3});
    a_.store(in_log(Offsets::write_cycle()), r11);
    a_.store(in_log(Offsets::write_reg()), r9);
    a_.store8(in_log(Offsets::write_value()), r10);
    a_.address64(kLog, in_log(kWriteSize));
    a_.bind_short(same);
    a_.alu8(Alu::sub, in_console(Offsets::sp()), uint8_t{1});
    a_.alu(Alu::add, kCycles, 3);
    a_.ret();
    a_.bind_short(in_ram);
    a_.store8(Mem{kRam, -0x80, r9}, r10);
    a_.alu8(Alu::sub, in_console(Offsets::sp()), uint8_t{1});
    a_.alu(Alu::add, kCycles, 3);
    a_.ret();
}

// Loads the operand of the instruction whose index is in r8 into r9.
void Translator::load_operand() {
    a_.move64(r9, r8);
    a_.shift64(ShiftDirection::left, r9, kInstructionShift);
    a_.alu64(Alu::add, r9, in_console(Offsets::first_instruction()));
    a_.load16(r9, Mem{r9, Offsets::instruction_operand()});
}

// Loads the TIA input at the address in r9 into A: bit 7 is the input, the other bits are those of the bus, from r10.
void Translator::emit_input(int32_t cost) {
    a_.alu(Alu::add, kCycles, cost);
    a_.alu(Alu::and_, r9, 7);
    a_.alu64(Alu::cmp, kCycles, Mem{kConsole, Offsets::inputs(), r9, 8});
    a_.alu(Alu::sbb, kA, kA);
    a_.alu(Alu::and_, kA, -0x80);
    a_.alu(Alu::add, kA, 0x80);
    a_.alu(Alu::and_, r10, 0x3f);
    a_.alu(Alu::or_, kA, r10);
    a_.move(kNz, kA);
    a_.ret();
}

// LDA with an index that leads to an input.
void Translator::emit_read_input(Operand operand, JumpLabel& slow) {
    if (operand != Operand::RamX && operand != Operand::AnyX && operand != Operand::AnyY) return;
    load_operand();
    a_.move(r10, r9);
    a_.alu(Alu::add, r9, operand == Operand::AnyY ? kY : kX);
    a_.move(r11, r9);
    a_.alu(Alu::and_, r11, operand == Operand::RamX ? 0x88 : 0x1088);
    a_.alu(Alu::cmp, r11, 8);
    a_.jump(If::not_zero, slow);
    a_.alu8(Alu::cmp, in_console(Offsets::watches_tia()), uint8_t{0});
    a_.jump(If::not_zero, slow);
    if (operand != Operand::RamX) {
        a_.move(r11, r10);
        a_.alu(Alu::xor_, r11, r9);
        a_.test(r11, uint32_t{0xff00});
        a_.jump(If::not_zero, slow);  // page crossing
        a_.shift(ShiftDirection::right, r10, 8);
    }
    emit_input(4);
}

// PLA from an input, if the byte that is read first is an input too.
void Translator::emit_pull_input(JumpLabel& slow) {
    a_.load8(r9, in_console(Offsets::sp()));
    a_.move(r10, r9);
    a_.alu(Alu::and_, r10, 0x88);
    a_.alu(Alu::cmp, r10, 8);
    a_.jump(If::not_zero, slow);
    a_.alu(Alu::add, r9, 1);
    a_.move(r10, r9);
    a_.alu(Alu::and_, r10, 0x88);
    a_.alu(Alu::cmp, r10, 8);
    a_.jump(If::not_zero, slow);
    a_.alu8(Alu::cmp, in_console(Offsets::watches_tia()), uint8_t{0});
    a_.jump(If::not_zero, slow);
    a_.store8(in_console(Offsets::sp()), r9);
    a_.move(r10, uint32_t{0x68});
    emit_input(4);
}

// Loads the target of an RTS, JMP or JSR into r9. r8 is the index of the instruction.
void Translator::find_target(uint16_t handler, JumpLabel& slow) {
    if (handler == RTS_Imp) {
        a_.load8(r8, in_console(Offsets::sp()));
        a_.address(r9, Mem{r8, -0x80});
        a_.alu(Alu::cmp, r9, 0x7e);
        a_.jump(If::not_below, slow);
        a_.load16(r9, Mem{kRam, 1 - 0x80, r8});
        a_.move(r10, r9);  // the byte there is read too
        a_.shift(ShiftDirection::right, r10, 6);
        a_.extend8(r10, r10);
        a_.alu64(Alu::cmp, Mem{kConsole, Offsets::pages(), r10, 8}, 0);
        a_.jump(If::zero, slow);
        a_.alu(Alu::add, r9, 1);
        a_.alu(Alu::and_, r9, 0xffff);
    } else {
        load_operand();
    }
    if (handler == JSR_Far) {
        a_.alu8(Alu::cmp, in_console(Offsets::sp()), uint8_t{0x81});
        a_.jump(If::below, slow);
    }
    if (handler == JMP_Ind) {
        a_.move(r10, r9);
        a_.alu(Alu::and_, r10, 0x1280);
        a_.alu(Alu::cmp, r10, 0x80);
        a_.jump(If::not_zero, slow);
        a_.alu(Alu::and_, r9, 0x7f);
        a_.alu(Alu::cmp, r9, 0x7f);
        a_.jump(If::zero, slow);
        a_.load16(r9, Mem{kRam, 0, r9});
    }
}

// Emits RTS, JMP or JSR to an address that is computed at run time. r8 is the index of the instruction.
void Translator::emit_far(JumpLabel& label, uint16_t handler) {
    JumpLabel slow;
    a_.bind(label);
    a_.store(in_registers(Offsets::at()), r8);  // for the slow path and for `push_return_address`
    find_target(handler, slow);
    find_entry(slow);
    if (handler == RTS_Imp) a_.alu8(Alu::add, in_console(Offsets::sp()), uint8_t{2});
    if (handler == JSR_Far) push_return_address();
    a_.alu(Alu::and_, r9, 0xfc00);
    a_.store(in_console(Offsets::origin()), r9);
    a_.shift64(ShiftDirection::left, r10, kInstructionShift);
    a_.alu64(Alu::add, r10, in_console(Offsets::first_instruction()));
    a_.store64(in_console(Offsets::base_instruction()), r10);
    a_.alu(Alu::add, kCycles, handler == JMP_Far ? 3 : handler == JMP_Ind ? 5 : 6);
    a_.move(r8, uint32_t{0});
    a_.alu(Alu::cmp, kCycles, in_console(Offsets::cycle_limit()));
    a_.jump(If::not_below, limit_);
    a_.jump(r11);
    a_.bind(slow);
    a_.load(r8, in_registers(Offsets::at()));
    call_routine(handler);
    a_.jump(dispatch_);
}

// Loads the entry for the address in r9 into r11, and the image offset of its 1 KiB segment into r10. Jumps to `slow`
// if there is no entry. Uses r8.
void Translator::find_entry(JumpLabel& slow) {
    a_.move(r10, r9);
    a_.shift(ShiftDirection::right, r10, 10);
    a_.alu(Alu::and_, r10, 15);
    a_.load(r11, in_console(Offsets::code_segments()));
    a_.test_bit(r11, r10);
    a_.jump(If::not_below, slow);
    a_.load(r10, Mem{kConsole, Offsets::segments(), r10, 4});
    a_.move(r11, r9);
    a_.alu(Alu::and_, r11, 0x3ff);
    a_.alu(Alu::add, r11, r10);
    a_.address_of(r8, start_);
    a_.load(r11, Mem{r8, -table_size(), r11, sizeof(TableEntry)});
    a_.test(r11, r11);
    a_.jump(If::zero, slow);
    a_.address64(r11, Mem{r8, -table_size(), r11});
}

// Pushes the return address of the JSR whose index is in `at`.
void Translator::push_return_address() {
    a_.load64(r8, in_console(Offsets::first_instruction()));
    a_.alu64(Alu::sub, r8, in_console(Offsets::base_instruction()));
    a_.shift(ShiftDirection::right, r8, kInstructionShift);
    a_.alu(Alu::add, r8, in_registers(Offsets::at()));
    a_.alu(Alu::add, r8, in_console(Offsets::origin()));
    a_.alu(Alu::add, r8, 2);
    a_.push(r9);
    a_.load8(r9, in_console(Offsets::sp()));
    a_.store16(Mem{kRam, -0x81, r9}, r8);
    a_.pop(r9);
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
    if constexpr (kTranslates) code_.fill(Translator(image, decoded).translate(start_));
}

}  // namespace atari
