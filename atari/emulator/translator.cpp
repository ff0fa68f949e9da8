#include "translator.hpp"

#include <algorithm>
#include <cstring>

#include "places.hpp"
#include "translation.hpp"

namespace atari {
namespace {

// Machine code is that of x86-64, called as on Unix; and its entries are reached through the records (fast_cpu.cpp).
#if defined(__x86_64__) && defined(__LP64__) && defined(__GNUC__) && !defined(_WIN32) && !defined(ATARI_NO_COMPUTED_GOTO)
constexpr bool kTranslates = true;
#else
constexpr bool kTranslates = false;
#endif

}  // namespace

Translator::Translator(const uint8_t* image, const std::vector<Record>& records)
    : image_(image), records_(records), size_(records.size() - 1), is_instruction_(size_ + 1), is_target_(size_ + 1),
      handlers_(kHandlers), entries_(size_ + 1), begins_(size_ + 1, -1), missing_(size_ + 1),
      assumes_(size_ + 1), until_write_(size_ + 1) {}

std::vector<uint8_t> Translator::translate(std::size_t& enter) {
    find_instructions();
    emit_common();
    for (std::size_t place = 0; place < size_; ++place)
        if (is_instruction_[place] && begins_[place] < 0) emit_run(place);
    emit_entries();
    emit_asides();
    for (uint16_t handler = 0; handler < kHandlers; ++handler)
        if (handlers_[handler].last_jump >= 0) emit_routine(handler);
    return finish(enter);
}

std::size_t Translator::next_of(std::size_t place) const {
    return place + static_cast<std::size_t>(length_of(kind_of(records_[place]).operand));
}

std::size_t Translator::target_of(std::size_t place) const {
    return static_cast<std::size_t>(static_cast<std::ptrdiff_t>(place) + records_[place].jump);
}

// Those that are reached from where a bank begins, and then whatever else can be decoded between them: code that is
// reached through tables, and data, which is never run. What is run and has not been found is left to handlers.
void Translator::find_instructions() {
    std::vector<bool> covered(size_ + 3);
    const std::size_t bank_size = std::min<std::size_t>(size_, 4096);
    for (std::size_t bank = 0; bank + bank_size <= size_; bank += bank_size) {
        const uint8_t* const vector = image_ + bank + bank_size - 4;
        reach(bank + (vector[0] | std::size_t{vector[1]} << 8) % bank_size, covered);
    }
    for (std::size_t place = 0; place < size_; ++place)
        if (!covered[place]) reach(place, covered);
}

// The instructions from here on, and where they branch, as far as they have not been found.
void Translator::reach(std::size_t first, std::vector<bool>& covered) {
    std::vector<std::size_t> pending{first};
    while (!pending.empty()) {
        std::size_t place = pending.back();
        pending.pop_back();
        while (!is_instruction_[place] && records_[place].handler != kStep) {
            is_instruction_[place] = true;
            const auto [operation, operand] = kind_of(records_[place]);
            if (operand == Operand::Rel || operand == Operand::Near) {
                is_target_[target_of(place)] = true;
                pending.push_back(target_of(place));
            }
            const std::size_t next = next_of(place);
            for (std::size_t byte = place; byte < next; ++byte) covered[byte] = true;
            if (ends_run(operation)) break;
            if (operation == JSR) is_target_[next] = true;
            place = next;
        }
    }
}

// Instructions one behind the other, as far as they have not been translated.
void Translator::emit_run(std::size_t place) {
    pending_ = 0;
    carry_.reset();
    in_time_until_ = 0;
    for (;;) {
        place_ = place;
        if (is_target_[place]) {
            add_pending();
            carry_.reset();
        }
        begins_[place] = static_cast<int32_t>(a_.size());
        missing_[place] = static_cast<uint16_t>(pending_);
        const Kind kind = kind_of(records_[place]);
        operation_ = kind.operation;
        operand_ = kind.operand;
        given_ = records_[place].operand;
        emit();
        if (ends_run(operation_)) return;
        place = next_of(place);
        if (is_instruction_[place] && begins_[place] < 0) continue;
        go_to(place, false);
        return;
    }
}

// To another instruction, whether it has been translated or not.
void Translator::go_to(std::size_t target, bool backward) {
    add_pending();
    if (!is_instruction_[target]) {
        a_.move(r8, static_cast<uint32_t>(target));
        a_.jump(leave_);
        return;
    }
    if (backward) {
        a_.alu(Alu::cmp, kCycles, in_console(Places::cycle_limit()));
        asides_.push_back({{}, Aside::kLimit, target, 0, 0, {}, {}});
        a_.jump(If::not_below, asides_.back().from);
    }
    a_.jump(entries_[target]);
}

void Translator::add_pending() {
    if (pending_) a_.alu(Alu::add, kCycles, pending_);
    pending_ = 0;
}

// Calls the handler of an instruction, which adds its cycles itself.
void Translator::call_handler(std::size_t place) {
    a_.move(r8, static_cast<uint32_t>(place));
    const Record& record = records_[place];
    a_.call(handlers_[record.handler == kLoop ? static_cast<uint16_t>(record.jump) : record.handler]);
}

// Those from here to the one that is being translated build on what the first of them has found.
void Translator::assume_from(std::size_t place) {
    for (; place <= place_; place = next_of(place)) assumes_[place] = true;
}

void Translator::emit_entries() {
    pending_ = 0;
    for (std::size_t place = 0; place < size_; ++place)
        if (begins_[place] >= 0) emit_entry(place);
}

// For who does not come from the instruction before. What builds on that one is left to handlers, and so are writes that
// may be too late.
void Translator::emit_entry(std::size_t place) {
    const int32_t missing = missing_[place], until_write = until_write_[place];
    if (!missing && !until_write && !assumes_[place]) return a_.bind(entries_[place], begins_[place]);
    a_.bind(entries_[place]);
    if (!assumes_[place]) {
        Label begin{begins_[place]}, late;
        if (until_write) emit_check_of_time(until_write, late);
        if (missing) a_.alu(Alu::sub, kCycles, missing);
        a_.jump(begin);
        if (!until_write) return;
        a_.bind(late);
    }
    call_handler(place);
    go_to(next_of(place), false);
}

void Translator::emit_asides() {
    for (Aside& aside : asides_) {
        a_.bind(aside.from);
        if (aside.before) a_.alu(Alu::add, kCycles, aside.before);
        switch (aside.what) {
            case Aside::kHandler: case Aside::kEnterBehind:
                if (aside.nz) a_.move(kNz, *aside.nz);
                call_handler(aside.place);
                if (aside.what == Aside::kEnterBehind) {
                    go_to(next_of(aside.place), false);
                    break;
                }
                if (aside.after) a_.alu(Alu::sub, kCycles, aside.after);
                a_.jump(aside.back);
                break;
            case Aside::kJumpByHandler:
                call_handler(aside.place);
                a_.jump(dispatch_);
                break;
            case Aside::kBranch:
                go_to(aside.place, false);
                break;
            case Aside::kLimit:
                a_.move(r8, static_cast<uint32_t>(aside.place));
                a_.jump(limit_);
                break;
        }
    }
}

void Translator::save_registers() {
    a_.store(in_registers(Places::cycles()), kCycles);
    a_.store(in_registers(Places::a()), kA);
    a_.store(in_registers(Places::x()), kX);
    a_.store(in_registers(Places::y()), kY);
    a_.store(in_registers(Places::nz()), kNz);
    a_.store(in_registers(Places::carry()), kCarry);
    a_.store64(in_console(Places::log_end()), kLog);
}

void Translator::load_registers() {
    a_.load(kCycles, in_registers(Places::cycles()));
    a_.load(kA, in_registers(Places::a()));
    a_.load(kX, in_registers(Places::x()));
    a_.load(kY, in_registers(Places::y()));
    a_.load(kNz, in_registers(Places::nz()));
    a_.load(kCarry, in_registers(Places::carry()));
    a_.load64(kLog, in_console(Places::log_end()));
}

// A call of a function that takes the registers and the console and returns an `Exit`, for the record in r8. Unless that
// is kNext it ends the run.
void Translator::emit_call(Label& label, FastCpu::Step function) {
    a_.bind(label);
    find_record();
    save_registers();
    a_.move64(rdi, kRegisters);
    a_.move64(rsi, kConsole);
    a_.move64(r9, reinterpret_cast<uintptr_t>(function));
    a_.add_to_stack(-8);
    a_.call(r9);
    a_.add_to_stack(8);
    a_.test(rax, rax);
    const std::size_t stays = a_.jump_short(If::zero);
    a_.add_to_stack(8);
    a_.jump(exit_);
    a_.bind_short(stays);
    load_registers();
    a_.ret();
}

// The record in r8, by its number until then.
void Translator::find_record() {
    a_.shift64(Shift::left, r8, 4);
    a_.alu64(Alu::add, r8, in_console(Places::first_record()));
    a_.store64(in_registers(Places::at()), r8);
}

void Translator::emit_common() {
    static constexpr Reg kSaved[] = {rbx, rbp, r12, r13, r14, r15};
    a_.bind(start_);  // (registers, console, where to go on)
    for (const Reg reg : kSaved) a_.push(reg);
    a_.add_to_stack(-8);
    a_.move64(kRegisters, rdi);
    a_.move64(kConsole, rsi);
    a_.move64(r8, rdx);
    a_.address64(kRam, in_console(Places::ram()));
    a_.load(kOverlong, in_console(Places::overlong()));
    load_registers();
    a_.jump(r8);

    emit_call(skip_, &FastCpu::skip_loop);
    emit_far(return_, RTS_Imp);
    emit_far(jump_far_, JMP_Far);
    emit_far(call_far_, JSR_Far);
    emit_far(jump_indirect_, JMP_Ind);

    a_.bind(dispatch_);  // to the record at which the handler of a jump has left off
    a_.load64(r8, in_registers(Places::at()));
    a_.alu64(Alu::sub, r8, in_console(Places::first_record()));
    a_.alu64(Alu::cmp, r8, static_cast<int32_t>(sizeof(Record) * size_));
    a_.jump(If::not_below, left_);
    a_.shift64(Shift::right, r8, 2);
    a_.address_of(r9, start_);
    a_.load(r8, Mem{r9, -table_size(), r8});
    a_.test(r8, r8);
    a_.jump(If::zero, left_);
    a_.address64(r8, Mem{r9, -table_size(), r8});
    a_.jump(r8);

    a_.bind(limit_);  // at the record in r8
    find_record();
    save_registers();
    a_.move(rax, uint32_t{kLimit});
    a_.jump(exit_);
    a_.bind(leave_);
    find_record();
    a_.bind(left_);
    save_registers();
    a_.move(rax, uint32_t{kNext});
    a_.bind(exit_);
    a_.add_to_stack(8);
    for (int i = 5; i >= 0; --i) a_.pop(kSaved[i]);
    a_.ret();
}

// What is called in place of a handler; the handler itself, but for some that are run many times a frame.
void Translator::emit_routine(uint16_t handler) {
    Label slow;
    a_.bind(handlers_[handler]);
    const auto [operation, operand] = kKinds[handler];
    if (operation == PHP) emit_push_status(slow);
    if (operation == PLA) emit_pull_input(slow);
    if (operation == LDA) emit_read_input(operand, slow);
    emit_call(slow, FastCpu::step_of(handler));
}

// PHP, into RAM or a register of the TIA.
void Translator::emit_push_status(Label& slow) {
    static constexpr uint64_t kTia = [] {  // registers that can be written again without effect
        uint64_t set = 0;
        for (uint8_t reg = 0; reg < 64; ++reg) set |= uint64_t{kStoredIn[reg] == Operand::Tia} << reg;
        return set;
    }();
    a_.move(r10, kNz);
    a_.shift(Shift::right, r10, 1);
    a_.alu(Alu::or_, r10, kNz);
    a_.alu(Alu::and_, r10, 0x80);
    a_.alu8(Alu::cmp, in_console(Places::overflow()), uint8_t{1});  // a borrow if it is clear
    a_.alu(Alu::sbb, r11, r11);
    a_.alu(Alu::add, r11, 1);
    a_.shift(Shift::left, r11, 6);
    a_.alu(Alu::or_, r10, r11);
    a_.alu8(Alu::or_, r10, in_console(Places::modes()));
    a_.shift(Shift::right, r10, 2);
    a_.alu8(Alu::cmp, kNz, uint8_t{1});  // a borrow if it is zero
    a_.alu(Alu::adc, r10, r10);
    a_.address(r10, Mem{kCarry, 0, r10, 2});

    a_.load8(r9, in_console(Places::sp()));
    a_.test8(r9, r9);
    const std::size_t in_ram = a_.jump_short(If::sign);
    a_.alu8(Alu::cmp, in_console(Places::watches_tia()), uint8_t{0});
    a_.jump(If::not_zero, slow);
    a_.move64(r11, kTia);
    a_.test_bit64(r11, r9);
    a_.jump(If::not_below, slow);
    a_.address(r11, Mem{kCycles, 3});
    a_.alu(Alu::cmp, r11, kOverlong);
    a_.jump(If::not_below, slow);
    a_.alu(Alu::and_, r9, 0x3f);
    a_.alu8(Alu::cmp, Mem{kConsole, Places::written(), r9}, r10);
    const std::size_t same = a_.jump_short(If::zero);
    a_.store8(Mem{kConsole, Places::written(), r9}, r10);
    a_.store(Mem{kLog}, r11);
    a_.store(Mem{kLog, 4}, r9);
    a_.store8(Mem{kLog, 5}, r10);
    a_.address64(kLog, Mem{kLog, 8});
    a_.bind_short(same);
    a_.alu8(Alu::sub, in_console(Places::sp()), uint8_t{1});
    a_.alu(Alu::add, kCycles, 3);
    a_.ret();
    a_.bind_short(in_ram);
    a_.store8(Mem{kRam, -0x80, r9}, r10);
    a_.alu8(Alu::sub, in_console(Places::sp()), uint8_t{1});
    a_.alu(Alu::add, kCycles, 3);
    a_.ret();
}

// The operand of the instruction whose place is in r8, into r9.
void Translator::load_operand() {
    a_.move64(r9, r8);
    a_.shift64(Shift::left, r9, 4);
    a_.alu64(Alu::add, r9, in_console(Places::first_record()));
    a_.load16(r9, Mem{r9, offsetof(Record, operand)});
}

// Into A the input of the TIA at the address in r9: bit 7, and what is on the bus, in r10.
void Translator::emit_input(int32_t cost) {
    a_.alu(Alu::add, kCycles, cost);
    a_.alu(Alu::and_, r9, 7);
    a_.alu64(Alu::cmp, kCycles, Mem{kConsole, Places::inputs(), r9, 8});
    a_.alu(Alu::sbb, kA, kA);
    a_.alu(Alu::and_, kA, -0x80);
    a_.alu(Alu::add, kA, 0x80);
    a_.alu(Alu::and_, r10, 0x3f);
    a_.alu(Alu::or_, kA, r10);
    a_.move(kNz, kA);
    a_.ret();
}

// LDA by an index that leads to an input.
void Translator::emit_read_input(Operand operand, Label& slow) {
    if (operand != Operand::RamX && operand != Operand::AnyX && operand != Operand::AnyY) return;
    load_operand();
    a_.move(r10, r9);
    a_.alu(Alu::add, r9, operand == Operand::AnyY ? kY : kX);
    a_.move(r11, r9);
    a_.alu(Alu::and_, r11, operand == Operand::RamX ? 0x88 : 0x1088);
    a_.alu(Alu::cmp, r11, 8);
    a_.jump(If::not_zero, slow);
    a_.alu8(Alu::cmp, in_console(Places::watches_tia()), uint8_t{0});
    a_.jump(If::not_zero, slow);
    if (operand != Operand::RamX) {
        a_.move(r11, r10);
        a_.alu(Alu::xor_, r11, r9);
        a_.test(r11, uint32_t{0xff00});
        a_.jump(If::not_zero, slow);  // across a page
        a_.shift(Shift::right, r10, 8);
    }
    emit_input(4);
}

// PLA from an input, with another below it that is read first.
void Translator::emit_pull_input(Label& slow) {
    a_.load8(r9, in_console(Places::sp()));
    a_.move(r10, r9);
    a_.alu(Alu::and_, r10, 0x88);
    a_.alu(Alu::cmp, r10, 8);
    a_.jump(If::not_zero, slow);
    a_.alu(Alu::add, r9, 1);
    a_.move(r10, r9);
    a_.alu(Alu::and_, r10, 0x88);
    a_.alu(Alu::cmp, r10, 8);
    a_.jump(If::not_zero, slow);
    a_.alu8(Alu::cmp, in_console(Places::watches_tia()), uint8_t{0});
    a_.jump(If::not_zero, slow);
    a_.store8(in_console(Places::sp()), r9);
    a_.move(r10, uint32_t{0x68});
    emit_input(4);
}

// Where RTS, JMP or JSR go, into r9. The place of the instruction is in r8.
void Translator::find_target(uint16_t handler, Label& slow) {
    if (handler == RTS_Imp) {
        a_.load8(r8, in_console(Places::sp()));
        a_.address(r9, Mem{r8, -0x80});
        a_.alu(Alu::cmp, r9, 0x7e);
        a_.jump(If::not_below, slow);
        a_.load16(r9, Mem{kRam, 1 - 0x80, r8});
        a_.move(r10, r9);  // the byte there is read, too
        a_.shift(Shift::right, r10, 6);
        a_.extend8(r10, r10);
        a_.alu64(Alu::cmp, Mem{kConsole, Places::pages(), r10, 8}, 0);
        a_.jump(If::zero, slow);
        a_.alu(Alu::add, r9, 1);
        a_.alu(Alu::and_, r9, 0xffff);
    } else {
        load_operand();
    }
    if (handler == JSR_Far) {
        a_.alu8(Alu::cmp, in_console(Places::sp()), uint8_t{0x81});
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

// A jump to an address that is only known when it is run, of the instruction whose place is in r8: RTS, JMP or JSR.
void Translator::emit_far(Label& label, uint16_t handler) {
    Label slow;
    a_.bind(label);
    a_.store(in_registers(Places::at()), r8);  // in case that its handler has to do it
    find_target(handler, slow);
    find_begin(slow);
    if (handler == RTS_Imp) a_.alu8(Alu::add, in_console(Places::sp()), uint8_t{2});
    if (handler == JSR_Far) push_return_address();
    a_.alu(Alu::and_, r9, 0xfc00);
    a_.store(in_console(Places::origin()), r9);
    a_.shift64(Shift::left, r10, 4);
    a_.alu64(Alu::add, r10, in_console(Places::first_record()));
    a_.store64(in_console(Places::base_record()), r10);
    a_.alu(Alu::add, kCycles, handler == JMP_Far ? 3 : handler == JMP_Ind ? 5 : 6);
    a_.move(r8, uint32_t{0});
    a_.alu(Alu::cmp, kCycles, in_console(Places::cycle_limit()));
    a_.jump(If::not_below, limit_);
    a_.jump(r11);
    a_.bind(slow);
    a_.load(r8, in_registers(Places::at()));
    a_.call(handlers_[handler]);
    a_.jump(dispatch_);
}

// Where the machine code for the address in r9 begins, in r11, and in r10 where in the image its 1 KiB is. To `slow` if
// there is none. r8 is lost.
void Translator::find_begin(Label& slow) {
    a_.move(r10, r9);
    a_.shift(Shift::right, r10, 10);
    a_.alu(Alu::and_, r10, 15);
    a_.load(r11, in_console(Places::code_segments()));
    a_.test_bit(r11, r10);
    a_.jump(If::not_below, slow);
    a_.load(r10, Mem{kConsole, Places::segments(), r10, 4});
    a_.move(r11, r9);
    a_.alu(Alu::and_, r11, 0x3ff);
    a_.alu(Alu::add, r11, r10);
    a_.address_of(r8, start_);
    a_.load(r11, Mem{r8, -table_size(), r11, 4});
    a_.test(r11, r11);
    a_.jump(If::zero, slow);
    a_.address64(r11, Mem{r8, -table_size(), r11});
}

// That of the JSR whose place is in memory.
void Translator::push_return_address() {
    a_.load64(r8, in_console(Places::first_record()));
    a_.alu64(Alu::sub, r8, in_console(Places::base_record()));
    a_.shift(Shift::right, r8, 4);
    a_.alu(Alu::add, r8, in_registers(Places::at()));
    a_.alu(Alu::add, r8, in_console(Places::origin()));
    a_.alu(Alu::add, r8, 2);
    a_.push(r9);
    a_.load8(r9, in_console(Places::sp()));
    a_.store16(Mem{kRam, -0x81, r9}, r8);
    a_.pop(r9);
    a_.alu8(Alu::sub, in_console(Places::sp()), uint8_t{2});
}

std::vector<uint8_t> Translator::finish(std::size_t& enter) {
    const auto table = static_cast<std::size_t>(table_size());
    std::vector<uint8_t> code(table + a_.size());
    enter = table + static_cast<std::size_t>(start_.at);
    for (std::size_t place = 0; place < size_; ++place) {
        const int32_t begins = is_instruction_[place] ? entries_[place].at + table_size() : 0;
        std::memcpy(code.data() + sizeof begins * place, &begins, sizeof begins);
    }
    std::copy(a_.bytes().begin(), a_.bytes().end(), code.begin() + table_size());
    return code;
}

void Translation::make(const uint8_t* image, const std::vector<Record>& records) {
    if constexpr (kTranslates) code_.fill(Translator(image, records).translate(enter_));
}

}  // namespace atari
