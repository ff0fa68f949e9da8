// Machine code for stores: to RAM, and to registers of the TIA as `FastCpu::write_tia` does it.
#include "places.hpp"
#include "translator.hpp"

namespace atari {
namespace {

// Multiplied by this and shifted by so many bits, a number of cycles in a frame is divided by the 76 of a line.
constexpr uint32_t kInverse76 = 55189, kInverseShift = 22;
constexpr bool divides_by_76() {
    for (uint32_t n = 0; n < 30000; ++n)
        if ((n * kInverse76) >> kInverseShift != n / 76) return false;
    return true;
}
static_assert(divides_by_76());

// What was last written to a register of the TIA.
Mem written(uint32_t reg) { return in_console(Places::written() + static_cast<int32_t>(reg)); }

// The cycles of an instruction, at most; 0 where that is not known, as it may jump, or write to a port.
constexpr uint32_t most_cycles(Kind kind) {
    const auto [operation, operand] = kind;
    const bool in_ram = operand == Operand::Ram || operand == Operand::RamA;
    if (is_store(operation)) return in_ram || (operand >= Operand::Tia && is_stored_here(operand)) ? store_cost(operand) : 0;
    if (is_modify(operation)) return in_ram || operand == Operand::Acc ? modify_cost(operand) : 0;
    if (is_read(operation)) return read_cost(operand) + 1;
    const bool on_stack = operation == PHA || operation == PHP || operation == PLA || operation == PLP || operation == RTS;
    return operand == Operand::Imp && !on_stack ? 2 : 0;
}

Reg stored_by(Operation operation) { return operation == STX ? kX : operation == STY ? kY : kA; }

}  // namespace

bool Translator::emit_store() {
    if (!is_stored_here(operand_)) return false;
    const Reg value = stored_by(operation_);
    switch (operand_) {
        case Operand::Ram: case Operand::RamA:
            a_.store8(in_ram(given_), value);
            break;
        case Operand::RamX: case Operand::RamY:
            indexed_ram();
            a_.store8(Mem{kRam, 0, r8}, value);
            break;
        case Operand::AnyX: case Operand::AnyY:
            a_.address(r8, Mem{index_of(operand_), given_});
            store_in_ram(value);
            break;
        case Operand::IndY:
            a_.load16(r8, in_ram(given_));
            a_.alu(Alu::add, r8, kY);
            store_in_ram(value);
            break;
        default:
            emit_tia_store(value);
            return true;
    }
    pending_ += static_cast<int32_t>(store_cost(operand_));
    return true;
}

// To the address in r8.
void Translator::store_in_ram(Reg value) {
    a_.move(r9, r8);
    a_.alu(Alu::and_, r9, 0x1280);
    a_.alu(Alu::cmp, r9, 0x80);
    a_.jump(If::not_zero, slow_);
    a_.alu(Alu::and_, r8, 0x7f);
    a_.store8(Mem{kRam, 0, r8}, value);
}

// That a write so much later does not end the frame.
void Translator::emit_check_of_time(int32_t later, Label& late) {
    a_.address(r8, Mem{kCycles, later});
    a_.alu(Alu::cmp, r8, kOverlong);
    a_.jump(If::not_below, late);
}

// Asks once for a straight line of writes, as far as their cycles are known. Where one might be too late handlers run all.
void Translator::look_ahead_for_writes() {
    if (place_ <= in_time_until_) return;
    checked_at_ = place_;
    uint32_t cycles = 0, latest = 0;
    std::size_t place = place_;
    do {
        const Kind kind = kind_of(records_[place]);
        const uint32_t cost = most_cycles(kind);
        if (!cost) break;
        cycles += cost;
        if (is_store(kind.operation) && kind.operand >= Operand::Tia) {
            in_time_until_ = place;
            latest = cycles;
        }
        if (kind.operand == Operand::Wsync) break;
        place = next_of(place);
    } while (follows(place));
    emit_check_of_time(pending_ + static_cast<int32_t>(latest), slow_);
    for (place = place_; place < in_time_until_; until_write_[place] = static_cast<uint16_t>(latest)) {
        latest -= most_cycles(kind_of(records_[place]));
        place = next_of(place);
    }
}

// To the TIA: what `FastCpu::write_tia` does.
void Translator::emit_tia_store(Reg value) {
    const auto cost = static_cast<int32_t>(store_cost(operand_));
    const uint32_t reg = given_;
    look_ahead_for_writes();
    written_at_ = pending_ + cost;
    switch (operand_) {
        case Operand::Tia: case Operand::TiaA: {
            a_.alu8(Alu::cmp, written(reg), value);
            const std::size_t same = a_.jump_short(If::zero);
            a_.store8(written(reg), value);
            keep(value);
            a_.bind_short(same);
            break;
        }
        case Operand::Nusiz: {
            const Mem strobed = written(reg + (RESP0 - NUSIZ0));
            a_.alu8(Alu::cmp, written(reg), value);
            const std::size_t changed = a_.jump_short(If::not_zero);
            a_.alu8(Alu::cmp, strobed, uint8_t{0});
            const std::size_t acts = a_.jump_short(If::not_zero);
            a_.alu8(Alu::cmp, in_console(Places::ark()), uint8_t{0});
            const std::size_t same = a_.jump_short(If::zero);
            a_.bind_short(changed);
            a_.bind_short(acts);
            a_.store8(written(reg), value);
            a_.store8(strobed, uint8_t{0});
            keep(value);
            a_.bind_short(same);
            break;
        }
        case Operand::Ctrlpf: {
            a_.load8(r9, written(reg));
            a_.load8(r10, in_console(Places::mirror_waits()));
            a_.alu(Alu::xor_, r9, value);
            a_.alu(Alu::or_, r9, r10);  // bit 0 is the mirroring
            const std::size_t same = a_.jump_short(If::zero);
            a_.store8(written(reg), value);
            a_.test(r9, uint32_t{1});
            const std::size_t kept = a_.jump_short(If::zero);
            cycle_in_line(r10);
            a_.alu(Alu::cmp, r10, int32_t{kMirrorsAtOnce});
            a_.set(If::not_below, r10);
            a_.store8(in_console(Places::mirror_waits()), r10);
            a_.bind_short(kept);
            keep(value);
            a_.test(r9, uint32_t{0x31});
            const std::size_t shows = a_.jump_short(If::not_zero);
            a_.store8(Mem{kLog, -4}, uint8_t{PRIORITY});
            a_.bind_short(shows);
            a_.bind_short(same);
            break;
        }
        case Operand::Hmove:
            write_hmove();
            break;
        case Operand::Strobe:
            a_.store8(written(reg), uint8_t{1});
            keep(value);
            break;
        case Operand::Motion:
            if (reg == HMM0) {  // perhaps Cosmic Ark's trick
                a_.load8(r9, written(reg));
                a_.shift(Shift::right, r9, 4);
                a_.alu(Alu::cmp, r9, 7);
                a_.jump(If::zero, slow_);
            }
            a_.store8(written(reg), value);
            break;
        case Operand::Grp0: case Operand::Grp0A: case Operand::Grp1: case Operand::Grp1A:
            write_graphics(value);
            break;
        case Operand::Sound: {
            static constexpr uint8_t kMasks[3] = {15, 31, 15};
            a_.move(r9, value);
            a_.alu(Alu::and_, r9, int32_t{kMasks[(reg - AUDC0) / 2]});
            a_.store8(in_console(Places::sound() + static_cast<int32_t>(reg - AUDC0)), r9);
            break;
        }
        case Operand::Hmclr:
            a_.store(written(HMP0), uint32_t{0});
            a_.store8(written(HMBL), uint8_t{0});
            break;
        default:
            return wait_for_line();
    }
    pending_ += cost;
}

void Translator::wait_for_line() {
    a_.load(r9, in_console(Places::first_cycle()));
    a_.address(r8, Mem{kCycles, written_at_ + 75});
    a_.alu(Alu::sub, r8, r9);
    whole_lines(r8);
    a_.address(kCycles, Mem{r8, 0, r9});
    pending_ = 0;
}

// Of a number of cycles, those of its whole lines.
void Translator::whole_lines(Reg cycles) {
    a_.multiply(cycles, cycles, kInverse76);
    a_.shift(Shift::right, cycles, kInverseShift);
    a_.multiply(cycles, cycles, 76);
}

// The place in its line of a cycle so much later than the write. Uses r11.
void Translator::cycle_in_line(Reg to, int32_t later) {
    a_.address(to, Mem{kCycles, written_at_ + later});
    a_.alu(Alu::sub, to, in_console(Places::first_cycle()));
    a_.move(r11, to);
    whole_lines(r11);
    a_.alu(Alu::sub, to, r11);
}

// GRP0 and GRP1 also renew the delayed copy of the other, and GRP1 that of ENABL.
void Translator::write_graphics(Reg value) {
    const bool first = given_ == GRP0;
    const Mem mine = written(given_), other = written(first ? GRP1 : GRP0);
    const Mem old = in_console(first ? Places::old_grp1() : Places::old_grp0());
    a_.load8(r9, other);
    a_.alu8(Alu::cmp, mine, value);
    const std::size_t changed = a_.jump_short(If::not_zero);
    a_.alu8(Alu::cmp, old, r9);
    std::size_t ball_changed = 0;
    if (!first) {
        ball_changed = a_.jump_short(If::not_zero);
        a_.load8(r10, written(ENABL));
        a_.alu8(Alu::cmp, in_console(Places::old_enabl()), r10);
    }
    const std::size_t same = a_.jump_short(If::zero);
    a_.bind_short(changed);
    if (ball_changed) a_.bind_short(ball_changed);
    a_.store8(mine, value);
    a_.store8(old, r9);
    if (!first) {
        a_.load8(r10, written(ENABL));
        a_.store8(in_console(Places::old_enabl()), r10);
        a_.alu(Alu::and_, r10, 2);
        a_.shift(Shift::left, r10, 7);
        a_.alu(Alu::or_, r9, r10);
    }
    keep(value);
    a_.store16(Mem{kLog, -2}, r9);
    a_.bind_short(same);
}

// HMOVE brings the motions along. Where it moves nothing and is in time, it only shows that nothing moves.
void Translator::write_hmove() {
    a_.address(r8, Mem{kCycles, written_at_});
    a_.load(r9, written(HMP0));
    a_.load8(r10, written(HMBL));
    a_.move(r11, r9);
    a_.alu(Alu::or_, r11, r10);
    a_.test(r11, 0xf0f0f0f0u);
    const std::size_t moves = a_.jump_short(If::not_zero);
    cycle_in_line(r10, 1);
    a_.alu(Alu::cmp, r10, 4);
    a_.move(r10, uint32_t{0});
    const std::size_t late = a_.jump_short(If::above);
    a_.store(Mem{kLog}, r8);
    a_.store(Mem{kLog, 4}, uint32_t{STILL});
    Label done;
    a_.jump(done);
    a_.bind_short(moves);
    a_.bind_short(late);
    a_.shift(Shift::right, r9, 4);
    a_.alu(Alu::and_, r9, 0x0f0f0f0f);
    a_.move(r11, r9);
    a_.shift(Shift::right, r11, 4);
    a_.alu(Alu::or_, r9, r11);
    a_.alu(Alu::and_, r9, 0x00ff00ff);
    a_.move(r11, r9);
    a_.shift(Shift::right, r11, 8);
    a_.alu(Alu::or_, r9, r11);
    a_.store(Mem{kLog}, r8);
    a_.store8(Mem{kLog, 4}, uint8_t{HMOVE});
    a_.shift(Shift::right, r10, 4);
    a_.store8(Mem{kLog, 5}, r10);
    a_.store16(Mem{kLog, 6}, r9);
    a_.bind(done);
    a_.address64(kLog, Mem{kLog, 8});
}

// In the log.
void Translator::keep(Reg value) {
    a_.address(r8, Mem{kCycles, written_at_});
    a_.store(Mem{kLog}, r8);
    a_.store(Mem{kLog, 4}, uint32_t{given_});
    a_.store8(Mem{kLog, 5}, value);
    a_.address64(kLog, Mem{kLog, 8});
}

}  // namespace atari
