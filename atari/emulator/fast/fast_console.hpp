// `FastConsole`: the same machine as `Console`, run by decoded instructions or translated code, with deferred rendering
// and deferred collisions.
//
// The TIA writes of a frame go to a write log. The TIA's state is brought up to date from the log when a program reads
// a collision latch, and at the frame's end. The framebuffer is rendered from the log when it is read. A frame that
// cannot be deferred runs again without a log, with every instruction counted.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "fast/tia/collider.hpp"
#include "fast/tia/collision_cache.hpp"
#include "machine/console.hpp"
#include "fast_cartridge.hpp"
#include "frame_history.hpp"
#include "fast/tia/line_cache.hpp"
#include "fast/tia/tia_shadow.hpp"

namespace atari {

// An instruction takes at least two cycles, so before this cycle a frame cannot have reached the instruction limit.
inline constexpr uint32_t kCyclesBelowLimit = 2 * kInstructionLimit;

struct FastConsoleSnapshot final : ConsoleSnapshot {
    FrameHistory::Snapshot history;
    bool replaced[2];  // by framebuffer: the frame that it is owed replaces all of its pixels

    bool replaces_framebuffers() const { return replaced[0] && replaced[1]; }
};

class FastConsole final : public Console {
  public:
    FastConsole(std::shared_ptr<const FastCartridge> cartridge, const ConsoleConfig& config);

    void reset() override;
    void settle_latches() override;
    bool load(const uint8_t* in) override;
    std::unique_ptr<ConsoleSnapshot> snapshot() const override;
    void restore(const ConsoleSnapshot& snapshot) override;
    // `restore` for a reset trace. This console is in the state in which the trace began, but has another past. It
    // keeps its position in the machine's random words, its sound generator and rows after the framebuffers' last ones.
    // If `swapped`, its framebuffers are exchanged.
    void resume(const ConsoleSnapshot& snapshot, bool swapped);

    const FastCartridge& cartridge() const { return program_; }

    // Returns the log of the frame that ran last, or null if that frame is rendered.
    const FrameLog* deferred_frame() const { return history_.owed(m_.tia.current); }

  private:
    friend struct Interpreter;  // interpreter.cpp
    friend struct Offsets;      // offsets.hpp

    void emulate_frame(bool whole) override;
    void write_tia(uint8_t reg, uint8_t value) override {
        deferred_ ? log_write(reg, value) : Console::write_tia(reg, value);
    }
    void before_tia_read(int reg) override;
    void end_frame() override;
    void segments_changed() override;
    const uint8_t* rendered(int buffer) override;
    const uint32_t* looks_of(int buffer) const override { return line_cache_.looks(buffer); }

    bool run_deferred();
    bool run_fast();     // interpreter.cpp
    void run_counted();  // interpreter.cpp
    void begin_log();
    int32_t rendered_by(int32_t clock);
    bool ends_in_blanked_line();
    void end_log();
    void log_write(uint8_t reg, uint8_t value);
    // Not inlined, because the interpreter would have one register less.
    [[gnu::noinline]] void log_hmove(uint32_t cycles);
    [[gnu::noinline]] void log_cxclr(uint32_t cycles);
    void apply_log(int32_t clock);
    void update_latches(int reg, int32_t clock);
    // Returns bits 7 and 6 of one of CXM0P .. CXPPMM, read by a handler while a frame is deferred: at least nine clocks
    // after the last write, which has taken effect.
    uint32_t read_latches(uint32_t reg) {
        update_latches(static_cast<int>(reg), clock_at(m_.cycles));
        return (m_.tia.collisions >> (14 - 2 * reg) & 3u) << 6;
    }
    void find_pending_latches();
    void time_inputs();
    void map_pages();
    void map_cartridge_ram();
    void restore_all(const ConsoleSnapshot& snapshot, bool swapped);
    void break_off_history();

    // Read by the interpreter and by translated code; derived from the state or from the cartridge.
    bool deferred_ = false;         // the TIA writes of the frame that is running go to the log
    bool remapped_ = false;         // slot_.segment has changed
    const FastCartridge& program_;  // the same cartridge as slot_.inserted
    const DecodedInstruction* first_instruction_;
    const DecodedInstruction* base_instruction_;  // the decoded instruction at `origin_`
    // The 1 KiB segments that contain plain image, as a set of bits, by bits 10 to 13 of the address. A program may
    // enter all of such a segment: a decoded instruction outside plain image is kStep.
    uint32_t code_segments_ = 0;
    uint32_t origin_ = 0;
    uint32_t deadline_ = 0;  // from this cycle on, a write to the TIA ends the frame
    // Element n is the deadline less n cycles. In translated code a write may come n cycles after the cycles added so
    // far. It compares them with element n instead of computing a sum.
    static constexpr int kDeadlines = 80;
    uint32_t deadlines_[kDeadlines] = {};
    uint32_t cycle_limit_ = 0;  // from this cycle on, the instruction limit may be near
    uint32_t first_cycle_ = 0;  // the first cycle of line 0
    // By port, the value of `input_from` in a frame run by `run_fast`. The last two addresses have no port.
    uint64_t inputs_from_[8] = {0, 0, 0, 0, 0, 0, ~uint64_t{0}, ~uint64_t{0}};
    uint8_t overflow_ = 0;         // not 0 if V is set
    uint8_t modes_ = 0;            // D and I as in the status register, and its two bits that are always set
    TiaWrite* log_end_ = nullptr;  // end of the log of the frame that is running
    TiaShadow shadow_{};
    const uint8_t* bank_ = nullptr;  // the image from slot_.segment[12] on
    // By bits 6 to 13 of the address, the 64 bytes there if they are RAM or plain image, which can be read without side
    // effects; otherwise null.
    const uint8_t* pages_[256] = {};

    // Code in RAM: decoded instructions, and the bytes that they were decoded from.
    struct RamCode {
        std::array<uint8_t, 4> bytes;  // three bytes, and 0
        uint16_t handler = kHandlers;
    };
    DecodedInstruction ram_code_[128 + 3];
    RamCode ram_known_[128];

    FrameHistory history_;
    LineCache line_cache_{config_};  // renders logs
    Collider collider_{m_.tia, config_};
    CollisionCache collision_cache_{m_.tia, collider_};
    const TiaWrite* applied_ = nullptr;          // the TIA's state contains the log up to here
    const TiaWrite* collisions_from_ = nullptr;  // the last CXCLR, or the beginning of the log
    int32_t end_clock_ = 0;                      // clock of the write that ended the frame

    // The state before the frame, from which the frame runs again if it cannot be deferred.
    Machine machine_before_;
    std::vector<uint8_t> cart_ram_before_;
};

}  // namespace atari
