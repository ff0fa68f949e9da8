// `TiaShadow`, the shadow copy of the TIA's registers. It decides which of a program's TIA writes the write log needs.
#pragma once

#include <cstdint>
#include <cstring>

#include "machine/state.hpp"
#include "machine/tia/tia_registers.hpp"
#include "write_log.hpp"

namespace atari {

// The last value written to each TIA register, in a frame whose TIA writes go to a log. The TIA's own state is older
// until the log is applied to it.
// Each `write_...` stores a value and returns whether the write can change anything, so that the log needs it. A write
// that is left out would not delay the next one: writes are at least nine clocks apart, and no delay is longer. Reads
// keep the same distance, except those of instructions in TIA space. A program there has stored by `log_write`
// (decoder.cpp).
struct TiaShadow {
    uint8_t reg[64];  // RESP0, RESP1: strobed since the last NUSIZ, which ends the strobe's hiding
    uint8_t old_grp0, old_grp1, old_enabl;  // values of GRP0, GRP1 and ENABL in the delayed copies
    bool late_reflect;  // late reflect: CTRLPF bit 0 changed so late that it takes effect at the line's end
    bool ark;           // the Cosmic Ark motion effect may be active

    // Makes this the shadow of a TIA whose state is up to date.
    void fill(const Tia& t) {
        reg[VBLANK] = t.vblank;
        for (int i = 0; i < 4; ++i) reg[COLUP0 + i] = t.colour[i] & bits_of(COLUP0);
        reg[PF0] = static_cast<uint8_t>(t.playfield << 4);
        reg[PF1] = static_cast<uint8_t>(t.playfield >> 4);
        reg[PF2] = static_cast<uint8_t>(t.playfield >> 12);
        for (int i = 0; i < 2; ++i) {
            reg[REFP0 + i] = t.refp[i] ? bits_of(REFP0) : 0;
            reg[GRP0 + i] = t.grp[i];
            reg[ENAM0 + i] = t.enam[i] ? bits_of(ENAM0) : 0;
            reg[VDELP0 + i] = t.vdelp[i] ? bits_of(VDELP0) : 0;
            reg[RESMP0 + i] = t.resmp[i] ? bits_of(RESMP0) : 0;
            reg[NUSIZ0 + i] = t.nusiz[i];
            reg[RESP0 + i] = t.skip_first[i] ? 1 : 0;
        }
        reg[ENABL] = t.enabl ? bits_of(ENABL) : 0;
        reg[VDELBL] = t.vdelbl ? bits_of(VDELBL) : 0;
        for (int i = 0; i < 5; ++i) reg[HMP0 + i] = static_cast<uint8_t>(t.hm[i] << 4);
        old_grp0 = t.old_grp[0];
        old_grp1 = t.old_grp[1];
        old_enabl = t.old_enabl ? bits_of(ENABL) : 0;
        reg[CTRLPF] = t.ctrlpf;
        late_reflect = t.pf_reflect != (t.ctrlpf & kReflects);
        ark = t.cosmic_ark || t.m0_variant != kPlain;
    }

    // A write to a register that only holds its value.
    bool write_value(uint32_t r, uint8_t value) {
        if (reg[r] == value) return false;
        reg[r] = value;
        return true;
    }

    bool write_nusiz(uint32_t r, uint8_t value) {
        uint8_t& strobed = reg[r + (RESP0 - NUSIZ0)];
        if (reg[r] == value && !strobed && !ark) return false;
        reg[r] = value;
        strobed = 0;
        return true;
    }

    // HMP0 .. HMBL act when HMOVE is written. Only the Cosmic Ark effect makes one act at once.
    bool write_motion(uint32_t r, uint8_t value) {
        const bool trick = may_play_ark(static_cast<uint8_t>(r), reg[r], value);
        reg[r] = value;
        ark |= trick;
        return trick;
    }
    void clear_motions() { std::memset(reg + HMP0, 0, 5); }

    // A write to GRP0 also copies GRP1 to its delayed copy.
    bool write_grp0(uint8_t value) {
        if (reg[GRP0] == value && old_grp1 == reg[GRP1]) return false;
        reg[GRP0] = value;
        old_grp1 = reg[GRP1];
        return true;
    }
    // A write to GRP1 also copies GRP0 and ENABL to their delayed copies.
    bool write_grp1(uint8_t value) {
        if (reg[GRP1] == value && old_grp0 == reg[GRP0] && old_enabl == reg[ENABL]) return false;
        reg[GRP1] = value;
        old_grp0 = reg[GRP0];
        old_enabl = reg[ENABL];
        return true;
    }

    // After a late reflect an equal value can have an effect. `kind` becomes the register number of the log entry.
    bool write_ctrlpf(uint8_t value, uint32_t cycle_in_frame, uint8_t& kind) {
        const uint8_t changes = reg[CTRLPF] ^ value;
        kind = (changes & kShapesOfCtrlpf) || late_reflect ? CTRLPF : PRIORITY;
        if (!changes && !late_reflect) return false;
        if ((changes & kReflects) || late_reflect) late_reflect = cycle_in_frame % kCyclesPerLine >= kLateReflect;
        reg[CTRLPF] = value;
        return true;
    }

    // Returns whether no object has a motion for HMOVE.
    bool still() const {
        uint32_t players_and_missiles;
        std::memcpy(&players_and_missiles, reg + HMP0, 4);
        return !(players_and_missiles & 0xf0f0f0f0) && !(reg[HMBL] & 0xf0);
    }

    // Values of `TiaWrite::beside`. Under HMOVE: the motions of players and missiles. Under GRP0 and GRP1: the delayed
    // copies.
    uint16_t beside_hmove() const {
        uint32_t players_and_missiles;
        std::memcpy(&players_and_missiles, reg + HMP0, 4);
        uint32_t nibbles = players_and_missiles >> 4 & 0x0f0f0f0f;
        nibbles = (nibbles | nibbles >> 4) & 0x00ff00ff;
        return static_cast<uint16_t>(nibbles | nibbles >> 8);
    }
    uint8_t ball_motion() const { return reg[HMBL] >> 4; }
    uint16_t beside_grp0() const { return old_grp1; }
    uint16_t beside_grp1() const { return static_cast<uint16_t>(old_grp0 | (old_enabl & bits_of(ENABL)) << 7); }
};

}  // namespace atari
