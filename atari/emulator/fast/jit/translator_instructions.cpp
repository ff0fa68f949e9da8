// Translated code of each instruction but stores. It handles the likely case of the handler (handlers.hpp). In all
// other cases a slow path calls the handler, before anything has changed.
#include <stdexcept>

#include "offsets.hpp"
#include "translator.hpp"
#include "machine/cartridge/dpc.hpp"

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
    if (!slow_.has_jumps()) return;
    const auto what = is_jump(instruction.operation) ? SlowPath::kJumpByHandler : SlowPath::kHandler;
    slow_paths_.push_back(
        {slow_, what, instruction.place, before, instruction.cycles_after, instruction.entry.nz, {a_.here()}});
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
        a_.move(t0, static_cast<uint32_t>(at_->place));
        a_.call(skip_);
        return;
    }
    const Reg counter = instruction.loop == Loop::kCountX ? kX : kY;
    // Otherwise until the counter is past 0.
    const bool until_zero = kind_of(decoded_[at_->place + 1]).operation == BNE;
    std::optional<ShortJump> many;
    a_.move(t0, counter);
    if (until_zero) {
        a_.decrement8(t0);
    } else {
        a_.compare(counter, 0x80);
        many = a_.jump_short(If::above);
    }
    a_.multiply(t0, t0, instruction.taken);
    a_.alu(Alu::add, t0, kCycles);
    a_.compare(t0, in_console(Offsets::cycle_limit()));
    const ShortJump near_limit = a_.jump_short(If::not_below);
    a_.move(kCycles, t0);
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
            a_.test8(kNz);
            taken = at_->operation == BEQ ? If::zero : If::not_zero;
            break;
        case BPL:
        case BMI:
            a_.test(kNz, uint32_t{0x180});
            taken = at_->operation == BPL ? If::zero : If::not_zero;
            break;
        case BCC:
        case BCS:
            a_.test(kCarry);
            taken = at_->operation == BCC ? If::zero : If::not_zero;
            break;
        default:
            a_.compare8(in_console(Offsets::overflow()), uint8_t{0});
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
        a_.move(t0, static_cast<uint32_t>(at_->place));
        a_.jump(at_->operation == RTS ? return_ : at_->operation == JSR ? call_far_ : jump);
        return;
    }
    const std::size_t target = target_place(decoded_, at_->place);
    if (at_->operation == JSR) {
        a_.load8(t0, in_console(Offsets::sp()));
        a_.compare(t0, 0x81);
        a_.jump(If::below, slow_);
    }
    a_.load(t1, in_console(Offsets::origin()));  // the likely target is in the same 4 KiB
    a_.move(t2, t1);
    a_.alu(Alu::xor_, t2, int32_t{at_->given});
    a_.test(t2, uint32_t{0xf000});
    a_.jump(If::not_zero, slow_);
    if (at_->operation == JSR) {
        a_.load64(t2, in_console(Offsets::first_instruction()));
        a_.alu64(Alu::sub, t2, in_console(Offsets::base_instruction()));
        a_.shift(ShiftDirection::right, t2, kInstructionShift);
        a_.address(t1, Mem{t1, static_cast<int32_t>(at_->place + 2), t2});
        a_.store16(Mem{kRam, -0x81, t0}, t1);
        a_.alu8(Alu::sub, in_console(Offsets::sp()), uint8_t{2});
    }
    go_to(target, cycles_ + (at_->operation == JSR ? 6 : 3), target <= at_->place);
}

// --- reads ---

// Adds the cycle of a page crossing.
void Translator::add_page_crossing(Reg index) {
    if (!(at_->given & 0xff)) return;
    a_.compare8(index, static_cast<uint8_t>(-at_->given));
    a_.increment_if_not_below(kCycles);
}

// Returns the byte at the address in t1, if it can be read without side effects.
Byte Translator::paged() {
    a_.extract(t2, t1, 6, 8);
    a_.load64(t3, Mem{kConsole, Offsets::pages(), t2, 8});
    a_.test64(t3);
    a_.jump(If::zero, slow_);
    a_.alu(Alu::and_, t1, 63);
    return {{}, Mem{t3, 0, t1}, t0};
}

