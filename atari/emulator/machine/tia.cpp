// The reference TIA's registers: what each write and read does, when it takes effect, and how a frame ends.
//
// Deferred rendering and deferred collisions (deferred_renderer.cpp, collider.cpp) implement the same from the table in
// tia_registers.hpp. This file is a second implementation on purpose, with constants of its own, because each tests the
// other (tests/emulator/test_fast_equals_plain.py): do not merge them.
#include "console.hpp"

#include <algorithm>

#include "tia_positions.hpp"
#include "tia_registers.hpp"

namespace atari {
// A write only stores the clock up to which the old state is valid (`pending`). Rendering happens before visible state
// changes, when a collision register is read, and at the end of the frame. The result does not depend on how rendering
// is split into steps, as long as the state is constant between them. An HMOVE blank is the exception, if the frame ends
// in its line (render_to): until the blank is rendered, every access of the TIA renders, as in ALE.
void Console::write_tia(uint8_t reg, uint8_t value) {
    Tia& t = m_.tia;
    const int hpos = line_clock();
    t.pending = std::max(t.pending, clock(kTiaRegisters[reg].delay[hpos / 3 & 3]));
    if (scan_lines() > last_line(config_.pal)) end_frame();

    const int second = reg & 1;  // for register pairs, whose first address is even
    switch (reg) {
        case VSYNC: write_vsync(value); break;
        case VBLANK: write_vblank(value); break;
        case WSYNC: halt_until_line_start(); break;
        case NUSIZ0:
        case NUSIZ1: write_nusiz(second, value); break;
        case COLUP0:
        case COLUP1:
        case COLUPF:
        case COLUBK:
            change(t.colour[reg - COLUP0],
                   static_cast<uint8_t>((value & 0xfe) | (config_.pal ? t.last_line_count & 1 : 0)), 0);
            break;
        case CTRLPF:
            // In this order, because an unrendered end of a line latches the old value.
            change(t.ctrlpf, value, 1u << kPF | 1u << kBL);
            if (hpos < 147) change(t.pf_reflect, (value & 1) != 0, 1u << kPF);
            break;
        case REFP0:
        case REFP1: change(t.refp[reg - REFP0], (value & 8) != 0, 1u << (reg - REFP0)); break;
        case PF0: change(t.playfield, (t.playfield & ~0xfu) | value >> 4, 1u << kPF); break;
        case PF1: change(t.playfield, (t.playfield & ~0xff0u) | value << 4, 1u << kPF); break;
        case PF2: change(t.playfield, (t.playfield & ~0xff000u) | value << 12, 1u << kPF); break;
        case RESP0:
        case RESP1: reset_player(second, hpos); break;
        case RESM0:
        case RESM1: reset_missile(second, hpos); break;
        case RESBL: reset_ball(hpos); break;
        case AUDC0:
        case AUDC1:
        case AUDF0:
        case AUDF1:
        case AUDV0:
        case AUDV1: m_.sound.write(reg, value); break;
        case GRP0: write_graphics(0, value); break;
        case GRP1: write_graphics(1, value); break;
        case ENAM0:
        case ENAM1:
            if (t.resmp[reg - ENAM0]) t.enam[reg - ENAM0] = value & 2;
            else change(t.enam[reg - ENAM0], (value & 2) != 0, 0);
            break;
        case ENABL:
            if (t.vdelbl) t.enabl = value & 2;
            else change(t.enabl, (value & 2) != 0, 0);
            break;
        case HMM0:
            // The "starfield" of Cosmic Ark: clearing motion at one moment after HMOVE leaves missile 0 moving.
            if (clocks_since(t.last_hmove) == 63 && t.hm[kM0] == 7 && value >> 4 == 6) {
                catch_up();
                t.cosmic_ark = true;
                t.ark_counter = 0;
            }
            [[fallthrough]];
        case HMP0:
        case HMP1:
        case HMM1:
        case HMBL: t.hm[reg - HMP0] = value >> 4; break;
        case VDELP0:
        case VDELP1: change(t.vdelp[reg - VDELP0], (value & 1) != 0, 1u << (reg - VDELP0)); break;
        case VDELBL: change(t.vdelbl, (value & 1) != 0, 0); break;
        case RESMP0:
        case RESMP1: release_missile(second, value); break;
        case HMOVE: hmove(hpos / 3); break;
        case HMCLR: std::fill_n(t.hm, 5, uint8_t{0}); break;
        case CXCLR:
            catch_up();
            t.collisions = 0;
            break;
        default: break;
    }
    if (t.hmove_blank) catch_up();
}

// Changes a register that affects pixels, and marks the masks of `objects` as stale.
template <typename T, typename V>
void Console::change(T& field, V value, unsigned objects) {
    if (field == value) return;
    catch_up();
    field = value;
    stale_ |= objects;
}

void Console::write_nusiz(int player, uint8_t value) {
    Tia& t = m_.tia;
    const bool ark = player == 0 && (t.cosmic_ark || t.m0_variant != kPlain);
    if (((t.nusiz[player] ^ value) & 0x37) || t.skip_first[player] || ark) {
        catch_up();
        t.skip_first[player] = false;
        if (player == 0) t.m0_variant = kPlain;
        stale_ |= 1u << (kP0 + player) | 1u << (kM0 + player);
    }
    t.nusiz[player] = value;
}

// A write to one player's graphics also moves the other's new graphics to its delayed copy.
void Console::write_graphics(int player, uint8_t value) {
    Tia& t = m_.tia;
    const int other = player ^ 1;
    const bool shows = (!t.vdelp[player] && t.grp[player] != value) ||
                       (t.vdelp[other] && t.old_grp[other] != t.grp[other]) ||
                       (player == 1 && t.vdelbl && t.old_enabl != t.enabl);
    if (shows) {
        catch_up();
        stale_ |= 1u << kP0 | 1u << kP1;
    }
    t.grp[player] = value;
    t.old_grp[other] = t.grp[other];
    if (player == 1) t.old_enabl = t.enabl;
}

void Console::end_frame() {
    m_.cpu.stop = true;
    m_.tia.partial = false;
}

void Console::write_vsync(uint8_t value) {
    Tia& t = m_.tia;
    if (value & 2) {
        t.vsync_done = clock(kClocksPerLine);
    } else if (clock() >= t.vsync_done) {
        t.vsync_done = kVsyncIdle;
        end_frame();
    }
}

// While bit 7 of VBLANK is set, the paddles' capacitors stay empty.
bool Console::switch_dump(uint8_t old, uint8_t value) {
    Tia& t = m_.tia;
    if (!(old & 0x80) && (value & 0x80)) {
        t.dump_on = true;
    } else if ((old & 0x80) && !(value & 0x80)) {
        t.dump_on = false;
        if (config_.paddles[0] || config_.paddles[1]) t.dump_off_cycle = static_cast<int32_t>(m_.cycles);
    } else {
        return false;
    }
    return true;
}

void Console::write_vblank(uint8_t value) {
    Tia& t = m_.tia;
    switch_dump(t.vblank, value);
    if ((t.vblank ^ value) & 2) catch_up();
    t.vblank = value;
}

void Console::halt_until_line_start() {
    if (!m_.cpu.last_access_was_read) return;
    const int in_line = line_clock() / 3;
    if (in_line != 0) m_.cycles += static_cast<uint32_t>(kCyclesPerLine - in_line);
}

void Console::reset_player(int player, int hpos) {
    Tia& t = m_.tia;
    const uint8_t position = strobe_player(hpos);
    const PlayerStrobe strobe = player_strobe(position, t.pos[player], t.nusiz[player] & 7);
    if (strobe.goes_on) t.pending = std::max(t.pending, clock(11));
    catch_up();
    t.pos[player] = position;
    t.skip_first[player] = strobe.hidden;
    touch(kP0 + player);
}

void Console::reset_missile(int missile, int hpos) {
    Tia& t = m_.tia;
    catch_up();
    t.pos[kM0 + missile] = strobe_missile(missile, hpos, clocks_since(t.last_hmove));
    if (missile == 0) t.m0_variant = kPlain;
    touch(kM0 + missile);
}

void Console::reset_ball(int hpos) {
    catch_up();
    m_.tia.pos[kBL] = strobe_ball(hpos, clocks_since(m_.tia.last_hmove));
    touch(kBL);
}

void Console::release_missile(int missile, uint8_t value) {
    Tia& t = m_.tia;
    if (t.resmp[missile] == ((value & 2) != 0)) return;
    catch_up();
    if (t.resmp[missile]) {
        t.pos[kM0 + missile] = released_missile(t.pos[missile], t.nusiz[missile] & 7);
        if (missile == 0) t.m0_variant = kPlain;
        touch(kM0 + missile);
    }
    t.resmp[missile] = value & 2;
}

void Console::hmove(int cycle_in_line) {
    Tia& t = m_.tia;
    catch_up();
    if (config_.hmove_blanks && (cycle_in_line <= 20 || cycle_in_line == 75)) t.hmove_blank = true;
    for (int object = kP0; object <= kBL; ++object) {
        t.pos[object] = wrapped(t.pos[object] + motion(cycle_in_line, t.hm[object]));
        touch(object);
    }
    t.skip_first[0] = t.skip_first[1] = false;
    t.m0_variant = kPlain;
    t.last_hmove = clock();
    t.cosmic_ark = false;
}

void Console::before_tia_read(int reg) {
    m_.tia.pending = std::max(m_.tia.pending, clock());
    if (reg < 8 || m_.tia.hmove_blank) catch_up();
}

uint8_t Console::read_tia(uint16_t address) {
    const int reg = address & 0xf;
    uint8_t driven = 0;
    before_tia_read(reg);
    if (reg < 8) {
        driven = static_cast<uint8_t>((m_.tia.collisions >> (14 - 2 * reg) & 3) << 6);
    } else if (reg < 0xe) {
        driven = m_.cycles >= input_from(reg - 8) ? 0x80 : 0x00;
    }
    return static_cast<uint8_t>(driven | (m_.bus & 0x3f));
}

// INPT0-3 are the paddles' capacitors, INPT4 and 5 the sticks' fire buttons: from which cycle on each reads as 1, until
// the next write to VBLANK. A button is 1 from cycle 0 or never.
uint64_t Console::input_from(int port) const {
    constexpr uint64_t kNever = ~uint64_t{0};
    const int swapped = config_.swap_ports ? 1 : 0;
    if (port >= 4) {
        const int side = (port - 4) ^ swapped;
        return !config_.paddles[side] && m_.inputs.fire[side] ? kNever : 0;
    }
    const int side = (port / 2) ^ swapped;
    if (!config_.paddles[side]) return kNever;
    const int32_t resistance = m_.inputs.resistance[2 * side + ((port & 1) ^ (config_.swap_paddles ? 1 : 0))];
    if (resistance == 0) return 0;
    if (m_.tia.dump_on) return kNever;
    const double needed = (1.6 * resistance * 0.01e-6) * 1.19e6;
    // The sum wraps as in the reference: a capacitor charged in an earlier frame reads as empty.
    return uint64_t{static_cast<uint32_t>(m_.tia.dump_off_cycle) + static_cast<uint32_t>(needed)} + 1;
}

void Console::reset_tia() {
    Tia& t = m_.tia;
    const bool partial = t.partial, greyed = t.greyed;
    const uint8_t current = t.current;
    t = Tia{};
    t.partial = partial;
    t.greyed = greyed;
    t.current = current;
    t.draw_start = kClocksPerLine * config_.first_line;
    t.draw_stop = kClocksPerLine * (config_.first_line + config_.height);
    t.to_line_end = kClocksPerLine;
    t.vsync_done = kVsyncIdle;
    framebuffers_.clear();
    touch_all();
}

void Console::start_frame() {
    Tia& t = m_.tia;
    t.current ^= 1;
    const int32_t begun = line_clock();  // clocks of the unfinished line; the phase of lines continues
    rebase_cycles();
    t.frame_start = -begun;
    t.draw_start = t.frame_start + kClocksPerLine * config_.first_line;
    t.draw_stop = t.draw_start + kClocksPerLine * config_.height;
    t.drawn_to = t.pending = t.draw_start;
    t.to_line_end = kClocksPerLine;
    t.write_pos = 0;
    if (config_.pal)  // colour loss: frames of an odd number of lines are grey
        for (uint8_t& colour : t.colour) colour = static_cast<uint8_t>((colour & 0xfe) | (t.last_line_count & 1));
    t.greyed = false;
}

// Makes the rest of the framebuffer grey, after the instruction limit has ended a frame early.
void Console::grey_rest() {
    uint8_t* pixels = framebuffers_.use(m_.tia.current, config_.framebuffer_bytes());
    // A restored state may be in any line; after the framebuffer's end nothing is left.
    const int first = std::clamp(scan_lines() - config_.first_line, 0, config_.height);
    for (int i = first * kScreenWidth; i < config_.height * kScreenWidth; ++i)
        pixels[i] = static_cast<uint8_t>((pixels[i] & 15) >> 1);
}

}  // namespace atari
