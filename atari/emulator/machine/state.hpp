// The state of the machine's chips as one trivially copyable struct without pointers.
//
// A snapshot of a `Console` has three more things: the RAM of cartridges that have some, the two framebuffers, and, of
// a `FastConsole`, its `FrameHistory`: deferred frames and deferred collisions. The ROM image is constant, and object
// masks are derived, so neither is part of the state.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <type_traits>

namespace atari {

inline constexpr int kScreenWidth = 160;
inline constexpr int kCyclesPerLine = 76;
inline constexpr int kClocksPerLine = 3 * kCyclesPerLine;
inline constexpr int kHblankClocks = kClocksPerLine - kScreenWidth;  // at the start of a line
inline constexpr int kHmoveBlank = 8;                                // pixels that HMOVE makes black
inline constexpr int kFrameRows = 300;
inline constexpr int kFrameBytes = kScreenWidth * kFrameRows;
inline constexpr int kAudioSamples = 512;  // of one act, at 31400 Hz
inline constexpr int kInstructionLimit = 25000;
// A TIA write after this line ends the frame.
constexpr int last_line(bool pal) { return pal ? 342 : 290; }
inline constexpr int kMostLines = last_line(true) + 2;
inline constexpr int32_t kVsyncIdle = 0x7fffffff;

// A truth value in a byte. Unlike a `bool` it is defined for every byte that a damaged state may hold.
struct Flag {
    uint8_t value;
    Flag& operator=(bool on) {
        value = on;
        return *this;
    }
    operator bool() const { return value != 0; }
};

struct Cpu {
    uint16_t pc;
    uint8_t a, x, y, sp;
    Flag n, v, d, i, z, c;
    Flag stop;                  // the TIA has ended the frame
    Flag jammed;                // by an illegal opcode; only a reset ends it
    Flag last_access_was_read;  // WSYNC halts only then
};

struct Riot {
    uint8_t ram[128];
    uint8_t timer;  // as written
    uint8_t shift;  // 0, 3, 6 or 10
    uint8_t ddr_a;
    Flag read_after_expiry;
    int32_t set_at;  // cycle of the last write
    int32_t irq_at;  // cycle of the first read after expiry
};

enum MissileVariant : uint8_t { kPlain, kWide, kOff };  // the shape of missile 0 in the Cosmic Ark effect

// The state at the start of a line that, with the writes in the line, determines its look. Clocks are three a CPU
// cycle.
struct TiaCommon {
    int32_t drawn_to;    // the framebuffer is complete up to this clock
    int32_t pending;     // and may be rendered with the present state up to this one
    uint32_t playfield;  // 20 bits: PF0 high nibble, PF1, PF2
    uint8_t vblank, ctrlpf;
    uint8_t nusiz[2], colour[4];  // colour: P0, P1, PF, BK
    uint8_t grp[2], old_grp[2];
    Flag vdelp[2], enam[2], resmp[2];
    Flag enabl, old_enabl;
    Flag skip_first[2];  // a player's first copy is hidden until the end of the line
    Flag pf_reflect;     // as latched, not as in CTRLPF
    MissileVariant m0_variant;
    Flag hmove_blank, cosmic_ark;
    uint8_t ark_counter;
    uint8_t unused;  // always 0, because states are compared byte by byte
};

// Positions, which determine a line's look if their object is visible or is placed in it; see line_cache.hpp.
struct TiaPlaces {
    uint8_t pos[5];  // P0, P1, M0, M1, BL
    Flag refp[2], vdelbl;
    int32_t last_hmove;
};

struct TiaLine : TiaCommon, TiaPlaces {};

struct Tia : TiaLine {
    // frame_start is where line 0 of the current frame begins, 0 or a little before.
    int32_t frame_start, draw_start, draw_stop;
    int32_t to_line_end;  // clocks from drawn_to to the end of its line
    int32_t write_pos;    // next pixel in the current framebuffer
    int32_t vsync_done;   // from this clock on, clearing VSYNC ends the frame
    int32_t dump_off_cycle;
    int32_t last_line_count, current_line;
    uint16_t collisions;  // 15 latches, see collision_bit
    uint8_t hm[5];
    Flag dump_on;
    Flag partial;  // the frame has not ended: the next update continues it
    Flag greyed;
    uint8_t current;  // index of the framebuffer that is being rendered into
};

struct Sound {
    uint8_t audc[2], audf[2], audv[2];
    uint8_t counter[2], p4[2], p5[2];  // the generator

    void keep_generator_of(const Sound& other) {
        for (int i : {0, 1}) {
            counter[i] = other.counter[i];
            p4[i] = other.p4[i];
            p5[i] = other.p5[i];
        }
    }

    void write(uint8_t reg, uint8_t value);  // AUDC0 .. AUDV1: tia_registers.hpp
};

struct CartridgeState {
    uint8_t bank;      // also the slice of 3F and 3E
    uint8_t slice[4];  // E0: 1 KiB each; E7: [0] the low slice, [1] the RAM page; 3E: [1] RAM page, [2] RAM mapped
    // DPC (Pitfall II)
    uint8_t top[8], bottom[8], flag[8];
    uint16_t counter[8];
    Flag music[8];
    uint8_t random;
    int32_t stamp;
    double fraction;
};

// The state of controllers and console switches. `Environment` writes it between frames.
struct Inputs {
    uint8_t switches;  // SWCHB
    uint8_t stick[2];  // bits 0-3: up, down, left, right pressed; player A, player B
    Flag fire[2];
    int32_t resistance[4];  // of the paddles
    Flag paddle_fire[4];
};

struct Machine {
    uint32_t cycles;
    uint8_t bus;  // the byte last on the data bus
    Cpu cpu;
    Riot riot;
    Tia tia;
    CartridgeState cart;
    Inputs inputs;
    Sound sound;
    uint64_t random_words;  // drawn from the machine's generator
};

static_assert(std::is_trivially_copyable_v<Machine>);

}  // namespace atari