// Reads a register of the DPC chip, as `read_dpc` does. Handlers read those that depend on music.
Byte Translator::dpc() {
    const int function = at_->given >> 3 & 7, fetcher = at_->given & 7;
    const Mem flag = in_console(Offsets::dpc_flag() + fetcher), random = in_console(Offsets::dpc_random());
    const Mem counter = in_console(Offsets::dpc_counter() + 2 * fetcher);
    const bool reads_data = function == 1 || function == 2;
    if (!(reads_data && fetcher < 5) && !(function == 0 && fetcher < 4)) {
        a_.jump(slow_);
        return {uint8_t{0}, {}, t0};
    }
    a_.load8(t0, random);
    a_.move64(t1, reinterpret_cast<uintptr_t>(kDpcRandom.data()));
    a_.load8(t0, Mem{t1, 0, t0});
    a_.store8(random, t0);
    a_.load16(t1, counter);
    const auto set_flag_at = [&](int limit, uint8_t value) {
        a_.compare8(in_console(limit + fetcher), t1);
        const ShortJump elsewhere = a_.jump_short(If::not_zero);
        a_.store8(flag, value);
        a_.bind_short(elsewhere);
    };
    set_flag_at(Offsets::dpc_bottom(), 0);
    set_flag_at(Offsets::dpc_top(), 0xff);  // has the last word if both agree
    if (reads_data) {
        a_.load64(t0, in_console(Offsets::image()));
        a_.alu64(Alu::sub, t0, t1);
        a_.load8(t0, Mem{t0, 8192 + 2047});
    }
    a_.alu(Alu::sub, t1, 1);
    a_.alu(Alu::and_, t1, 0x7ff);
    a_.store16(counter, t1);
    if (function == 2) a_.alu8(Alu::and_, t0, flag);
    return {{}, {}, t0};
}

void Translator::emit_read() {
    if (at_->operation == ADC || at_->operation == SBC) {
        a_.compare8(in_console(Offsets::decimal()), uint8_t{0});
        a_.jump(If::not_zero, slow_);
    }
    const auto cost = static_cast<int32_t>(read_cost(at_->operand));
    Byte source{{}, {}, t0};
    switch (at_->operand) {
        case Operand::Imm:
        case Operand::Fixed: source.constant = static_cast<uint8_t>(at_->given); break;
        case Operand::Ram:
        case Operand::RamA: source.memory = in_ram(at_->given); break;
        case Operand::RamX:
        case Operand::RamY:
            indexed_ram();
            source.memory = Mem{kRam, 0, t0};
            break;
        case Operand::Input:
            a_.address(t0, Mem{kCycles, cycles_ + cost});
            a_.set_bit_7_if_reached(t0, t0, in_console(Offsets::inputs() + 8 * (at_->given & 7)));
            a_.alu(Alu::or_, t0, at_->given & 0x3f);
            break;
        case Operand::RomX:
        case Operand::RomY: {
            const Reg index = index_of(at_->operand);
            a_.load64(t1, in_console(Offsets::bank()));
            add_page_crossing(index);
            source.memory = Mem{t1, at_->given, index};
            break;
        }
        case Operand::Timer: {
            // The timer's value, as long as the timer has not expired.
            a_.address(t0, Mem{kCycles, cycles_ + cost - 1});
            a_.alu(Alu::sub, t0, in_console(Offsets::timer_set_at()));
            a_.shift_right_by(t0, in_console(Offsets::timer_shift()), t1);
            a_.load8(t1, in_console(Offsets::timer()));
            a_.subtract_and_compare(t1, t0);
            a_.jump(If::not_above, slow_);
            a_.address(t0, Mem{t1, -1});
            break;
        }
        case Operand::Dpc: source = dpc(); break;
        case Operand::AnyX:
        case Operand::AnyY:
            a_.address(t1, Mem{index_of(at_->operand), at_->given});
            source = paged();
            add_page_crossing(index_of(at_->operand));
            break;
        case Operand::IndY:
            a_.load16(t0, in_ram(at_->given));
            a_.address(t1, Mem{t0, 0, kY});
            source = paged();
            a_.add_carry_of(kCycles, t0, kY);  // the cycle of a page crossing
            break;
        default: refuse();
    }
    operate(source);
}

