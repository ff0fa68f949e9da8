// The reference core: processor, bus, RIOT, TIA and cartridge around one `Machine`. `FastConsole` is tested against it.
//
// The processor adds an instruction's whole cost right after the opcode fetch. So every access of an instruction
// happens at the cycle count of its end. The chips compute their state from that count when they are accessed.
// Behaviour is that of the reference (ale-py 0.12.1), also where real hardware differs.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <new>
#include <vector>

#include "cartridge.hpp"
#include "framebuffers.hpp"
#include "masks.hpp"
#include "random.hpp"
#include "state.hpp"

namespace atari {

// Returns the pixels of an object in its present state.
Mask object_mask(const Tia& tia, int object);

// Constructs the mask in place: a copy right after the construction would stall on its stores.
inline void make_mask(Mask& mask, const Tia& tia, int object) { new (&mask) Mask(object_mask(tia, object)); }

// The next random number of the DPC chip, by the current one.
inline constexpr auto kDpcRandom = [] {
    std::array<uint8_t, 256> table{};
    for (unsigned random = 0; random < 256; ++random) {
        const unsigned bit = ~(random >> 7 ^ random >> 5 ^ random >> 4 ^ random >> 3) & 1;
        table[random] = static_cast<uint8_t>(random << 1 | bit);
    }
    return table;
}();

// The settings of a console that stay constant while a game is loaded.
struct ConsoleConfig {
    int first_line = 34;               // scan line of the framebuffer's first row
    int height = 210;                  // rows of the framebuffer
    bool pal = false;                  // PAL rules: 342 lines, colour loss
    bool hmove_blanks = true;          // HMOVE blanks eight pixels at the left edge
    bool paddles[2] = {false, false};  // left and right jack; otherwise a joystick
    bool swap_ports = false;
    bool swap_paddles = false;

    // The size of a framebuffer: at least 200 rows, and an HMOVE blank after the last.
    std::size_t framebuffer_bytes() const {
        return static_cast<std::size_t>(kScreenWidth * std::max(height, 200) + Framebuffers::kMargin);
    }
};

// A snapshot of a console in memory. Each class of console has its own snapshot class and restores only that.
struct ConsoleSnapshot {
    virtual ~ConsoleSnapshot() = default;

    Machine machine;
    std::vector<uint8_t> cart_ram;
    std::vector<uint8_t> framebuffers[2];  // the last bytes of each; `FastConsole` omits rows that it renders again
};

class Console {
  public:
    Console(std::shared_ptr<const Cartridge> cartridge, const ConsoleConfig& config);
    virtual ~Console() = default;
    Console(const Console&) = delete;
    Console& operator=(const Console&) = delete;

    // Powers the console on for the first time, with random RAM. `reset` must follow.
    void construct(uint32_t seed = MachineRandom::kSeed);

    // Resets all chips; RAM keeps its contents.
    virtual void reset();
    // Replaces what a reset has drawn for the timer, for a generator of the caller's.
    void set_timer(uint32_t word) { m_.riot.timer = static_cast<uint8_t>(25 + word % 75); }

    // Emulates until the frame ends, for at most 25000 instructions.
    void run_frame();

    // Returns the number of scan lines since the frame began. Format detection takes more than 285 for PAL.
    int scan_lines() const;
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
    const uint8_t* cartridge_ram() const { return cart_ram_.data(); }
    size_t cartridge_ram_size() const { return cart_ram_.size(); }
    // `FastConsole` renders a deferred frame when its framebuffer is read.
    const uint8_t* framebuffer() { return rendered(m_.tia.current); }
    const uint8_t* previous_framebuffer() { return rendered(m_.tia.current ^ 1); }
    Framebuffers& framebuffers() { return framebuffers_; }
    // Returns an identifier for the look of each row of a rendered framebuffer (LineCache::looks), or null if there are
    // none.
    const uint32_t* looks() const { return looks_of(m_.tia.current); }
    const uint32_t* previous_looks() const { return looks_of(m_.tia.current ^ 1); }
    const Cartridge& cartridge() const { return *cartridge_; }

    // Writes 512 samples, unsigned around 128, from the present values of the registers.
    void make_samples(uint8_t* out);

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

    // For tests: bus accesses, single instructions, the start of a frame, and rendering up to the latest access.
    uint8_t read(uint16_t address) {
        const unsigned offset = address & 0xfff;
        uint8_t value;
        if (!(address & 0x1000)) value = read_chip(address);
        else if (offset - plain_.from < plain_.size)
            value = cartridge_->image()[segment_[address >> 10 & 15] + (offset & 0x3ff)];
        else value = read_cartridge(address);
        m_.bus = value;
        m_.cpu.last_access_was_read = true;
        return value;
    }
    void write(uint16_t address, uint8_t value);
    void run_instruction();
    // Returns the image byte at an address, or null if the address maps anything else.
    const uint8_t* image_at(uint16_t address) const {
        const bool plain = (address & 0x1000) && (address & 0xfffu) - plain_.from < plain_.size;
        return plain ? image_ + segment_[address >> 10 & 15] + (address & 0x3ff) : nullptr;
    }
    void start_frame();
    void catch_up() { render_to(m_.tia.pending); }
    Machine& raw_machine() {
        touch_all();
        return m_;
    }

