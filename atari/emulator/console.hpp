// The console: processor, bus, RIOT, TIA and cartridge around one `Machine`.
//
// The processor charges an instruction's whole cost right after the opcode fetch, so every access of an instruction
// happens at the cycle count of its end; the chips compute what they need from that count when they are accessed.
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
#include "collider.hpp"
#include "collision_cache.hpp"
#include "masks.hpp"
#include "random.hpp"
#include "line_cache.hpp"
#include "pictures.hpp"
#include "state.hpp"

namespace atari {

// The pixels of an object as it now is.
Mask object_mask(const Tia& tia, int object);

// Made where it is wanted: a copy right behind its making would wait for the words to arrive in memory.
inline void make_mask(Mask& mask, const Tia& tia, int object) { new (&mask) Mask(object_mask(tia, object)); }

// The DPC chip's next random number behind each.
inline constexpr auto kDpcRandom = [] {
    std::array<uint8_t, 256> table{};
    for (unsigned random = 0; random < 256; ++random) {
        const unsigned bit = ~(random >> 7 ^ random >> 5 ^ random >> 4 ^ random >> 3) & 1;
        table[random] = static_cast<uint8_t>(random << 1 | bit);
    }
    return table;
}();

// What does not change while a game is loaded.
struct ConsoleConfig {
    int first_line = 34;       // scan line of the first row of the picture
    int height = 210;          // rows of the picture
    bool pal = false;          // PAL rules: 342 lines, colour loss
    bool hmove_blanks = true;  // HMOVE blanks eight pixels at the left edge
    bool paddles[2] = {false, false};  // left and right jack; otherwise a joystick
    bool swap_ports = false;
    bool swap_paddles = false;

    // Of a picture, of which at least 200 rows are shown, and of what may be drawn behind it.
    std::size_t picture_bytes() const {
        return static_cast<std::size_t>(kScreenWidth * std::max(height, 200) + Pictures::kBehind);
    }
};

// So many cycles are at least 25000 instructions: up to here a frame cannot have met its limit of instructions.
inline constexpr uint32_t kCyclesBelowLimit = 2 * kInstructionLimit;

// A frame ends with its first write to the TIA behind line 342, and BRK, which writes three bytes, takes 7 cycles:
// no more writes than this need to be kept, two of its three with a note that they come at the same time.
inline constexpr int kLogSize = 344 * 76 * 5 / 7 + 16;

// The writes of a frame, with the TIA as it was at its beginning: all that is needed to draw it. Only what is written to
// takes memory, in pages, of which a log shares none with another.
struct alignas(4096) FrameLog {
    Tia start;
    int32_t reached;  // the clock of the frame's end
    int size;
    int replaced;     // pixels from the first on that the frame replaces
    int extent;       // and how far it may reach at most
    Write writes[kLogSize];
};

inline constexpr int kLogs = 4;

// What was last written to the TIA, so that a write that changes nothing can be left out.
struct Written {
    uint8_t reg[64];      // RESP0 and RESP1: strobed since the last NUSIZ, which ends what a strobe hides
    uint8_t old_grp0, old_grp1, old_enabl;  // values of GRP0, GRP1 and ENABL that the delayed copies have
    bool mirror_waits;    // CTRLPF's bit 0 was changed so late in a line that its end mirrors the playfield
    bool ark;             // Cosmic Ark's trick may have been played

    // No object has a motion for HMOVE.
    bool still() const {
        uint32_t players_and_missiles;
        std::memcpy(&players_and_missiles, reg + HMP0, 4);
        return !(players_and_missiles & 0xf0f0f0f0) && !(reg[HMBL] & 0xf0);
    }
    // CTRLPF is written; its value changes so.
    void mirror(uint8_t changes, uint32_t cycle_in_frame) {
        if ((changes & 1) || mirror_waits) mirror_waits = cycle_in_frame % 76 >= kMirrorsAtOnce;
    }

    // As a write to HMOVE brings them along.
    uint16_t motions() const {
        uint32_t players_and_missiles;
        std::memcpy(&players_and_missiles, reg + HMP0, 4);
        uint32_t nibbles = players_and_missiles >> 4 & 0x0f0f0f0f;
        nibbles = (nibbles | nibbles >> 4) & 0x00ff00ff;
        return static_cast<uint16_t>(nibbles | nibbles >> 8);
    }
    uint8_t ball_motion() const { return reg[HMBL] >> 4; }
    uint16_t beside_grp1() const { return static_cast<uint16_t>(old_grp0 | (old_enabl & 2) << 7); }
};

// A console's whole state, copied in memory as it is: pictures that have not been drawn yet as their logs.
struct ConsoleCopy {
    struct Log {
        bool used;
        Tia start;
        int32_t reached;
        int replaced, extent;
        std::vector<Write> writes;
    };
    Machine machine;
    std::vector<uint8_t> cart_ram;
    std::vector<uint8_t> pictures[2];  // only what is behind the picture where a log replaces all of that
    Log logs[kLogs];
    int log, last_log, owed[2], open_log;
    std::ptrdiff_t open_from;
    unsigned read_latches, watched_latches;
    bool cleared, plain;
    bool replaced[2];  // by picture: a log replaces all of it

