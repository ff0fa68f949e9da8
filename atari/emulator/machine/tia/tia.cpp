// The reference TIA's registers: what each write and read does, when it takes effect, and how a frame ends.
//
// Deferred rendering and deferred collisions (deferred_renderer.cpp, collider.cpp) implement the same from the table in
// tia_registers.hpp. This file is a second implementation on purpose, with constants of its own, because each tests the
// other (tests/emulator/test_fast_equals_plain.py): do not merge them.
#include "tia.hpp"

#include <algorithm>

#include "tia_positions.hpp"
#include "tia_registers.hpp"

namespace atari {
// A write only stores the clock up to which the old state is valid (`pending`). Rendering happens before visible state
// changes, when a collision register is read, and at the end of the frame. The result does not depend on how rendering
// is split into steps, as long as the state is constant between them. The exception is an HMOVE blank in whose line the
// frame ends (render_to). Until this blank is rendered, every access of the TIA renders, as in ALE.
bool ReferenceTia::write(uint8_t reg, uint8_t value, uint32_t cycles) {
    const int hpos = t_.line_clock(cycles);
    t_.pending = std::max(t_.pending, clock_at(cycles, kTiaRegisters[reg].delay[hpos / 3 & 3]));
    bool ends_frame = t_.lines(cycles) > last_line(config_.pal);

    const int second = reg & 1;  // for register pairs, whose first address is even
    switch (reg) {
        case VSYNC: ends_frame |= write_vsync(value, cycles); break;
        case VBLANK: write_vblank(value, cycles); break;
        case NUSIZ0:
        case NUSIZ1: write_nusiz(second, value); break;
        case COLUP0:
        case COLUP1:
        case COLUPF:
        case COLUBK:
            change(t_.colour[reg - COLUP0],
                   static_cast<uint8_t>((value & 0xfe) | (config_.pal ? t_.last_line_count & 1 : 0)), 0);
            break;
        case CTRLPF:
            // In this order, because an unrendered end of a line latches the old value.
            change(t_.ctrlpf, value, 1u << kPF | 1u << kBL);
            if (hpos < 147) change(t_.pf_reflect, (value & 1) != 0, 1u << kPF);
            break;
        case REFP0:
        case REFP1: change(t_.refp[reg - REFP0], (value & 8) != 0, 1u << (reg - REFP0)); break;
        case PF0: change(t_.playfield, (t_.playfield & ~0xfu) | value >> 4, 1u << kPF); break;
        case PF1: change(t_.playfield, (t_.playfield & ~0xff0u) | value << 4, 1u << kPF); break;
        case PF2: change(t_.playfield, (t_.playfield & ~0xff000u) | value << 12, 1u << kPF); break;
        case RESP0:
        case RESP1: reset_player(second, hpos, cycles); break;
        case RESM0:
        case RESM1: reset_missile(second, hpos, cycles); break;
        case RESBL: reset_ball(hpos, cycles); break;
        case GRP0: write_graphics(0, value); break;
        case GRP1: write_graphics(1, value); break;
        case ENAM0:
        case ENAM1:
            if (t_.resmp[reg - ENAM0]) t_.enam[reg - ENAM0] = value & 2;
            else change(t_.enam[reg - ENAM0], (value & 2) != 0, 0);
            break;
        case ENABL:
            if (t_.vdelbl) t_.enabl = value & 2;
            else change(t_.enabl, (value & 2) != 0, 0);
            break;
        case HMM0:
            // The "starfield" of Cosmic Ark: clearing motion at one moment after HMOVE leaves missile 0 moving.
            if (clocks_since(t_.last_hmove, cycles) == 63 && t_.hm[kM0] == 7 && value >> 4 == 6) {
                renderer_.catch_up();
                t_.cosmic_ark = true;
                t_.ark_counter = 0;
            }
            [[fallthrough]];
        case HMP0:
        case HMP1:
        case HMM1:
        case HMBL: t_.hm[reg - HMP0] = value >> 4; break;
        case VDELP0:
        case VDELP1: change(t_.vdelp[reg - VDELP0], (value & 1) != 0, 1u << (reg - VDELP0)); break;
        case VDELBL: change(t_.vdelbl, (value & 1) != 0, 0); break;
        case RESMP0:
        case RESMP1: release_missile(second, value); break;
        case HMOVE: hmove(hpos / 3, cycles); break;
        case HMCLR: std::fill_n(t_.hm, 5, uint8_t{0}); break;
        case CXCLR:
            renderer_.catch_up();
            t_.collisions = 0;
            break;
        default: break;
    }
    if (t_.hmove_blank) renderer_.catch_up();
    return ends_frame;
}

// Changes a register that affects pixels, and marks the masks of `objects` as stale.
template <typename T, typename V>
void ReferenceTia::change(T& field, V value, unsigned objects) {
    if (field == value) return;
    renderer_.catch_up();
    field = value;
    renderer_.touch(objects);
}

void ReferenceTia::write_nusiz(int player, uint8_t value) {
    const bool ark = player == 0 && (t_.cosmic_ark || t_.m0_variant != kPlain);
    if (((t_.nusiz[player] ^ value) & 0x37) || t_.skip_first[player] || ark) {
        renderer_.catch_up();
        t_.skip_first[player] = false;
        if (player == 0) t_.m0_variant = kPlain;
        renderer_.touch(1u << (kP0 + player) | 1u << (kM0 + player));
    }
    t_.nusiz[player] = value;
}

// A write to one player's graphics also moves the other's new graphics to its delayed copy.
void ReferenceTia::write_graphics(int player, uint8_t value) {
    const int other = player ^ 1;
    const bool shows = (!t_.vdelp[player] && t_.grp[player] != value) ||
                       (t_.vdelp[other] && t_.old_grp[other] != t_.grp[other]) ||
                       (player == 1 && t_.vdelbl && t_.old_enabl != t_.enabl);
    if (shows) {
        renderer_.catch_up();
        renderer_.touch(1u << kP0 | 1u << kP1);
    }
    t_.grp[player] = value;
    t_.old_grp[other] = t_.grp[other];
    if (player == 1) t_.old_enabl = t_.enabl;
}

bool ReferenceTia::write_vsync(uint8_t value, uint32_t cycles) {
    if (value & 2) {
        t_.vsync_done = clock_at(cycles, kClocksPerLine);
        return false;
    }
    const bool ends_frame = clock_at(cycles) >= t_.vsync_done;
    if (ends_frame) t_.vsync_done = kVsyncIdle;
    return ends_frame;
}

// While bit 7 of VBLANK is set, the paddles' capacitors stay empty.
bool ReferenceTia::switch_dump(uint8_t old, uint8_t value, uint32_t cycles) {
    if (!(old & 0x80) && (value & 0x80)) {
        t_.dump_on = true;
    } else if ((old & 0x80) && !(value & 0x80)) {
        t_.dump_on = false;
        if (config_.paddles[0] || config_.paddles[1]) t_.dump_off_cycle = static_cast<int32_t>(cycles);
    } else {
        return false;
    }
    return true;
}

void ReferenceTia::write_vblank(uint8_t value, uint32_t cycles) {
    switch_dump(t_.vblank, value, cycles);
    if ((t_.vblank ^ value) & 2) renderer_.catch_up();
    t_.vblank = value;
}

void ReferenceTia::reset_player(int player, int hpos, uint32_t cycles) {
    const uint8_t position = strobe_player(hpos);
    const PlayerStrobe strobe = player_strobe(position, t_.pos[player], t_.nusiz[player] & 7);
    if (strobe.goes_on) t_.pending = std::max(t_.pending, clock_at(cycles, 11));
    renderer_.catch_up();
    t_.pos[player] = position;
    t_.skip_first[player] = strobe.hidden;
    renderer_.touch(1u << (kP0 + player));
}

void ReferenceTia::reset_missile(int missile, int hpos, uint32_t cycles) {
    renderer_.catch_up();
    t_.pos[kM0 + missile] = strobe_missile(missile, hpos, clocks_since(t_.last_hmove, cycles));
    if (missile == 0) t_.m0_variant = kPlain;
    renderer_.touch(1u << (kM0 + missile));
}

void ReferenceTia::reset_ball(int hpos, uint32_t cycles) {
    renderer_.catch_up();
    t_.pos[kBL] = strobe_ball(hpos, clocks_since(t_.last_hmove, cycles));
    renderer_.touch(1u << kBL);
}

void ReferenceTia::release_missile(int missile, uint8_t value) {
    if (t_.resmp[missile] == ((value & 2) != 0)) return;
    renderer_.catch_up();
    if (t_.resmp[missile]) {
        t_.pos[kM0 + missile] = released_missile(t_.pos[missile], t_.nusiz[missile] & 7);
        if (missile == 0) t_.m0_variant = kPlain;
        renderer_.touch(1u << (kM0 + missile));
    }
    t_.resmp[missile] = value & 2;
}

void ReferenceTia::hmove(int cycle_in_line, uint32_t cycles) {
    renderer_.catch_up();
    if (config_.hmove_blanks && (cycle_in_line <= 20 || cycle_in_line == 75)) t_.hmove_blank = true;
    for (int object = kP0; object <= kBL; ++object) {
        t_.pos[object] = wrapped(t_.pos[object] + motion(cycle_in_line, t_.hm[object]));
        renderer_.touch(1u << object);
    }
    t_.skip_first[0] = t_.skip_first[1] = false;
    t_.m0_variant = kPlain;
    t_.last_hmove = clock_at(cycles);
    t_.cosmic_ark = false;
}

void ReferenceTia::prepare_read(int reg, uint32_t cycles) {
    t_.pending = std::max(t_.pending, clock_at(cycles));
    if (reg < 8 || t_.hmove_blank) renderer_.catch_up();
}

uint8_t ReferenceTia::read(int reg, uint32_t cycles, uint8_t bus, const Inputs& inputs) const {
    uint8_t driven = 0;
    if (reg < 8) driven = static_cast<uint8_t>((t_.collisions >> (14 - 2 * reg) & 3) << 6);
    else if (reg < 0xe) driven = cycles >= input_from(reg - 8, inputs) ? 0x80 : 0x00;
    return static_cast<uint8_t>(driven | (bus & 0x3f));
}

// INPT0-3 are the paddles' capacitors, INPT4 and 5 the sticks' fire buttons. Returns the cycle from which on an input
// reads as 1, until the next write to VBLANK. A button is 1 from cycle 0 or never.
uint64_t ReferenceTia::input_from(int port, const Inputs& inputs) const {
    constexpr uint64_t kNever = ~uint64_t{0};
    const int swapped = config_.swap_ports ? 1 : 0;
    if (port >= 4) {
        const int side = (port - 4) ^ swapped;
        return !config_.paddles[side] && inputs.fire[side] ? kNever : 0;
    }
    const int side = (port / 2) ^ swapped;
    if (!config_.paddles[side]) return kNever;
    const int32_t resistance = inputs.resistance[2 * side + ((port & 1) ^ (config_.swap_paddles ? 1 : 0))];
    if (resistance == 0) return 0;
    if (t_.dump_on) return kNever;
    const double needed = (1.6 * resistance * 0.01e-6) * 1.19e6;
    // The sum wraps as in the reference: a capacitor charged in an earlier frame reads as empty.
    return uint64_t{static_cast<uint32_t>(t_.dump_off_cycle) + static_cast<uint32_t>(needed)} + 1;
}

void ReferenceTia::reset() {
    const bool partial = t_.partial, greyed = t_.greyed;
    const uint8_t current = t_.current;
    t_ = Tia{};
    t_.partial = partial;
    t_.greyed = greyed;
    t_.current = current;
    t_.draw_start = kClocksPerLine * config_.first_line;
    t_.draw_stop = kClocksPerLine * (config_.first_line + config_.height);
    t_.to_line_end = kClocksPerLine;
    t_.vsync_done = kVsyncIdle;
    renderer_.touch(kAllObjects);
}

void ReferenceTia::start_frame(int32_t begun) {
    t_.current ^= 1;
    t_.frame_start = -begun;
    t_.draw_start = t_.frame_start + kClocksPerLine * config_.first_line;
    t_.draw_stop = t_.draw_start + kClocksPerLine * config_.height;
    t_.drawn_to = t_.pending = t_.draw_start;
    t_.to_line_end = kClocksPerLine;
    t_.write_pos = 0;
    if (config_.pal)  // colour loss: frames of an odd number of lines are grey
        for (uint8_t& colour : t_.colour) colour = static_cast<uint8_t>((colour & 0xfe) | (t_.last_line_count & 1));
    t_.greyed = false;
}

void ReferenceTia::rebase(uint32_t cycles) {
    for (int32_t* stamp :
         {&t_.frame_start, &t_.draw_start, &t_.draw_stop, &t_.drawn_to, &t_.pending, &t_.vsync_done, &t_.last_hmove})
        rebase_stamp(*stamp, 3 * cycles);
    if (config_.paddles[0] || config_.paddles[1]) rebase_stamp(t_.dump_off_cycle, cycles);
}

}  // namespace atari
