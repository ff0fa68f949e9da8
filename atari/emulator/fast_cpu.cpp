// The 6507 at speed: the decoded records of the cartridge, one handler after the other, the registers in locals.
#include "handlers.hpp"

namespace atari {

// A handler ends by going to the next one. Where the compiler has labels as values the record holds the next handler's,
// and every handler jumps there itself, which lets the processor predict each such jump on its own. Elsewhere they come
// back to one switch.
#if defined(__GNUC__) && !defined(ATARI_NO_COMPUTED_GOTO)
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

Exit FastCpu::run(Console* console, [[maybe_unused]] const void* const** labels) {
#if COMPUTED_GOTO
    static const void* const kLabels[] = {
        &&handle_kStep, &&handle_kPollTimer, &&handle_kRamCode,
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
    Console& c = *console;
    Registers r;
    Exit exit = kNext;
    take(r, c);
    uint32_t pc = c.m_.cpu.pc;

look:  // where the processor is, and whether it goes on
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

    HANDLER(kPollTimer) {
        poll_timer(r, c);
        RUN_HANDLER(static_cast<uint16_t>(r.at->jump));
    }

    HANDLER(kRamCode) {
        RUN_HANDLER(decode_ram(c, r.at));
    }

    HANDLER(kStep) {
        exit = kPlainly;
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
    if (r.cycles >= c.cycle_limit_) {
        exit = kLimit;
        goto stop;
    }
    goto look;

stop:
    give(r, c);
    c.m_.cpu.pc = static_cast<uint16_t>(pc);
    return exit;
}

const void* FastCpu::label(uint16_t handler) {
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

const void* code_of(uint16_t handler) { return FastCpu::label(handler); }

namespace {

// The handler of a record's first instruction alone. Where the TIA draws as it goes, reading an input makes it draw.
constexpr auto kFirstOf = [] {
    std::array<uint16_t, kHandlers> table{kStep, kPollTimer, kRamCode};
#define SINGLE(operation, operand) \
    table[operation##_##operand] = Operand::operand == Operand::Input ? kStep : operation##_##operand;
#define PAIR(o1, k1, o2, k2) table[o1##_##k1##_##o2##_##k2] = table[o1##_##k1];
#include "handlers.def"
    return table;
}();

}  // namespace

void FastCpu::run_counted(Console& c, int left) {
    using Step = Exit (*)(Registers&, Console&);
    static constexpr Step kSteps[] = {
        nullptr, nullptr, nullptr,
#define SINGLE(operation, operand) run_single<operation, Operand::operand>,
#define PAIR(...)
#include "handlers.def"
    };
    Registers r;
    take(r, c);
    uint32_t pc = c.m_.cpu.pc;
    bool here = false;  // r.at is the record at which to go on
    for (; left > 0 && !c.m_.cpu.stop && !c.m_.cpu.jammed; --left) {
        if (!here || c.remapped_) {
            c.remapped_ = false;
            r.at = enter(c, pc);
        }
        uint16_t handler = r.at ? kFirstOf[r.at->handler] : uint16_t{kStep};
        if (handler == kPollTimer) handler = static_cast<uint16_t>(r.at->jump);
        if (handler == kRamCode) handler = kFirstOf[decode_ram(c, r.at)];
        if (left == 1) handler = kStep;  // what the last instruction leaves on the bus stays in the state
        here = handler != kStep && kSteps[handler](r, c) != kPlainly;
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

// The whole frame, or what is left of it, with every instruction counted and the TIA drawing as it goes.
void Console::run_counted() {
    m_.cpu.stop = false;
    overlong_ = 0;  // no write is kept for later
    cycle_limit_ = 0xffffffff;
    FastCpu::run_counted(*this, kInstructionLimit);
}

bool Console::run_fast() {
    cycle_limit_ = kCyclesBelowLimit;
    time_inputs();
    return FastCpu::run(this) != kLimit && !m_.cpu.jammed;
}

}  // namespace atari
