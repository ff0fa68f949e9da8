// The fast interpreter of the 6507: runs a cartridge's decoded instructions, with the registers in local variables.
#include "loops.hpp"

namespace atari {

// clang-format off
// A handler ends with the jump to the next handler. If the compiler has labels as values, the decoded instruction holds
// the next handler's label and every handler has a jump of its own, which the host processor predicts separately.
// Otherwise all handlers return to one switch.
#if (defined(__GNUC__) || defined(__clang__)) && !defined(ATARI_NO_COMPUTED_GOTO)
#define COMPUTED_GOTO 1
#define HANDLER(name) handle_##name:
#define NEXT goto* r.at->code
#define RUN_HANDLER(handler) goto* kLabels[handler]
#else
#define COMPUTED_GOTO 0
#define HANDLER(name) case name:
#define NEXT RUN_HANDLER(r.at->handler)
#define RUN_HANDLER(handler) do { chosen = handler; goto dispatch; } while (false)
#endif

Exit Interpreter::run(FastConsole* console, [[maybe_unused]] const void* const** labels) {
#if COMPUTED_GOTO
    static const void* const kLabels[] = {
        &&handle_kStep, &&handle_kLoop, &&handle_kRamCode, &&handle_kTranslated,
#define SINGLE(operation, operand) &&handle_##operation##_##operand,
#define PAIR(o1, k1, o2, k2) &&handle_##o1##_##k1##_##o2##_##k2,
#include "handlers.def"
    };
    if (labels) {
        *labels = kLabels;
        return kNext;
    }
#else
    uint16_t chosen;
#endif
    FastConsole& c = *console;
    Registers r;
    Exit exit = kNext;
    take(r, c);
    uint32_t pc = c.m_.cpu.pc;

look:  // finds the decoded instruction at `pc`, unless the frame has ended
    if (c.m_.cpu.stop || c.m_.cpu.jammed) goto stop;
    c.remapped_ = false;
    r.at = enter(c, pc);
    if (!r.at) goto plain_at_pc;
    NEXT;

#if !COMPUTED_GOTO
dispatch:
    switch (chosen) {
#endif

#define RUN(operation, operand)                           \
    exit = run_one<operation, Operand::operand>(r, c);    \
    if (exit != kNext) [[unlikely]] goto other;
#define SINGLE(o1, k1)       \
    HANDLER(o1##_##k1) {     \
        RUN(o1, k1)          \
        NEXT;                \
    }
#define PAIR(o1, k1, o2, k2)             \
    HANDLER(o1##_##k1##_##o2##_##k2) {   \
        RUN(o1, k1)                      \
        RUN(o2, k2)                      \
        NEXT;                            \
    }
#include "handlers.def"
#undef RUN

    HANDLER(kLoop) {
        skip_rounds(r, c);
        RUN_HANDLER(static_cast<uint16_t>(r.at->jump));
    }

    HANDLER(kRamCode) {
        RUN_HANDLER(decode_ram(c, r.at));
    }

    HANDLER(kTranslated) {
        Registers there = r;  // a copy, so that the members of `r` stay in registers of the host
        const auto place = static_cast<std::size_t>(r.at - c.first_instruction_);
        exit = static_cast<Exit>(c.program_.translated_code().run(there, c, place));
        r = there;
        if (exit != kNext) goto other;
        NEXT;
    }

    HANDLER(kStep) {
        exit = kInterpret;
        goto other;
    }

#if !COMPUTED_GOTO
    }
#endif

other:
    pc = pc_of(c, r.at);
    if (exit == kLimit) goto stop;
    if (exit == kLeave) goto look;

plain_at_pc:
    give(r, c);
    c.m_.cpu.pc = static_cast<uint16_t>(pc);
    c.run_instruction();
    take(r, c);
    pc = c.m_.cpu.pc;
    if (r.cycles >= c.cycle_limit_) goto stop;
    goto look;

stop:
    if (r.cycles >= c.cycle_limit_) exit = kLimit;
    give(r, c);
    c.m_.cpu.pc = static_cast<uint16_t>(pc);
    return exit;
}
// clang-format on

const void* Interpreter::label(uint16_t handler) {
#if COMPUTED_GOTO
    static const void* const* const kLabels = [] {
        const void* const* labels;
        run(nullptr, &labels);
        return labels;
    }();
    return kLabels[handler];
#else
    static_cast<void>(handler);
    return nullptr;
#endif
}

const void* code_of(uint16_t handler) { return Interpreter::label(handler); }

namespace {

// By handler, the handler of its first instruction alone.
constexpr auto kSingleOf = [] {
    std::array<uint16_t, kHandlers> table{kStep, kLoop, kRamCode, kTranslated};
#define SINGLE(operation, operand) table[operation##_##operand] = operation##_##operand;
#define PAIR(o1, k1, o2, k2) table[o1##_##k1##_##o2##_##k2] = table[o1##_##k1];
#include "handlers.def"
    return table;
}();

// The same for frames that are rendered as they run. Reading an input then makes the TIA render, so the plain
// interpreter does it.
constexpr auto kFirstOf = [] {
    std::array<uint16_t, kHandlers> table = kSingleOf;
#define SINGLE(operation, operand) \
    if (Operand::operand == Operand::Input) table[operation##_##operand] = kStep;
#define PAIR(o1, k1, o2, k2) table[o1##_##k1##_##o2##_##k2] = table[o1##_##k1];
#include "handlers.def"
    return table;
}();

}  // namespace

// By handler of a single instruction.
// clang-format off
constexpr Interpreter::Step Interpreter::kSteps[] = {
    nullptr, nullptr, nullptr, nullptr,
#define SINGLE(operation, operand) run_single<operation, Operand::operand>,
#define PAIR(...)
#include "handlers.def"
};
// clang-format on

void Interpreter::run_counted(FastConsole& c, int left) {
    Registers r;
    take(r, c);
    uint32_t pc = c.m_.cpu.pc;
    bool here = false;  // whether r.at is the decoded instruction to continue at
    for (; left > 0 && !c.m_.cpu.stop && !c.m_.cpu.jammed; --left) {
        if (!here || c.remapped_) {
            c.remapped_ = false;
            r.at = enter(c, pc);
        }
        uint16_t handler = r.at ? kFirstOf[r.at->handler] : uint16_t{kStep};
        if (handler == kLoop) handler = kFirstOf[r.at->jump];
        if (handler == kRamCode) handler = kFirstOf[decode_ram(c, r.at)];
        if (left == 1) handler = kStep;  // the byte that the last instruction leaves on the bus must be in the state
        here = handler != kStep && kSteps[handler](r, c) != kInterpret;
        if (here) {
            pc = pc_of(c, r.at);
            continue;
        }
        give(r, c);
        c.m_.cpu.pc = static_cast<uint16_t>(pc);
        c.run_instruction();
        take(r, c);
        pc = c.m_.cpu.pc;
    }
    give(r, c);
    c.m_.cpu.pc = static_cast<uint16_t>(pc);
}

Interpreter::Step Interpreter::step_of(uint16_t handler) { return kSteps[kSingleOf[handler]]; }

Exit Interpreter::skip_loop(Registers& r, FastConsole& c) noexcept {
    skip_rounds(r, c);
    return kNext;
}

uint16_t Interpreter::decode_ram(FastConsole& c, const DecodedInstruction* at) {
    const auto place = static_cast<std::size_t>(at - c.ram_code_);
    if (place >= 128) return kStep;
    const std::size_t available = 128 - place;
    std::array<uint8_t, 4> bytes{};
    // One access of fixed size, the most frequent case.
    if (available >= 4) std::memcpy(bytes.data(), c.m_.riot.ram + place, 4);
    else std::memcpy(bytes.data(), c.m_.riot.ram + place, available);
    bytes[3] = 0;
    FastConsole::RamCode& known = c.ram_known_[place];
    if (known.bytes == bytes && known.handler != kHandlers) return known.handler;
    DecodedInstruction instruction = decode(bytes.data(), static_cast<int>(available), c.program_, nullptr);
    known = {bytes, instruction.handler};
    if (instruction.handler == JSR_Far) known.handler = kStep;  // its push may overwrite its own operand
    if (is_branch(instruction.handler)) {
        const int target = static_cast<int>(place) + instruction.jump;
        if (target < 0 || target > 127) known.handler = kStep;
        instruction.taken = 3;
    }
    instruction.handler = kRamCode;
    instruction.code = at->code;
    c.ram_code_[place] = instruction;
    return known.handler;
}

bool Interpreter::write_port(FastConsole& c, uint32_t cycles, uint32_t address, uint32_t value) {
    const bool plain_tia = !(address & 0x1080) && !c.slot_.watches_tia && cycles < c.deadline_;
    const bool logged = plain_tia && write_register(cycles, c, tia_register(address), value);
    c.m_.cycles = cycles;
    if (logged) return false;
    c.m_.cpu.last_access_was_read = true;
    c.write(static_cast<uint16_t>(address), static_cast<uint8_t>(value));
    return c.m_.cpu.stop || c.remapped_;
}

bool Interpreter::write_register(uint32_t& cycles, FastConsole& c, uint32_t reg, uint32_t value) {
    switch (kStoredIn[reg]) {
        // clang-format off
#define KIND(kind) \
    case Operand::kind: write_tia<Operand::kind>(cycles, c, reg, value); return true;
        KIND(Tia) KIND(Strobe) KIND(Nusiz) KIND(Motion) KIND(Hmove) KIND(Ctrlpf) KIND(Grp0) KIND(Grp1)
        KIND(Wsync) KIND(Sound)
        KIND(Hmclr) KIND(Cxclr)
#undef KIND
        default: return false;
        // clang-format on
    }
}

// Runs the frame, or the rest of it, with every instruction counted and without deferred rendering.
void FastConsole::run_counted() {
    m_.cpu.stop = false;
    deadline_ = 0;  // no write is logged
    cycle_limit_ = 0xffffffff;
    Interpreter::run_counted(*this, kInstructionLimit);
}

bool FastConsole::run_fast() {
    cycle_limit_ = kCyclesBelowLimit;
    time_inputs();
    return Interpreter::run(this) != kLimit && !m_.cpu.jammed;
}

}  // namespace atari