    bool replaces_pictures() const { return replaced[0] && replaced[1]; }
};

class Console {
  public:
    // `plain`: by the plain interpreter and the plain TIA, the oracle of the fast ones.
    Console(std::shared_ptr<const Cartridge> cartridge, const ConsoleConfig& config, bool plain = true);

    // Powers on for the first time: random RAM. `reset` must follow.
    void construct();

    // The reset of all chips; RAM survives it.
    void reset();

    // Emulates until the frame ends, for at most 25000 instructions.
    void run_frame();

    // Whether the last frames look like PAL: more than 285 lines. For format detection.
    int scan_lines() const;
    void set_config(const ConsoleConfig& config) {
        config_ = config;
        pictures_.fit(config.picture_bytes());
    }
    const ConsoleConfig& config() const { return config_; }

    const Machine& machine() const { return m_; }
    Inputs& inputs() { return m_.inputs; }
    const uint8_t* ram() const { return m_.riot.ram; }
    // Accesses of RAM by the layer above leave their value on the data bus, which a program that runs in TIA space sees.
    uint8_t read_ram(uint8_t address) { return m_.bus = m_.riot.ram[address & 0x7f]; }
    void poke_ram(uint8_t address, uint8_t value) { m_.bus = m_.riot.ram[address & 0x7f] = value; }
    void set_ram(const uint8_t* bytes) { std::copy_n(bytes, 128, m_.riot.ram); }
    const uint8_t* cartridge_ram() const { return cart_ram_.data(); }
    size_t cartridge_ram_size() const { return cart_ram_.size(); }
    // Pictures of frames that were run fast are drawn when they are asked for.
    const uint8_t* picture() { return drawn(m_.tia.current); }
    const uint8_t* previous_picture() { return drawn(m_.tia.current ^ 1); }
    Pictures& pictures() { return pictures_; }
    // How their rows look (LineCache::looks), when they have been drawn; null if that is not known.
    const uint32_t* looks() const { return line_cache_ ? line_cache_->looks(m_.tia.current) : nullptr; }
    const uint32_t* previous_looks() const { return line_cache_ ? line_cache_->looks(m_.tia.current ^ 1) : nullptr; }
    const Cartridge& cartridge() const { return *cartridge_; }
    bool plain() const { return !logs_; }

    // 512 samples from the registers as they stand, unsigned around 128.
    void make_samples(uint8_t* out);

    // Makes `machine` what it would be if nothing was deferred; only collision latches can differ.
    void settle() { settle_latches(); }

    // The state as bytes, and back; `load` refuses (returns false, nothing changed) what no machine could have saved.
    size_t state_size() const;
    void save(uint8_t* out);
    bool load(const uint8_t* in);

    // The same in memory and much faster, for this console or one of the same cartridge and configuration.
    void copy_to(ConsoleCopy& copy) const;
    void copy_from(const ConsoleCopy& copy, bool swapped = false);
    // The same for a console that has come to where the copied one was in another way: in the same random words, with its
    // own sound, and perhaps with its pictures `swapped`.
    void follow(const ConsoleCopy& copy, bool swapped);

    // Bus accesses, single instructions, the beginning of a frame and drawing up to its latest access, for tests.
    uint8_t read(uint16_t address) {
        const unsigned offset = address & 0xfff;
        uint8_t value;
        if (!(address & 0x1000))
            value = read_chip(address);
        else if (offset - plain_.from < plain_.size)
            value = cartridge_->image()[segment_[address >> 10 & 15] + (offset & 0x3ff)];
        else
            value = read_cartridge(address);
        m_.bus = value;
        m_.cpu.last_access_was_read = true;
        return value;
    }
    void write(uint16_t address, uint8_t value);
    void run_instruction();
    // The image byte at an address, null where the window shows anything else.
    const uint8_t* image_at(uint16_t address) const {
        const bool plain = (address & 0x1000) && (address & 0xfffu) - plain_.from < plain_.size;
        return plain ? image_ + segment_[address >> 10 & 15] + (address & 0x3ff) : nullptr;
    }
    void start_frame();
    void catch_up() { draw_to(m_.tia.pending); }
    Machine& raw_machine() {
        stale_ = 0x3f;
        return m_;
    }

  private:
    friend struct FastCpu;  // fast_cpu.cpp
    friend struct Places;   // places.hpp

    uint8_t read_chip(uint16_t address);

    // deferred.cpp
    bool run_deferred();
    bool run_fast();
    void run_counted();
    void begin_log();
    void end_log();
    void keep_write(uint8_t reg, uint8_t value);
    // Not inlined, or the interpreter has a register less.
    [[gnu::noinline]] void keep_hmove(uint32_t cycles);
    [[gnu::noinline]] void keep_cxclr(uint32_t cycles);
    void apply_kept(int32_t clock);
    void read_latches(int reg);
    void settle_latches();
    void forget_logs();
    const uint8_t* drawn(int buffer);

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
    void map_segments();
    void map_pages();
    void map_cartridge_ram();

