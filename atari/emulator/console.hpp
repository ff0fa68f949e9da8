// The console: processor, bus, RIOT, TIA and cartridge around one `Machine`.
//
// The processor charges an instruction's whole cost right after the opcode fetch, so every access of an instruction
// happens at the cycle count of its end; the chips compute what they need from that count when they are accessed.
// Behaviour is that of the reference (ale-py 0.12.1), also where real hardware differs.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "cartridge.hpp"
#include "masks.hpp"
#include "random.hpp"
#include "state.hpp"

namespace atari {

// What does not change while a game is loaded.
struct ConsoleConfig {
    int first_line = 34;       // scan line of the first row of the picture
    int height = 210;          // rows of the picture
    bool pal = false;          // PAL rules: 342 lines, colour loss
    bool hmove_blanks = true;  // HMOVE blanks eight pixels at the left edge
    bool paddles[2] = {false, false};  // left and right jack; otherwise a joystick
    bool swap_ports = false;
    bool swap_paddles = false;
};

class Console {
  public:
    Console(std::shared_ptr<const Cartridge> cartridge, const ConsoleConfig& config);

    // Powers on for the first time: random RAM. `reset` must follow.
    void construct();

    // The reset of all chips; RAM survives it.
    void reset();

    // Emulates until the frame ends, for at most 25000 instructions.
    void run_frame();

    // Whether the last frames look like PAL: more than 285 lines. For format detection.
    int scan_lines() const;
    void set_config(const ConsoleConfig& config) { config_ = config; }
    const ConsoleConfig& config() const { return config_; }

    const Machine& machine() const { return m_; }
    Inputs& inputs() { return m_.inputs; }
    const uint8_t* ram() const { return m_.riot.ram; }
    // Accesses of RAM by the layer above leave their value on the data bus, which a program that runs in TIA space sees.
    uint8_t read_ram(uint8_t address) { return m_.bus = m_.riot.ram[address & 0x7f]; }
    void poke_ram(uint8_t address, uint8_t value) { m_.bus = m_.riot.ram[address & 0x7f] = value; }
    const uint8_t* cartridge_ram() const { return cart_ram_.data(); }
    size_t cartridge_ram_size() const { return cart_ram_.size(); }
    const uint8_t* picture() const { return pictures_[m_.tia.current]; }
    const uint8_t* previous_picture() const { return pictures_[m_.tia.current ^ 1]; }
    const Cartridge& cartridge() const { return *cartridge_; }

    // 512 samples from the registers as they stand, unsigned around 128.
    void make_samples(uint8_t* out);

    // The state as bytes, and back; `load` refuses (returns false, nothing changed) what no machine could have saved.
    size_t state_size() const;
    void save(uint8_t* out) const;
    bool load(const uint8_t* in);

    // Bus accesses, single instructions, the beginning of a frame and drawing up to its latest access, for tests.
    uint8_t read(uint16_t address) {
        const unsigned offset = address & 0xfff;
        uint8_t value;
        if (!(address & 0x1000))
            value = read_chip(address);
        else if (offset - plain_from_ < plain_size_)
            value = cartridge_->image()[segment_[offset >> 10] + (offset & 0x3ff)];
        else
            value = read_cartridge(address);
        m_.bus = value;
        m_.cpu.last_access_was_read = true;
        return value;
    }
    void write(uint16_t address, uint8_t value);
    void run_instruction();
    void start_frame();
    void catch_up() { draw_to(m_.tia.pending); }
    Machine& raw_machine() {
        stale_ = 0x3f;
        return m_;
    }

  private:
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
    void write_dpc(uint16_t offset, uint8_t value);
    void clock_dpc_random();
    void switch_dpc_bank(uint16_t offset);
    void update_dpc_music();
    void reset_cartridge();
    void map_segments();

    // tia.cpp
    uint8_t read_tia(uint16_t address);
    void write_tia(uint8_t reg, uint8_t value);
    bool paddle_charged(int32_t resistance) const;
    uint8_t input_port(int port) const;
    template <typename T, typename V>
    void change(T& field, V value, unsigned objects);
    void write_nusiz(int player, uint8_t value);
    void write_graphics(int player, uint8_t value);
    void write_vblank(uint8_t value);
    void write_vsync(uint8_t value);
    void halt_until_line_start();
    void reset_player(int player, int hpos);
    void reset_missile(int missile, int hpos);
    void reset_ball(int hpos);
    void hmove(int cycle_in_line);
    void release_missile(int missile, uint8_t value);
    void end_frame();
    // Clocks are 32 bits and wrap, as in the reference: a program that never ends a frame gets there.
    int32_t clock(uint32_t later = 0) const { return static_cast<int32_t>(3 * m_.cycles + later); }
    uint32_t clocks_since(int32_t stamp) const { return 3 * m_.cycles - static_cast<uint32_t>(stamp); }
    int line_clock() const { return static_cast<int>(clocks_since(m_.tia.frame_start) % 228); }
    void reset_tia();
    void grey_rest();

    // picture.cpp
    void draw_to(int32_t clock);
    void draw_span(int x, int count);
    void end_line();
    void paint(const Mask& p0, const Mask& p1, const Mask& pf, int x, int count);
    const Mask& mask(int object);
    bool enabled(int object) const;
    uint8_t shown_graphics(int player) const;
    void touch(int object) { stale_ |= 1u << object; }

    void rebase_cycles();
    uint32_t machine_word() { return random_.at(m_.random_words++); }

    Machine m_{};
    std::vector<uint8_t> cart_ram_;
    uint8_t pictures_[2][kFrameBytes + 96];  // 96: a blank of HMOVE may reach past the last row drawn
    std::shared_ptr<const Cartridge> cartridge_;
    ConsoleConfig config_;
    MachineRandom random_;
    bool watches_tia_;         // the cartridge reacts to accesses of the TIA (3F, 3E, UA)

    // Derived from the state: where in the image the four 1 KiB segments of the window are, and which part of the
    // window (plain_size_ bytes from plain_from_) is plain image, without RAM, registers or hotspots.
    uint32_t segment_[4] = {0, 0, 0, 0};
    unsigned plain_from_ = 0, plain_size_ = 0;
    Mask masks_[6];            // of the objects, made when needed
    unsigned stale_ = 0x3f;    // which of them are out of date
};

enum Object { kP0, kP1, kM0, kM1, kBL, kPF };

}  // namespace atari