// Loads the offset in RAM of an indexed operand into t0.
void Translator::indexed_ram() {
    a_.move(t0, index_of(at_->operand));
    a_.add8_and_test(t0, static_cast<uint8_t>(at_->given - 0x80));
    a_.jump(If::sign, slow_);
}

void Translator::set_nz(Reg of) {
    if (!at_->omits_nz) a_.move(kNz, of);
}

void Translator::operate(const Byte& source) {
    switch (at_->operation) {
        case LDA:
        case LDX:
        case LDY: {
            const Reg to = at_->operation == LDA ? kA : at_->operation == LDX ? kX : kY;
            a_.load8(to, source);
            set_nz(to);
            break;
        }
        case AND:
        case ORA:
        case EOR:
            a_.alu8(at_->operation == AND ? Alu::and_ : at_->operation == ORA ? Alu::or_ : Alu::xor_, kA, source);
            set_nz(kA);
            break;
        case CMP:
        case CPX:
        case CPY:
            a_.move(kNz, at_->operation == CMP ? kA : at_->operation == CPX ? kX : kY);
            a_.subtract8(kNz, source, kCarry);
            break;
        case BIT:
            a_.load8(t0, source);
            a_.address(t1, Mem{t0, 0, t0});
            a_.alu(Alu::and_, t1, 0x180);
            a_.store8(in_console(Offsets::overflow()), t1);
            a_.alu(Alu::and_, t1, 0x100);
            a_.move(kNz, kA);
            a_.alu(Alu::and_, kNz, t0);
            a_.alu(Alu::or_, kNz, t1);
            break;
        case ADC:
            a_.add_with_carry(kA, source, kCarry, in_console(Offsets::overflow()), at_->entry.carry.has_value());
            set_nz(kA);
            break;
        default:  // SBC
            a_.subtract_with_carry(kA, source, kCarry, in_console(Offsets::overflow()), at_->entry.carry.has_value());
            set_nz(kA);
    }
}

// --- the rest ---

void Translator::emit_modify() {
    Reg value = t1;
    Mem memory = in_ram(at_->given);
    switch (at_->operand) {
        case Operand::Acc: value = kA; break;
        case Operand::Ram: break;
        case Operand::RamX:
            indexed_ram();
            memory = Mem{kRam, 0, t0};
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
            a_.address(t2, Mem{kCarry, 0, value, 2});
            a_.move(kCarry, value);
            a_.shift(ShiftDirection::right, kCarry, 7);
            a_.extend8(value, t2);
            break;
        default:  // ROR
            a_.move(t2, kCarry);
            a_.shift(ShiftDirection::left, t2, 7);
            a_.move(kCarry, value);
            a_.alu(Alu::and_, kCarry, 1);
            a_.shift(ShiftDirection::right, value, 1);
            a_.alu(Alu::or_, value, t2);
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
            a_.load8(t0, in_console(Offsets::sp()));
            a_.test8(t0);
            a_.jump(If::not_sign, slow_);
            a_.store8(Mem{kRam, -0x80, t0}, kA);
            a_.decrement8(t0);
            a_.store8(in_console(Offsets::sp()), t0);
            break;
        case PLA:
            a_.load8(t0, in_console(Offsets::sp()));
            a_.address(t1, Mem{t0, -0x80});
            a_.compare(t1, 0x7f);
            a_.jump(If::not_below, slow_);
            a_.load8(kA, Mem{kRam, 1 - 0x80, t0});
            a_.increment8(t0);
            a_.store8(in_console(Offsets::sp()), t0);
            set_nz(kA);
            break;
        default: refuse();
    }
}

}  // namespace atari
