// Where machine code finds what it works with, counted from the beginning of the console or of the registers.
#pragma once

#include <cstddef>
#include <cstdint>

#include "handlers.hpp"

namespace atari {

// Both compilers that make machine code define this for structs like these.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Winvalid-offsetof"

struct Places {
#define PLACE(name, type, member) \
    static constexpr int32_t name() { return static_cast<int32_t>(offsetof(type, member)); }
    PLACE(at, Registers, at)
    PLACE(cycles, Registers, cycles)
    PLACE(a, Registers, a)
    PLACE(x, Registers, x)
    PLACE(y, Registers, y)
    PLACE(nz, Registers, nz)
    PLACE(carry, Registers, carry)
    PLACE(ram, Console, m_.riot.ram)
    PLACE(sp, Console, m_.cpu.sp)
    PLACE(decimal, Console, m_.cpu.d)
    PLACE(overflow, Console, overflow_)
    PLACE(sound, Console, m_.sound)
    PLACE(inputs, Console, inputs_from_)
    PLACE(timer, Console, m_.riot.timer)
    PLACE(timer_shift, Console, m_.riot.shift)
    PLACE(timer_set_at, Console, m_.riot.set_at)
    PLACE(dpc_random, Console, m_.cart.random)
    PLACE(dpc_counters, Console, m_.cart.counter)
    PLACE(dpc_tops, Console, m_.cart.top)
    PLACE(dpc_bottoms, Console, m_.cart.bottom)
    PLACE(dpc_flags, Console, m_.cart.flag)
    PLACE(image, Console, image_)
    PLACE(overlong, Console, overlong_)
    PLACE(cycle_limit, Console, cycle_limit_)
    PLACE(first_cycle, Console, first_cycle_)
    PLACE(log_end, Console, log_end_)
    PLACE(first_record, Console, first_record_)
    PLACE(base_record, Console, base_record_)
    PLACE(origin, Console, origin_)
    PLACE(code_segments, Console, code_segments_)
    PLACE(segments, Console, segment_)
    PLACE(bank, Console, bank_)
    PLACE(pages, Console, pages_)
    PLACE(written, Console, written_.reg)
    PLACE(old_grp0, Console, written_.old_grp0)
    PLACE(old_grp1, Console, written_.old_grp1)
    PLACE(old_enabl, Console, written_.old_enabl)
    PLACE(mirror_waits, Console, written_.mirror_waits)
    PLACE(ark, Console, written_.ark)
    PLACE(modes, Console, modes_)
    PLACE(watches_tia, Console, watches_tia_)
#undef PLACE
};

#pragma GCC diagnostic pop

}  // namespace atari
