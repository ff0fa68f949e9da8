// Machine code for each instruction, but for stores: what its handler (handlers.hpp) does in the likely case. All others it
// leaves to the handler, before it has changed anything.
#include "places.hpp"
#include "translator.hpp"

namespace atari {
namespace {

constexpr bool sets_nz(int op) {
    return is_read(op) || is_modify(op) || op == TAX || op == TAY || op == TXA || op == TYA || op == TSX || op == INX ||
           op == INY || op == DEX || op == DEY || op == PLA;
}

// Whether machine code does this without asking for N and Z, or changing them.
constexpr bool leaves_nz(Kind kind) {
    if (is_store(kind.operation)) return is_stored_here(kind.operand);
    const int op = kind.operation;
    return op == CLC || op == SEC || op == CLV || op == CLD || op == SED || op == NOP || op == TXS || op == PHA;
}

constexpr bool changes_carry(int op) {
    return op == ADC || op == SBC || op == CMP || op == CPX || op == CPY || op == PLP || is_modify(op);
}

}  // namespace

void Translator::emit() {
    if (records_[place_].handler == kLoop) skip_rounds();
    slow_ = {};
    const int32_t before = pending_;
    const bool jumps = operation_ == JMP || operation_ == JSR || operation_ == RTS;
    if (nz_in_ && sets_nz(operation_)) nz_in_.reset();
    if (nz_in_) assume_from(place_);
    const std::optional<Reg> nz_in = nz_in_;
    const bool done = operand_ == Operand::Rel ? emit_branch()
                      : jumps                  ? emit_jump()
                      : is_read(operation_)    ? emit_read()
                      : is_store(operation_)   ? emit_store()
                      : is_modify(operation_)  ? emit_modify()
                                               : emit_implied();
    if (!done) {
        add_pending();
        call_handler(place_);
        if (jumps) a_.jump(dispatch_);
    }
    if (jumps || operand_ == Operand::Rel || changes_carry(operation_)) carry_.reset();
    if (slow_.last_jump < 0) return;
    const bool checked = checked_at_ == place_ && in_time_until_ > place_;
    const auto what = jumps ? Aside::kJumpByHandler : checked ? Aside::kEnterBehind : Aside::kHandler;
    asides_.push_back({slow_, what, place_, before, pending_, nz_in, {static_cast<int32_t>(a_.size())}});
}

// At a loop that only waits, counts or divides: all rounds but the last, as `FastCpu::skip_rounds` does, which is called
// but for those that count.
void Translator::skip_rounds() {
    add_pending();
    const Record& record = records_[place_];
    if (record.loop != Loop::kCountX && record.loop != Loop::kCountY) {
        a_.move(r8, static_cast<uint32_t>(place_));
        a_.call(skip_);
        return;
    }
    const Reg counter = record.loop == Loop::kCountX ? kX : kY;
    const bool until_zero = kind_of(records_[place_ + 1]).operation == BNE;  // otherwise until it is past that
    std::size_t many = 0;
    a_.move(r8, counter);
    if (until_zero) {
        a_.decrement8(r8);
    } else {
        a_.alu(Alu::cmp, counter, 0x80);
        many = a_.jump_short(If::above);
    }
    a_.multiply(r8, r8, record.taken);
    a_.alu(Alu::add, r8, kCycles);
    a_.alu(Alu::cmp, r8, in_console(Places::cycle_limit()));
    const std::size_t near_limit = a_.jump_short(If::not_below);
    a_.move(kCycles, r8);
    a_.move(counter, uint32_t{until_zero});
    a_.bind_short(near_limit);
    if (many) a_.bind_short(many);
}

// --- jumps ---

bool Translator::emit_branch() {
    const std::size_t target = target_of(place_);
    const bool backward = target <= place_;
    If taken = If::zero;
    switch (operation_) {
        case BNE: case BEQ:
            a_.test8(kNz, kNz);
            taken = operation_ == BEQ ? If::zero : If::not_zero;
            break;
        case BPL: case BMI:
            a_.test(kNz, uint32_t{0x180});
            taken = operation_ == BPL ? If::zero : If::not_zero;
            break;
        case BCC: case BCS:
            a_.test(kCarry, kCarry);
            taken = operation_ == BCC ? If::zero : If::not_zero;
            break;
        default:
            a_.alu8(Alu::cmp, in_console(Places::overflow()), uint8_t{0});
            taken = operation_ == BVC ? If::zero : If::not_zero;
    }
    const int32_t before = pending_, cost = records_[place_].taken;
    if (backward) {
        Label otherwise;
        a_.jump(opposite(taken), otherwise);
        pending_ = before + cost;
        go_to(target, true);
        a_.bind(otherwise);
    } else {
        asides_.push_back({{}, Aside::kBranch, target, before + cost, 0, {}, {}});
        a_.jump(taken, asides_.back().from);
    }
    pending_ = before + 2;
    return true;
}

bool Translator::emit_jump() {
    if (operand_ != Operand::Near) {
        Label& jump = operand_ == Operand::Ind ? jump_indirect_ : jump_far_;
        add_pending();
        a_.move(r8, static_cast<uint32_t>(place_));
        a_.jump(operation_ == RTS ? return_ : operation_ == JSR ? call_far_ : jump);
        return true;
    }
    const std::size_t target = target_of(place_);
    if (operation_ == JSR) {
        a_.load8(r8, in_console(Places::sp()));
        a_.alu(Alu::cmp, r8, 0x81);
        a_.jump(If::below, slow_);
    }
    a_.load(r9, in_console(Places::origin()));  // in the same 4 KiB
    a_.move(r10, r9);
    a_.alu(Alu::xor_, r10, int32_t{given_});
    a_.test(r10, uint32_t{0xf000});
    a_.jump(If::not_zero, slow_);
    if (operation_ == JSR) {
        a_.load64(r10, in_console(Places::first_record()));
        a_.alu64(Alu::sub, r10, in_console(Places::base_record()));
        a_.shift(Shift::right, r10, 4);
        a_.address(r9, Mem{r9, static_cast<int32_t>(place_ + 2), r10});
        a_.store16(Mem{kRam, -0x81, r8}, r9);
        a_.alu8(Alu::sub, in_console(Places::sp()), uint8_t{2});
    }
    pending_ += operation_ == JSR ? 6 : 3;
    go_to(target, target <= place_);
    return true;
}

// --- reads ---

// Where an index to the instruction's address crosses a page, a cycle more.
void Translator::add_page_crossing(Reg index) {
    if (!(given_ & 0xff)) return;
    a_.alu8(Alu::cmp, index, static_cast<uint8_t>(-given_));  // a borrow where it does not
    a_.alu(Alu::sbb, kCycles, -1);
}

// A byte at the address in r9, if it can be read without effect.
Translator::Source Translator::paged() {
    a_.move(r10, r9);
    a_.shift(Shift::right, r10, 6);
    a_.extend8(r10, r10);
    a_.load64(r11, Mem{kConsole, Places::pages(), r10, 8});
    a_.test64(r11, r11);
    a_.jump(If::zero, slow_);
    a_.alu(Alu::and_, r9, 63);
    return {{}, Mem{r11, 0, r9}, r8};
}

bool Translator::emit_read() {
    if (operation_ == ADC || operation_ == SBC) {
        a_.alu8(Alu::cmp, in_console(Places::decimal()), uint8_t{0});
        a_.jump(If::not_zero, slow_);
    }
    const auto cost = static_cast<int32_t>(read_cost(operand_));
    Source source{{}, {}, r8};
    switch (operand_) {
        case Operand::Imm: case Operand::Fixed:
            source.constant = static_cast<uint8_t>(given_);
            break;
        case Operand::Ram: case Operand::RamA:
            source.memory = in_ram(given_);
            break;
        case Operand::RamX: case Operand::RamY:
            indexed_ram();
            source.memory = Mem{kRam, 0, r8};
            break;
        case Operand::Input:
            a_.address(r8, Mem{kCycles, pending_ + cost});
            a_.alu64(Alu::cmp, r8, in_console(Places::inputs() + 8 * (given_ & 7)));
            a_.alu(Alu::sbb, r8, r8);
            a_.alu(Alu::and_, r8, -0x80);
            a_.alu(Alu::add, r8, 0x80);
            a_.alu(Alu::or_, r8, given_ & 0x3f);
            break;
        case Operand::RomX: case Operand::RomY: {
            const Reg index = index_of(operand_);
            a_.load64(r9, in_console(Places::bank()));
            add_page_crossing(index);
            source.memory = Mem{r9, given_, index};
            break;
        }
        case Operand::Timer: {
            // Its value, until it has run out.
            a_.address(r8, Mem{kCycles, pending_ + cost - 1});
            a_.alu(Alu::sub, r8, in_console(Places::timer_set_at()));
            a_.move(r9, kX);
            a_.load8(rcx, in_console(Places::timer_shift()));
            a_.shift_by_cl(Shift::right, r8);
            a_.move(kX, r9);
            a_.load8(r9, in_console(Places::timer()));
            a_.alu(Alu::sub, r9, r8);
            a_.jump(If::not_above, slow_);
            a_.address(r8, Mem{r9, -1});
            break;
        }
        case Operand::Dpc:
            if (!read_fetcher()) return false;
            break;
        case Operand::AnyX: case Operand::AnyY:
            a_.address(r9, Mem{index_of(operand_), given_});
            source = paged();
            add_page_crossing(index_of(operand_));
            break;
        case Operand::IndY:
            a_.load16(r8, in_ram(given_));
            a_.address(r9, Mem{r8, 0, kY});
            source = paged();
            a_.alu8(Alu::add, r8, kY);  // a carry where this crosses a page
            a_.alu(Alu::adc, kCycles, 0);
            break;
        default:
            return false;
    }
    pending_ += cost;
    operate(source);
    return true;
}

// A data fetcher of the DPC chip, into r8, as `Console::read_fetcher` does. False for those that make music or do nothing.
bool Translator::read_fetcher() {
    const int32_t i = given_ & 7, function = given_ >> 3 & 7;
    if (i >= 5 || (function == 0 && i == 4) || (function >= 3 && function != 7)) return false;
    const Mem random = in_console(Places::dpc_random()), counter = in_console(Places::dpc_counters() + 2 * i);
    const Mem flag = in_console(Places::dpc_flags() + i);
    a_.load8(r8, random);
    a_.move64(r9, reinterpret_cast<uintptr_t>(kDpcRandom.data()));
    a_.load8(r8, Mem{r9, 0, r8});
    a_.store8(random, r8);

    a_.load16(r9, counter);
    a_.move(r10, uint32_t{0xff});
    a_.alu8(Alu::cmp, r9, in_console(Places::dpc_tops() + i));
    const std::size_t top = a_.jump_short(If::zero);
    a_.move(r10, uint32_t{0});
    a_.alu8(Alu::cmp, r9, in_console(Places::dpc_bottoms() + i));
    const std::size_t neither = a_.jump_short(If::not_zero);
    a_.bind_short(top);
    a_.store8(flag, r10);
    a_.bind_short(neither);
    a_.address(r10, Mem{r9, -1});
    a_.alu(Alu::and_, r10, 0x7ff);
    a_.store16(counter, r10);

    if (function == 7) a_.load8(r8, flag);
    if (function == 1 || function == 2) {
        a_.load64(r10, in_console(Places::image()));
        a_.alu64(Alu::sub, r10, r9);
        a_.load8(r8, Mem{r10, 8192 + 2047});
    }
    if (function == 2) a_.alu8(Alu::and_, r8, flag);
    return true;
}

// A place in RAM by an index, in r8.
void Translator::indexed_ram() {
    a_.move(r8, index_of(operand_));
    a_.alu8(Alu::add, r8, static_cast<uint8_t>(given_ - 0x80));
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

// N and Z are those of A, X or Y. Where they are replaced before anybody asks for them, that is left out; a handler that is
// called meanwhile gets them.
void Translator::set_nz(Reg of) {
    if (replaces_nz_next()) nz_in_ = of;
    else a_.move(kNz, of);
}

bool Translator::replaces_nz_next() const {
    for (std::size_t place = next_of(place_);; place = next_of(place)) {
        if (!follows(place)) return false;
        const Kind kind = kind_of(records_[place]);
        if (sets_nz(kind.operation)) return true;
        if (!leaves_nz(kind)) return false;
    }
}

void Translator::operate(const Source& source) {
    switch (operation_) {
        case LDA: case LDX: case LDY: {
            const Reg to = operation_ == LDA ? kA : operation_ == LDX ? kX : kY;
            read_into(to, source);
            set_nz(to);
            break;
        }
        case AND: case ORA: case EOR:
            combine(operation_ == AND ? Alu::and_ : operation_ == ORA ? Alu::or_ : Alu::xor_, kA, source);
            set_nz(kA);
            break;
        case CMP: case CPX: case CPY:
            a_.move(kNz, operation_ == CMP ? kA : operation_ == CPX ? kX : kY);
            combine(Alu::sub, kNz, source);
            a_.set(If::not_below, kCarry);
            break;
        case BIT:
            read_into(r8, source);
            a_.address(r9, Mem{r8, 0, r8});
            a_.alu(Alu::and_, r9, 0x180);
            a_.store8(in_console(Places::overflow()), r9);
            a_.alu(Alu::and_, r9, 0x100);
            a_.move(kNz, kA);
            a_.alu(Alu::and_, kNz, r8);
            a_.alu(Alu::or_, kNz, r9);
            break;
        default: {  // ADC and SBC. This processor's carry is a borrow in subtractions.
            const bool adds = operation_ == ADC;
            const bool without = carry_ && carry_->is_set != adds;  // a carry, or a borrow
            if (without) assume_from(next_of(carry_->since));
            else if (adds) a_.test_bit(kCarry, uint8_t{0});
            else a_.alu(Alu::cmp, kCarry, 1);
            combine(adds ? without ? Alu::add : Alu::adc : without ? Alu::sub : Alu::sbb, kA, source);
            a_.set(adds ? If::below : If::not_below, kCarry);
            a_.set8(If::overflow, in_console(Places::overflow()));
            set_nz(kA);
        }
    }
}

// --- the rest ---

bool Translator::emit_modify() {
    Reg value = r9;
    Mem memory = in_ram(given_);
    switch (operand_) {
        case Operand::Acc: value = kA; break;
        case Operand::Ram: break;
        case Operand::RamX:
            indexed_ram();
            memory = Mem{kRam, 0, r8};
            break;
        default: return false;
    }
    if (operand_ != Operand::Acc) a_.load8(value, memory);
    switch (operation_) {
        case INC: a_.increment8(value); break;
        case DEC: a_.decrement8(value); break;
        case ASL: case LSR:
            a_.move(kCarry, value);
            if (operation_ == ASL) a_.shift(Shift::right, kCarry, 7);
            else a_.alu(Alu::and_, kCarry, 1);
            a_.shift(operation_ == ASL ? Shift::left : Shift::right, value, 1);
            if (operation_ == ASL) a_.extend8(value, value);
            break;
        case ROL:
            a_.address(r10, Mem{kCarry, 0, value, 2});
            a_.move(kCarry, value);
            a_.shift(Shift::right, kCarry, 7);
            a_.extend8(value, r10);
            break;
        default:  // ROR
            a_.move(r10, kCarry);
            a_.shift(Shift::left, r10, 7);
            a_.move(kCarry, value);
            a_.alu(Alu::and_, kCarry, 1);
            a_.shift(Shift::right, value, 1);
            a_.alu(Alu::or_, value, r10);
    }
    if (operand_ == Operand::Acc) {
        set_nz(kA);
    } else {
        a_.move(kNz, value);
        a_.store8(memory, value);
    }
    pending_ += static_cast<int32_t>(modify_cost(operand_));
    return true;
}

bool Translator::emit_implied() {
    const auto transfer = [&](Reg to, Reg from) {
        a_.move(to, from);
        set_nz(to);
    };
    const auto step = [&](Reg reg, bool up) {
        up ? a_.increment8(reg) : a_.decrement8(reg);
        set_nz(reg);
    };
    switch (operation_) {
        case TAX: transfer(kX, kA); break;
        case TAY: transfer(kY, kA); break;
        case TXA: transfer(kA, kX); break;
        case TYA: transfer(kA, kY); break;
        case INX: step(kX, true); break;
        case INY: step(kY, true); break;
        case DEX: step(kX, false); break;
        case DEY: step(kY, false); break;
        case CLD: case SED: {
            const bool on = operation_ == SED;
            a_.store8(in_console(Places::decimal()), uint8_t{on});
            if (on) a_.alu8(Alu::or_, in_console(Places::modes()), uint8_t{8});
            else a_.alu8(Alu::and_, in_console(Places::modes()), uint8_t{0xf7});
            break;
        }
        case NOP: break;
        case CLC:
            a_.move(kCarry, uint32_t{0});
            carry_ = {false, place_};
            break;
        case SEC:
            a_.move(kCarry, uint32_t{1});
            carry_ = {true, place_};
            break;
        case CLV: a_.store8(in_console(Places::overflow()), uint8_t{0}); break;
        case TXS: a_.store8(in_console(Places::sp()), kX); break;
        case TSX:
            a_.load8(kX, in_console(Places::sp()));
            set_nz(kX);
            break;
        case PHA:
            a_.load8(r8, in_console(Places::sp()));
            a_.test8(r8, r8);
            a_.jump(If::not_sign, slow_);
            a_.store8(Mem{kRam, -0x80, r8}, kA);
            a_.decrement8(r8);
            a_.store8(in_console(Places::sp()), r8);
            pending_ += 3;
            return true;
        case PLA:
            a_.load8(r8, in_console(Places::sp()));
            a_.address(r9, Mem{r8, -0x80});
            a_.alu(Alu::cmp, r9, 0x7f);
            a_.jump(If::not_below, slow_);
            a_.load8(kA, Mem{kRam, 1 - 0x80, r8});
            a_.increment8(r8);
            a_.store8(in_console(Places::sp()), r8);
            set_nz(kA);
            pending_ += 4;
            return true;
        default: return false;
    }
    pending_ += 2;
    return true;
}

}  // namespace atari