    // tia.cpp
    uint8_t read_tia(uint16_t address);
    void write_tia(uint8_t reg, uint8_t value);
    uint64_t input_from(int port) const;
    void time_inputs();
    template <typename T, typename V>
    void change(T& field, V value, unsigned objects);
    void write_nusiz(int player, uint8_t value);
    void write_graphics(int player, uint8_t value);
    void write_vblank(uint8_t value);
    void switch_dump(uint8_t old, uint8_t value);
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
    // Where so many are drawn next. Only a restored state may be further than a picture is long.
    uint8_t* next_pixels(int count) {
        const int32_t place = m_.tia.write_pos;
        const auto end = static_cast<std::size_t>(place + count) + Pictures::kBehind;
        return pictures_.use(m_.tia.current, std::max(config_.picture_bytes(), end)) + place;
    }
    void end_line();
    void paint(const Mask& p0, const Mask& p1, const Mask& pf, int x, int count);
    const Mask& mask(int object);
    bool enabled(int object) const;
    void touch(int object) { stale_ |= 1u << object; }

    void rebase_cycles();
    uint32_t machine_word() { return random_.at(m_.random_words++); }

    Machine m_{};

    // What the fast interpreter looks at, derived from the state or from the cartridge.
    bool deferred_ = false;         // writes to the TIA are kept in a log and applied later
    bool remapped_ = false;         // segment_ has changed
    Window plain_;                  // of the cartridge
    const uint8_t* image_;
    const Record* first_record_;
    const Record* base_record_;     // the record whose instruction is at `origin_`
    // In which 1 KiB segments any plain image is, a bit each by bits 10 to 13 of the address. All of such a segment may be
    // entered: where it is not plain image the record is kStep.
    uint32_t code_segments_ = 0;
    uint32_t origin_ = 0;
    uint32_t overlong_ = 0;         // from this cycle on, a write to the TIA ends the frame
    uint32_t cycle_limit_ = 0;      // from this cycle on, the limit of instructions may be near
    uint32_t first_cycle_ = 0;      // of line 0
    // `input_from` each port, in a frame that is run fast; nothing answers at the last two.
    uint64_t inputs_from_[8] = {0, 0, 0, 0, 0, 0, ~uint64_t{0}, ~uint64_t{0}};
    uint8_t overflow_ = 0;          // V is whether it is not 0
    uint8_t modes_ = 0;             // D and I as in the status, and its two bits that are always set
    Write* log_end_ = nullptr;
    Written written_{};
    // Where in the image the 1 KiB segments of the window are, by bits 10 to 13 of the address.
    uint32_t segment_[16] = {};
    const uint8_t* bank_ = nullptr;  // the image from segment_[12] on
    // The bytes of each 64 that can be read without side effects, RAM or plain image, by bits 6 to 13 of the address.
    const uint8_t* pages_[256] = {};

    // Code in RAM: records, and the bytes they were made from.
    struct RamCode {
        std::array<uint8_t, 4> bytes;  // three, and 0
        uint16_t handler = kHandlers;
    };
    Record ram_code_[128 + 3];
    RamCode ram_known_[128];

    std::vector<uint8_t> cart_ram_;
    Pictures pictures_;
    std::shared_ptr<const Cartridge> cartridge_;
    ConsoleConfig config_;
    MachineRandom random_;
    bool watches_tia_;         // the cartridge reacts to accesses of the TIA (3F, 3E, UA)

    // Deferred drawing: the logs of the frame that is being run, of the two before it, and of the one drawn last.
    std::unique_ptr<FrameLog[]> logs_;  // of kLogs
    int log_ = 0;                       // the one in use
    int last_log_ = -1;                 // that of the frame before, if it had one
    int owed_[2] = {-1, -1};            // by picture: the log that is still to be drawn into it, or -1
    Collider collider_{m_.tia, config_};
    std::unique_ptr<LineCache> line_cache_;  // draws
    const Write* applied_ = nullptr;          // up to here the TIA's state contains the log
    const Write* collisions_from_ = nullptr;  // the last CXCLR, or the beginning of the log
    int32_t end_clock_ = 0;                   // of the write that ended the frame
    std::unique_ptr<Machine> before_;         // the machine before the frame, to run it again if it is too long
    std::vector<uint8_t> cart_ram_before_;

    // Deferred collisions: latches that the game has not read so far are not kept up to date in frames behind one that
    // cleared them all. They are found in the logs if they are read after all: `open_log_` is the log that has the
    // first of the writes they need, from `open_from_` on; -1 if all latches are known.
    unsigned read_latches_ = 0, watched_latches_ = 0xffff;
    bool cleared_ = false;  // by the frame that is being run, or by the last one
    int open_log_ = -1;
    const Write* open_from_ = nullptr;

    Mask masks_[6];            // of the objects, made when needed
    unsigned stale_ = 0x3f;    // which of them are out of date
    CollisionCache collision_cache_{m_.tia, collider_};
};

}  // namespace atari