  protected:
    // Overridden by `FastConsole`, which defers work. All but `write_tia`, `before_tia_read` and `map_segments` are
    // called a few times a frame at most.
    virtual void emulate_frame(bool whole);  // to the frame's end; `whole`: from its start
    virtual void write_tia(uint8_t reg, uint8_t value);
    virtual void before_tia_read(int reg);  // brings the TIA's state up to a read of a register
    virtual void end_frame();
    virtual void map_segments();
    virtual const uint8_t* rendered(int buffer) { return framebuffers_[buffer]; }
    virtual const uint32_t* looks_of(int) const { return nullptr; }

    uint8_t read_chip(uint16_t address);

    // cpu.cpp
    template <int operation, int form>
    void execute(int penalty);
    template <int form>
    uint16_t effective_address(int penalty);
    uint8_t fetch() { return read(m_.cpu.pc++); }
    void push(uint8_t value);
    uint8_t pull();
    void adc(uint8_t operand);
    void sbc(uint8_t operand);
    void arr(uint8_t operand);
    void branch(bool taken);
    void run_cpu();

    // riot.cpp
    uint8_t read_riot(uint16_t address);
    void write_riot(uint16_t address, uint8_t value);
    uint8_t switch_a() const;
    uint8_t read_timer();

    // bankswitching.cpp
    uint8_t read_cartridge(uint16_t address);
    void write_cartridge(uint16_t address, uint8_t value);
    void select_slice(uint16_t offset, uint8_t value);
    bool cartridge_answers(uint16_t address);
    void cartridge_watches(uint16_t address, uint8_t value);
    void hotspot(uint16_t offset, bool reading);
    uint8_t read_dpc(uint16_t offset);
    uint8_t read_fetcher(unsigned offset);
    uint8_t dpc_music();
    void write_dpc(uint16_t offset, uint8_t value);
    void clock_dpc_random() { m_.cart.random = kDpcRandom[m_.cart.random]; }
    void switch_dpc_bank(uint16_t offset);
    void update_dpc_music();
    void reset_cartridge();

    // tia.cpp
    uint8_t read_tia(uint16_t address);
    uint64_t input_from(int port) const;
    template <typename T, typename V>
    void change(T& field, V value, unsigned objects);
    void write_nusiz(int player, uint8_t value);
    void write_graphics(int player, uint8_t value);
    void write_vblank(uint8_t value);
    bool switch_dump(uint8_t old, uint8_t value);  // returns whether the inputs' charging times change
    void write_vsync(uint8_t value);
    void halt_until_line_start();
    void reset_player(int player, int hpos);
    void reset_missile(int missile, int hpos);
    void reset_ball(int hpos);
    void hmove(int cycle_in_line);
    void release_missile(int missile, uint8_t value);
    // Clocks are 32 bits and wrap, as in the reference: a program that never ends a frame gets there.
    int32_t clock(uint32_t later = 0) const { return static_cast<int32_t>(3 * m_.cycles + later); }
    uint32_t clocks_since(int32_t stamp) const { return 3 * m_.cycles - static_cast<uint32_t>(stamp); }
    int line_clock() const { return static_cast<int>(clocks_since(m_.tia.frame_start) % kClocksPerLine); }
    void reset_tia();
    void grey_rest();

    // tia_renderer.cpp
    void render_to(int32_t clock);
    void render_span(int x, int count);
    // Memory for the next `count` pixels. Only a restored state may have a position after the framebuffer's end.
    uint8_t* next_pixels(int count) {
        const int32_t place = m_.tia.write_pos;
        const auto end = static_cast<std::size_t>(place + count) + Framebuffers::kMargin;
        return framebuffers_.use(m_.tia.current, std::max(config_.framebuffer_bytes(), end)) + place;
    }
    void end_line();
    void paint(const Mask& p0, const Mask& p1, const Mask& pf, int x, int count);
    const Mask& mask(int object);
    bool enabled(int object) const;
    void touch(int object) { stale_ |= 1u << object; }
    void touch_all() { stale_ = kAllObjects; }

    void rebase_cycles();
    uint32_t machine_word() { return random_.at(m_.random_words++); }

    // Copies a snapshot's framebuffers from `skipped` bytes on. If `swapped`, current and previous are exchanged.
    void snapshot_into(ConsoleSnapshot& snapshot, const std::size_t (&skipped)[2]) const;
    void restore_from(const ConsoleSnapshot& snapshot, bool swapped);

    Machine m_{};
    Window plain_;  // of the cartridge
    const uint8_t* image_;
    // Offsets in the image of the window's 1 KiB segments, by bits 10 to 13 of the address.
    uint32_t segment_[16] = {};
    std::vector<uint8_t> cart_ram_;
    bool watches_tia_;  // of the cartridge
    std::shared_ptr<const Cartridge> cartridge_;
    ConsoleConfig config_;
    Framebuffers framebuffers_;
    MachineRandom random_;

    Mask masks_[6];                 // of the objects, computed when needed
    unsigned stale_ = kAllObjects;  // which of them are out of date
};

}  // namespace atari
