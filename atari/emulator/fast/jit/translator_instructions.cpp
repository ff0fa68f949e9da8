// Translated code of each instruction but stores. It handles the likely case of the handler (handlers.hpp). In all
// other cases a slow path calls the handler, before anything has changed.
#include <stdexcept>

#include "offsets.hpp"
#include "translator.hpp"

namespace atari {
namespace {

// Reached if `is_inlined` (basic_blocks.cpp) and the code below disagree.
[[noreturn]] void refuse() { throw std::logic_error("an instruction has no inline code"); }

}  // namespace

void Translator::emit(const BlockInstruction& instruction) {
    at_ = &instruction;
    slow_ = {};
    cycles_ = instruction.entry.cycles;
    if (instruction.loops) skip_rounds();
    const int32_t before = cycles_;
    if (instruction.is_inlined) {
        emit_inline();
    } else {
        add_cycles(cycles_);
        call_handler(instruction.place);
    }
    if (slow_.last_jump < 0) return;
    const auto what = is_jump(instruction.operation) ? SlowPath::kJumpByHandler : SlowPath::kHandler;
    slow_paths_.push_back({slow_,
                           what,
                           instruction.place,
                           before,
                           instruction.cycles_after,
                           instruction.entry.nz,
                           {static_cast<int32_t>(a_.size())}});
}

void Translator::emit_inline() {
    if (at_->operand == Operand::Rel) return emit_branch();
    if (is_jump(at_->operation)) return emit_jump();
    if (is_read(at_->operation)) return emit_read();
    if (is_store(at_->operation)) return emit_store();
    if (is_modify(at_->operation)) return emit_modify();
    emit_implied();
}

// Skips all rounds but the last of a loop that only waits, counts or divides. Counting loops are skipped inline;
// `Interpreter::skip_rounds` skips the others.
void Translator::skip_rounds() {
    add_cycles(cycles_);
    cycles_ = 0;
    const DecodedInstruction& instruction = decoded_[at_->place];
    if (instruction.loop != Loop::kCountX && instruction.loop != Loop::kCountY) {
        a_.move(r8, static_cast<uint32_t>(at_->place));
        a_.call(skip_);
        return;
    }
    const Reg counter = instruction.loop == Loop::kCountX ? kX : kY;
    // Otherwise until the counter is past 0.
    const bool until_zero = kind_of(decoded_[at_->place + 1]).operation == BNE;
    std::optional<ShortJump> many;
    a_.move(r8, counter);
    if (until_zero) {
        a_.decrement8(r8);
    } else {
        a_.alu(Alu::cmp, counter, 0x80);
        many = a_.jump_short(If::above);
    }
    a_.multiply(r8, r8, instruction.taken);
    a_.alu(Alu::add, r8, kCycles);
    a_.alu(Alu::cmp, r8, in_console(Offsets::cycle_limit()));
    const ShortJump near_limit = a_.jump_short(If::not_below);
    a_.move(kCycles, r8);
    a_.move(counter, uint32_t{until_zero});
    a_.bind_short(near_limit);
    if (many) a_.bind_short(*many);
}

// --- jumps ---

void Translator::emit_branch() {
    const std::size_t target = target_place(decoded_, at_->place);
    const bool backward = target <= at_->place;
    If taken = If::zero;
    switch (at_->operation) {
        case BNE:
        case BEQ:
            a_.test8(kNz, kNz);
            taken = at_->operation == BEQ ? If::zero : If::not_zero;
            break;
        case BPL:
        case BMI:
            a_.test(kNz, uint32_t{0x180});
            taken = at_->operation == BPL ? If::zero : If::not_zero;
            break;
        case BCC:
        case BCS:
            a_.test(kCarry, kCarry);
            taken = at_->operation == BCC ? If::zero : If::not_zero;
            break;
        default:
            a_.alu8(Alu::cmp, in_console(Offsets::overflow()), uint8_t{0});
            taken = at_->operation == BVC ? If::zero : If::not_zero;
    }
    const int32_t cycles = cycles_ + decoded_[at_->place].taken;
    if (backward) {
        JumpLabel otherwise;
        a_.jump(opposite(taken), otherwise);
        go_to(target, cycles, true);
        a_.bind(otherwise);
    } else {
        slow_paths_.push_back({{}, SlowPath::kBranchTaken, target, cycles, 0, {}, {}});
        a_.jump(taken, slow_paths_.back().from);
    }
}

void Translator::emit_jump() {
    if (at_->operand != Operand::Near) {
        JumpLabel& jump = at_->operand == Operand::Ind ? jump_indirect_ : jump_far_;
        add_cycles(cycles_);
        a_.move(r8, static_cast<uint32_t>(at_->place));
        a_.jump(at_->operation == RTS ? return_ : at_->operation == JSR ? call_far_ : jump);
        return;
    }
    const std::size_t target = target_place(decoded_, at_->place);
    if (at_->operation == JSR) {
        a_.load8(r8, in_console(Offsets::sp()));
        a_.alu(Alu::cmp, r8, 0x81);
        a_.jump(If::below, slow_);
    }
    a_.load(r9, in_console(Offsets::origin()));  // the likely target is in the same 4 KiB
    a_.move(r10, r9);
    a_.alu(Alu::xor_, r10, int32_t{at_->given});
    a_.test(r10, uint32_t{0xf000});
    a_.jump(If::not_zero, slow_);
    if (at_->operation == JSR) {
        a_.load64(r10, in_console(Offsets::first_instruction()));
        a_.alu64(Alu::sub, r10, in_console(Offsets::base_instruction()));
        a_.shift(ShiftDirection::right, r10, kInstructionShift);
        a_.address(r9, Mem{r9, static_cast<int32_t>(at_->place + 2), r10});
        a_.store16(Mem{kRam, -0x81, r8}, r9);
        a_.alu8(Alu::sub, in_console(Offsets::sp()), uint8_t{2});
    }
    go_to(target, cycles_ + (at_->operation == JSR ? 6 : 3), target <= at_->place);
}

// --- reads ---

// Adds the cycle of a page crossing.
void Translator::add_page_crossing(Reg index) {
    if (!(at_->given & 0xff)) return;
    a_.alu8(Alu::cmp, index, static_cast<uint8_t>(-at_->given));  // sets the carry if no page is crossed
    a_.alu(Alu::sbb, kCycles, -1);
}

// Returns the byte at the address in r9, if it can be read without side effects.
Translator::Source Translator::paged() {
    a_.move(r10, r9);
    a_.shift(ShiftDirection::right, r10, 6);
    a_.extend8(r10, r10);
    a_.load64(r11, Mem{kConsole, Offsets::pages(), r10, 8});
    a_.test64(r11, r11);
    a_.jump(If::zero, slow_);
    a_.alu(Alu::and_, r9, 63);
    return {{}, Mem{r11, 0, r9}, r8};
}

void Translator::emit_read() {
    if (at_->operation == ADC || at_->operation == SBC) {
        a_.alu8(Alu::cmp, in_console(Offsets::decimal()), uint8_t{0});
        a_.jump(If::not_zero, slow_);
    }
    const auto cost = static_cast<int32_t>(read_cost(at_->operand));
    Source source{{}, {}, r8};
    switch (at_->operand) {
        case Operand::Imm:
        case Operand::Fixed: source.constant = static_cast<uint8_t>(at_->given); break;
        case Operand::Ram:
        case Operand::RamA: source.memory = in_ram(at_->given); break;
        case Operand::RamX:
        case Operand::RamY:
            indexed_ram();
            source.memory = Mem{kRam, 0, r8};
            break;
        case Operand::Input:
            a_.address(r8, Mem{kCycles, cycles_ + cost});
            a_.alu64(Alu::cmp, r8, in_console(Offsets::inputs() + 8 * (at_->given & 7)));
            a_.alu(Alu::sbb, r8, r8);
            a_.alu(Alu::and_, r8, -0x80);
            a_.alu(Alu::add, r8, 0x80);
            a_.alu(Alu::or_, r8, at_->given & 0x3f);
            break;
        case Operand::RomX:
        case Operand::RomY: {
            const Reg index = index_of(at_->operand);
            a_.load64(r9, in_console(Offsets::bank()));
            add_page_crossing(index);
            source.memory = Mem{r9, at_->given, index};
            break;
        }
        case Operand::Timer: {
            // The timer's value, as long as the timer has not expired.
            a_.address(r8, Mem{kCycles, cycles_ + cost - 1});
            a_.alu(Alu::sub, r8, in_console(Offsets::timer_set_at()));
            a_.move(r9, kX);
            a_.load8(rcx, in_console(Offsets::timer_shift()));
            a_.shift_by_cl(ShiftDirection::right, r8);
            a_.move(kX, r9);
            a_.load8(r9, in_console(Offsets::timer()));
            a_.alu(Alu::sub, r9, r8);
            a_.jump(If::not_above, slow_);
            a_.address(r8, Mem{r9, -1});
            break;
        }
        case Operand::AnyX:
        case Operand::AnyY:
            a_.address(r9, Mem{index_of(at_->operand), at_->given});
            source = paged();
            add_page_crossing(index_of(at_->operand));
            break;
        case Operand::IndY:
            a_.load16(r8, in_ram(at_->given));
            a_.address(r9, Mem{r8, 0, kY});
            source = paged();
            a_.alu8(Alu::add, r8, kY);  // sets the carry on a page crossing
            a_.alu(Alu::adc, kCycles, 0);
            break;
        default: refuse();
    }
    operate(source);
}

// Loads the offset in RAM of an indexed operand into r8.
void Translator::indexed_ram() {
    a_.move(r8, index_of(at_->operand));
    a_.alu8(Alu::add, r8, static_cast<uint8_t>(at_->given - 0x80));
    a_.jump(If::sign, slow_);
}

void Translator::combine(Alu what, Reg to, const Source& source) {
    if (source.constant) a_.alu8(what, to, *source.constant);
    else if (source.memory) a_.alu8(what, to, *source.memory);
    else a_.alu8(what, to, source.reg);
}

void Translator::read_into(Reg to, const Source& source) {
    if (source.constant) a_.move(to, uint32_t{*source.constant});
    else if (source.memory) a_.load8(to, *source.memory);
    else a_.move(to, source.reg);
}

void Translator::set_nz(Reg of) {
    if (!at_->omits_nz) a_.move(kNz, of);
}

void Translator::operate(const Source& source) {
    switch (at_->operation) {
        case LDA:
        case LDX:
        case LDY: {
            const Reg to = at_->operation == LDA ? kA : at_->operation == LDX ? kX : kY;
            read_into(to, source);
            set_nz(to);
            break;
        }
        case AND:
        case ORA:
        case EOR:
            combine(at_->operation == AND ? Alu::and_ : at_->operation == ORA ? Alu::or_ : Alu::xor_, kA, source);
            set_nz(kA);
            break;
        case CMP:
        case CPX:
        case CPY:
            a_.move(kNz, at_->operation == CMP ? kA : at_->operation == CPX ? kX : kY);
            combine(Alu::sub, kNz, source);
            a_.set(If::not_below, kCarry);
            break;
        case BIT:
            read_into(r8, source);
            a_.address(r9, Mem{r8, 0, r8});
            a_.alu(Alu::and_, r9, 0x180);
            a_.store8(in_console(Offsets::overflow()), r9);
            a_.alu(Alu::and_, r9, 0x100);
            a_.move(kNz, kA);
            a_.alu(Alu::and_, kNz, r8);
            a_.alu(Alu::or_, kNz, r9);
            break;
        default: {  // ADC and SBC. In subtractions the host's carry is a borrow.
            const bool adds = at_->operation == ADC;
            // The carry of ADC, or the borrow of SBC, is known to be 0.
            const bool without = at_->entry.carry.has_value();
            if (!without && adds) a_.test_bit(kCarry, uint8_t{0});
            if (!without && !adds) a_.alu(Alu::cmp, kCarry, 1);
            combine(adds ? without ? Alu::add : Alu::adc : without ? Alu::sub : Alu::sbb, kA, source);
            a_.set(adds ? If::below : If::not_below, kCarry);
            a_.set8(If::overflow, in_console(Offsets::overflow()));
            set_nz(kA);
        }
    }
}

// --- the rest ---

void Translator::emit_modify() {
    Reg value = r9;
    Mem memory = in_ram(at_->given);
    switch (at_->operand) {
        case Operand::Acc: value = kA; break;
        case Operand::Ram: break;
        case Operand::RamX:
            indexed_ram();
            memory = Mem{kRam, 0, r8};
            break;
        default: refuse();
    }
    if (at_->operand != Operand::Acc) a_.load8(value, memory);
    switch (at_->operation) {
        case INC: a_.increment8(value); break;
        case DEC: a_.decrement8(value); break;
        case ASL:
        case LSR:
            a_.move(kCarry, value);
            if (at_->operation == ASL) a_.shift(ShiftDirection::right, kCarry, 7);
            else a_.alu(Alu::and_, kCarry, 1);
            a_.shift(at_->operation == ASL ? ShiftDirection::left : ShiftDirection::right, value, 1);
            if (at_->operation == ASL) a_.extend8(value, value);
            break;
        case ROL:
            a_.address(r10, Mem{kCarry, 0, value, 2});
            a_.move(kCarry, value);
            a_.shift(ShiftDirection::right, kCarry, 7);
            a_.extend8(value, r10);
            break;
        default:  // ROR
            a_.move(r10, kCarry);
            a_.shift(ShiftDirection::left, r10, 7);
            a_.move(kCarry, value);
            a_.alu(Alu::and_, kCarry, 1);
            a_.shift(ShiftDirection::right, value, 1);
            a_.alu(Alu::or_, value, r10);
    }
    if (at_->operand == Operand::Acc) {
        set_nz(kA);
    } else {
        a_.move(kNz, value);
        a_.store8(memory, value);
    }
}

void Translator::emit_implied() {
    const auto transfer = [&](Reg to, Reg from) {
        a_.move(to, from);
        set_nz(to);
    };
    const auto step = [&](Reg reg, bool up) {
        up ? a_.increment8(reg) : a_.decrement8(reg);
        set_nz(reg);
    };
    switch (at_->operation) {
        case TAX: transfer(kX, kA); break;
        case TAY: transfer(kY, kA); break;
        case TXA: transfer(kA, kX); break;
        case TYA: transfer(kA, kY); break;
        case INX: step(kX, true); break;
        case INY: step(kY, true); break;
        case DEX: step(kX, false); break;
        case DEY: step(kY, false); break;
        case CLD:
        case SED: {
            const bool on = at_->operation == SED;
            a_.store8(in_console(Offsets::decimal()), uint8_t{on});
            if (on) a_.alu8(Alu::or_, in_console(Offsets::modes()), uint8_t{8});
            else a_.alu8(Alu::and_, in_console(Offsets::modes()), uint8_t{0xf7});
            break;
        }
        case NOP: break;
        case CLC: a_.move(kCarry, uint32_t{0}); break;
        case SEC: a_.move(kCarry, uint32_t{1}); break;
        case CLV: a_.store8(in_console(Offsets::overflow()), uint8_t{0}); break;
        case TXS: a_.store8(in_console(Offsets::sp()), kX); break;
        case TSX:
            a_.load8(kX, in_console(Offsets::sp()));
            set_nz(kX);
            break;
        case PHA:
            a_.load8(r8, in_console(Offsets::sp()));
            a_.test8(r8, r8);
            a_.jump(If::not_sign, slow_);
            a_.store8(Mem{kRam, -0x80, r8}, kA);
            a_.decrement8(r8);
            a_.store8(in_console(Offsets::sp()), r8);
            break;
        case PLA:
            a_.load8(r8, in_console(Offsets::sp()));
            a_.address(r9, Mem{r8, -0x80});
            a_.alu(Alu::cmp, r9, 0x7f);
            a_.jump(If::not_below, slow_);
            a_.load8(kA, Mem{kRam, 1 - 0x80, r8});
            a_.increment8(r8);
            a_.store8(in_console(Offsets::sp()), r8);
            set_nz(kA);
            break;
        default: refuse();
    }
}

}  // namespace atari
