// Translated code of stores to RAM and to TIA registers. The latter have the effect of `Interpreter::write_tia`.
#include "offsets.hpp"
#include "translator.hpp"

namespace atari {
namespace {

// A number of cycles in a frame, times kInverse76 and shifted right by kInverseShift, is divided by the cycles of a
// line.
constexpr uint32_t kInverse76 = 55189, kInverseShift = 22;
constexpr bool divides_by_76() {
    for (uint32_t n = 0; n < 30000; ++n)
        if ((n * kInverse76) >> kInverseShift != n / kCyclesPerLine) return false;
    return true;
}
static_assert(divides_by_76());

// The byte of a register in the TIA's shadow.
Mem shadow(uint32_t reg) { return in_console(Offsets::shadow() + static_cast<int32_t>(reg)); }

Reg stored_by(Operation operation) { return operation == STX ? kX : operation == STY ? kY : kA; }

}  // namespace

void Translator::emit_store() {
    const Reg value = stored_by(at_->operation);
    switch (at_->operand) {
        case Operand::Ram:
        case Operand::RamA: a_.store8(in_ram(at_->given), value); break;
        case Operand::RamX:
        case Operand::RamY:
            indexed_ram();
            a_.store8(Mem{kRam, 0, t0}, value);
            break;
        case Operand::AnyX:
        case Operand::AnyY:
            a_.address(t0, Mem{index_of(at_->operand), at_->given});
            store_in_ram(value);
            break;
        case Operand::IndY:
            a_.load16(t0, in_ram(at_->given));
            a_.alu(Alu::add, t0, kY);
            store_in_ram(value);
            break;
        default: emit_tia_store(value);
    }
}

// Stores to the address in t0 if that is in RAM; otherwise jumps to the slow path.
void Translator::store_in_ram(Reg value) {
    a_.move(t1, t0);
    a_.alu(Alu::and_, t1, 0x1280);
    a_.compare(t1, 0x80);
    a_.jump(If::not_zero, slow_);
    a_.alu(Alu::and_, t0, 0x7f);
    a_.store8(Mem{kRam, 0, t0}, value);
}

// The deadline check: jumps to `past_deadline` if a TIA write `later` cycles after kCycles does not belong to this
// frame. Uses t0.
void Translator::check_deadline(int32_t later, JumpLabel& past_deadline) {
    if (later < Offsets::kDeadlines) {
        a_.compare(kCycles, in_console(Offsets::deadlines() + 4 * later));
    } else {
        a_.address(t0, Mem{kCycles, later});
        a_.compare(t0, in_console(Offsets::deadlines()));
    }
    a_.jump(If::not_below, past_deadline);
}

// Stores to a TIA register, with the effect of `Interpreter::write_tia`.
void Translator::emit_tia_store(Reg value) {
    const auto cost = static_cast<int32_t>(store_cost(at_->operand));
    const uint32_t reg = at_->given;
    write_at_ = cycles_ + cost;
    check_deadline(write_at_, slow_);
    switch (at_->operand) {
        case Operand::Tia:
        case Operand::TiaA: {
            a_.compare8(shadow(reg), value);
            const ShortJump same = a_.jump_short(If::zero);
            a_.store8(shadow(reg), value);
            append_write(value);
            a_.bind_short(same);
            break;
        }
        case Operand::Nusiz: {
            const Mem strobed = shadow(reg + (RESP0 - NUSIZ0));
            a_.compare8(shadow(reg), value);
            const ShortJump changed = a_.jump_short(If::not_zero);
            a_.compare8(strobed, uint8_t{0});
            const ShortJump acts = a_.jump_short(If::not_zero);
            a_.compare8(in_console(Offsets::ark()), uint8_t{0});
            const ShortJump same = a_.jump_short(If::zero);
            a_.bind_short(changed);
            a_.bind_short(acts);
            a_.store8(shadow(reg), value);
            a_.store8(strobed, uint8_t{0});
            append_write(value);
            a_.bind_short(same);
            break;
        }
        case Operand::Ctrlpf: {
            a_.load8(t1, shadow(reg));
            a_.load8(t2, in_console(Offsets::late_reflect()));
            a_.alu(Alu::xor_, t1, value);
            a_.or_and_test(t1, t2);  // bit 0 is the reflect bit
            const ShortJump same = a_.jump_short(If::zero);
            a_.store8(shadow(reg), value);
            a_.test(t1, uint32_t{kReflects});
            const ShortJump kept = a_.jump_short(If::zero);
            cycle_in_line(t2);
            a_.compare(t2, int32_t{kLateReflect});
            a_.set(If::not_below, t2);
            a_.store8(in_console(Offsets::late_reflect()), t2);
            a_.bind_short(kept);
            append_write(value);
            a_.test(t1, uint32_t{kShapesOfCtrlpf});
            const ShortJump shows = a_.jump_short(If::not_zero);
            a_.store8(in_log(Offsets::write_reg() - kWriteSize), uint8_t{PRIORITY});
            a_.bind_short(shows);
            a_.bind_short(same);
            break;
        }
        case Operand::Hmove: write_hmove(); break;
        case Operand::Strobe:
            a_.store8(shadow(reg), uint8_t{1});
            append_write(value);
            break;
        case Operand::Motion:
            if (reg == HMM0) {  // may be the Cosmic Ark effect
                a_.load8(t1, shadow(reg));
                a_.shift(ShiftDirection::right, t1, 4);
                a_.compare(t1, int32_t{kArkMotion});
                a_.jump(If::zero, slow_);
            }
            a_.store8(shadow(reg), value);
            break;
        case Operand::Grp0:
        case Operand::Grp0A:
        case Operand::Grp1:
        case Operand::Grp1A: write_graphics(value); break;
        case Operand::Sound: {
            a_.move(t1, value);
            a_.alu(Alu::and_, t1, int32_t{bits_of(static_cast<uint8_t>(reg))});
            a_.store8(in_console(Offsets::sound() + static_cast<int32_t>(reg - AUDC0)), t1);
            break;
        }
        case Operand::Hmclr:
            a_.store(shadow(HMP0), uint32_t{0});
            a_.store8(shadow(HMBL), uint8_t{0});
            break;
        default: wait_for_line();
    }
}

void Translator::wait_for_line() {
    a_.load(t1, in_console(Offsets::first_cycle()));
    a_.address(t0, Mem{kCycles, write_at_ + kCyclesPerLine - 1});
    a_.alu(Alu::sub, t0, t1);
    whole_lines(t0);
    a_.address(kCycles, Mem{t0, 0, t1});
}

// Rounds a number of cycles down to whole lines.
void Translator::whole_lines(Reg cycles) {
    a_.multiply(cycles, cycles, kInverse76);
    a_.shift(ShiftDirection::right, cycles, kInverseShift);
    a_.multiply(cycles, cycles, kCyclesPerLine);
}

// Computes the cycle in the line, `later` cycles after the write. Uses t3.
void Translator::cycle_in_line(Reg to, int32_t later) {
    a_.address(to, Mem{kCycles, write_at_ + later});
    a_.alu(Alu::sub, to, in_console(Offsets::first_cycle()));
    a_.move(t3, to);
    whole_lines(t3);
    a_.alu(Alu::sub, to, t3);
}

// A write to GRP0 or GRP1 also updates the delayed copy of the other; a write to GRP1 also updates that of ENABL.
void Translator::write_graphics(Reg value) {
    const bool first = at_->given == GRP0;
    const Mem mine = shadow(at_->given), other = shadow(first ? GRP1 : GRP0);
    const Mem old = in_console(first ? Offsets::old_grp1() : Offsets::old_grp0());
    a_.load8(t1, other);
    a_.compare8(mine, value);
    const ShortJump changed = a_.jump_short(If::not_zero);
    a_.compare8(old, t1);
    std::optional<ShortJump> ball_changed;
    if (!first) {
        ball_changed = a_.jump_short(If::not_zero);
        a_.load8(t2, shadow(ENABL));
        a_.compare8(in_console(Offsets::old_enabl()), t2);
    }
    const ShortJump same = a_.jump_short(If::zero);
    a_.bind_short(changed);
    if (ball_changed) a_.bind_short(*ball_changed);
    a_.store8(mine, value);
    a_.store8(old, t1);
    if (!first) {
        a_.load8(t2, shadow(ENABL));
        a_.store8(in_console(Offsets::old_enabl()), t2);
        a_.alu(Alu::and_, t2, int32_t{bits_of(ENABL)});
        a_.shift(ShiftDirection::left, t2, 7);
        a_.alu(Alu::or_, t1, t2);
    }
    append_write(value);
    a_.store16(in_log(Offsets::write_beside() - kWriteSize), t1);
    a_.bind_short(same);
}

// The log entry of HMOVE contains all motions. An HMOVE at an ordinary cycle that moves no object is logged as STILL.
void Translator::write_hmove() {
    a_.load(t1, shadow(HMP0));
    a_.load8(t2, shadow(HMBL));
    a_.move(t3, t1);
    a_.alu(Alu::or_, t3, t2);
    a_.test(t3, 0xf0f0f0f0u);
    const ShortJump moves = a_.jump_short(If::not_zero);
    cycle_in_line(t2, 1);
    a_.compare(t2, int32_t{kOrdinaryHmoveCycles});
    a_.move(t2, uint32_t{0});
    const ShortJump unusual = a_.jump_short(If::above);
    a_.address(t0, Mem{kCycles, write_at_});
    a_.store(in_log(Offsets::write_cycle()), t0);
    a_.store(in_log(Offsets::write_reg()), uint32_t{STILL});
    JumpLabel done;
    a_.jump(done);
    a_.bind_short(moves);
    a_.bind_short(unusual);
    a_.shift(ShiftDirection::right, t1, 4);
    a_.alu(Alu::and_, t1, 0x0f0f0f0f);
    for (const uint8_t bits : {4, 8}) {
        a_.move(t3, t1);
        a_.shift(ShiftDirection::right, t3, bits);
        a_.alu(Alu::or_, t1, t3);
        if (bits == 4) a_.alu(Alu::and_, t1, 0x00ff00ff);
    }
    a_.address(t0, Mem{kCycles, write_at_});
    a_.store(in_log(Offsets::write_cycle()), t0);
    a_.store8(in_log(Offsets::write_reg()), uint8_t{HMOVE});
    a_.shift(ShiftDirection::right, t2, 4);
    a_.store8(in_log(Offsets::write_value()), t2);
    a_.store16(in_log(Offsets::write_beside()), t1);
    a_.bind(done);
    a_.address64(kLog, in_log(kWriteSize));
}

// Appends the TIA write to the write log. Uses t0.
void Translator::append_write(Reg value) {
    a_.address(t0, Mem{kCycles, write_at_});
    a_.append(kLog, t0, static_cast<uint8_t>(at_->given), value);
}

}  // namespace atari
