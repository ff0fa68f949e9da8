// The reference core: a `Machine`, the chips that work on it, and the bus between them. Tests compare `FastConsole`
// with it.
//
// Each chip is a file of its own that includes no other chip:
//   Cpu (cpu/cpu.hpp)                   the processor; it reaches the others through the bus alone
//   Riot (riot.hpp)                     RAM, timer and ports
//   ReferenceTia (tia/tia.hpp)          the TIA's registers
//   TiaRenderer (tia/tia_renderer.hpp)  its pixels and collisions
//   Sound (tia/sound.hpp)               its two channels
//   CartridgeSlot (cartridge/)          the window that shows a cartridge: bankswitching.hpp, dpc.hpp
// A chip's state is a part of `Machine`. A bus access brings the address, the cycle count, and for some reads the byte
// last on the data bus; the chips compute their state from that count. `Console` decodes addresses, and does what
// concerns two chips: WSYNC, the end of a frame, and the reset.
//
// Behaviour is that of the reference (ale-py 0.12.1), also where real hardware differs.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "machine/cartridge/bankswitching.hpp"
#include "console_config.hpp"
#include "framebuffers.hpp"
#include "inline.hpp"
#include "random.hpp"
#include "state.hpp"
#include "machine/tia/tia.hpp"
#include "machine/tia/tia_renderer.hpp"

namespace atari {

class Console : protected CartridgeSlot::Listener {
  public:
    Console(std::shared_ptr<const Cartridge> cartridge, const ConsoleConfig& config);
    Console(const Console&) = delete;
    Console& operator=(const Console&) = delete;

    // Powers the console on for the first time, with random RAM. `reset` must follow.
    void construct(uint32_t seed = MachineRandom::kSeed);

    // Resets all chips; RAM keeps its contents.
    virtual void reset();
    // Replaces the timer value that a reset has drawn. `word` is from a generator of the caller.
    void set_timer(uint32_t word) { m_.riot.draw_timer(word); }

    // Emulates until the frame ends, for at most 25000 instructions.
    void run_frame();

    // Returns the number of scan lines since the frame began. Format detection takes more than 285 for PAL.
    int scan_lines() const { return m_.tia.lines(m_.cycles); }
    void set_config(const ConsoleConfig& config) {
        config_ = config;
        framebuffers_.fit(config.framebuffer_bytes());
    }
    const ConsoleConfig& config() const { return config_; }

    const Machine& machine() const { return m_; }
    Inputs& inputs() { return m_.inputs; }
    const uint8_t* ram() const { return m_.riot.ram; }
    // Accesses to RAM by `Environment` leave their value on the data bus. A program that runs in TIA space reads it.
    uint8_t read_ram(uint8_t address) { return m_.bus = m_.riot.ram[address & 0x7f]; }
    void poke_ram(uint8_t address, uint8_t value) { m_.bus = m_.riot.ram[address & 0x7f] = value; }
    void set_ram(const uint8_t* bytes) { std::copy_n(bytes, 128, m_.riot.ram); }
    const uint8_t* cartridge_ram() const { return slot_.ram.data(); }
    size_t cartridge_ram_size() const { return slot_.ram.size(); }
    // `FastConsole` renders a deferred frame when its framebuffer is read.
    const uint8_t* framebuffer() { return rendered(m_.tia.current); }
    const uint8_t* previous_framebuffer() { return rendered(m_.tia.current ^ 1); }
    Framebuffers& framebuffers() { return framebuffers_; }
    // Returns an identifier for the look of each row of a rendered framebuffer (LineCache::looks), or null if there are
    // none.
    const uint32_t* looks() const { return looks_of(m_.tia.current); }
    const uint32_t* previous_looks() const { return looks_of(m_.tia.current ^ 1); }
    const Cartridge& cartridge() const { return *slot_.inserted; }

    // Writes 512 samples, unsigned around 128, from the present values of the registers.
    void make_samples(uint8_t* out) { m_.sound.make_samples(out); }

    // Computes deferred collisions, so that the latches in `machine()` are complete.
    virtual void settle_latches() {}

    // The state as bytes. `load` returns false and changes nothing if the state is invalid.
    size_t state_size() const;
    void save(uint8_t* out);
    virtual bool load(const uint8_t* in);

    // The state in memory, which is faster. `restore` takes a snapshot of this console, or of one of the same kind,
    // cartridge and configuration.
    virtual std::unique_ptr<ConsoleSnapshot> snapshot() const;
    virtual void restore(const ConsoleSnapshot& snapshot);

    // The bus, as `Cpu` uses it. For tests: single instructions, the start of a frame, and rendering up to the latest
    // access.
    INLINE uint8_t read(uint16_t address) {
        uint8_t value;
        if (!(address & 0x1000)) value = read_chip(address);
        else if (slot_.is_plain(address)) value = *slot_.image_at(address);
        else value = slot_.read(address, m_.cycles);
        m_.bus = value;
        m_.cpu.last_access_was_read = true;
        return value;
    }
    void write(uint16_t address, uint8_t value);
    void spend(int cycles) { m_.cycles += static_cast<uint32_t>(cycles); }
    void run_instruction();
    // Returns the image byte at an address, or null if the address maps anything else.
    const uint8_t* image_at(uint16_t address) const {
        return (address & 0x1000) && slot_.is_plain(address) ? slot_.image_at(address) : nullptr;
    }
    void start_frame();
    void catch_up() { renderer_.catch_up(); }
    Machine& raw_machine() {
        renderer_.touch(kAllObjects);
        return m_;
    }

  protected:
    // Overridden by `FastConsole`, which defers work. All but `write_tia`, `before_tia_read` and `segments_changed` are
    // called a few times a frame at most.
    virtual void emulate_frame(bool whole);  // to the frame's end; `whole`: from its start
    virtual void write_tia(uint8_t reg, uint8_t value);
    virtual void before_tia_read(int reg) { tia_.prepare_read(reg, m_.cycles); }
    virtual void end_frame();
    virtual const uint8_t* rendered(int buffer) { return framebuffers_[buffer]; }
    virtual const uint32_t* looks_of(int) const { return nullptr; }

    // bus.cpp
    uint8_t read_chip(uint16_t address);
    void halt_until_line_start();

    void rebase_cycles();
    uint32_t machine_word() { return random_.at(m_.random_words++); }

    // Copies a snapshot's framebuffers from `skipped` bytes on. If `swapped`, current and previous are exchanged.
    void snapshot_into(ConsoleSnapshot& snapshot, const std::size_t (&skipped)[2]) const;
    void restore_from(const ConsoleSnapshot& snapshot, bool swapped);

    Machine m_{};
    CartridgeSlot slot_;
    ConsoleConfig config_;
    Framebuffers framebuffers_;
    TiaRenderer renderer_{m_.tia, config_, framebuffers_};
    ReferenceTia tia_{m_.tia, config_, renderer_};
    MachineRandom random_;
};

}  // namespace atari
