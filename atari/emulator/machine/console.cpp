#include "console.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

namespace atari {

Console::Console(std::shared_ptr<const Cartridge> cartridge, const ConsoleConfig& config)
    : slot_(std::move(cartridge), m_.cart, *this), config_(config) {}

void Console::construct(uint32_t seed) {
    m_ = Machine{};
    random_ = MachineRandom(seed);
    std::fill(slot_.ram.begin(), slot_.ram.end(), uint8_t{0});
    for (uint8_t& byte : m_.riot.ram) byte = static_cast<uint8_t>(machine_word());
    m_.random_words += 1;  // the timer's first value, which the reset replaces
    m_.cart.random = 1;
    for (int k : {0, 1}) m_.sound.p4[k] = m_.sound.p5[k] = 1;
    m_.inputs.switches = 0x3f;
}

void Console::reset() {
    rebase_cycles();
    m_.riot.reset(machine_word());
    tia_.reset();
    framebuffers_.clear();
    slot_.reset(m_.cycles);
    for (size_t i = 0; i < cartridge().random_bytes(); ++i) slot_.ram[i] = static_cast<uint8_t>(machine_word());
    m_.cpu = Cpu{};
    m_.cpu.sp = 0xff;
    m_.cpu.last_access_was_read = true;
    const uint8_t low = read(0xfffc);
    m_.cpu.pc = static_cast<uint16_t>(low | read(0xfffd) << 8);
}

// Makes the current cycle number 0 and moves all time stamps by the same amount. Nothing else changes.
void Console::rebase_cycles() {
    m_.riot.rebase(m_.cycles);
    tia_.rebase(m_.cycles);
    slot_.rebase(m_.cycles);
    m_.cycles = 0;
}

void Console::start_frame() {
    const int32_t begun = m_.tia.line_clock(m_.cycles);  // clocks of the unfinished line; the phase of lines continues
    rebase_cycles();
    tia_.start_frame(begun);
}

void Console::run_frame() {
    Tia& t = m_.tia;
    const bool whole = !t.partial;
    if (whole) start_frame();
    t.partial = true;  // until a write ends the frame
    emulate_frame(whole);
    t.current_line = scan_lines();
    if (t.partial) {
        if (!t.greyed) renderer_.grey_from(t.current_line);
        t.greyed = true;
    } else {
        t.last_line_count = t.current_line;
        t.greyed = false;
    }
}

size_t Console::state_size() const { return sizeof(Machine) + slot_.ram.size() + 2 * kFrameBytes; }

void Console::save(uint8_t* out) {
    for (int buffer : {0, 1}) rendered(buffer);
    settle_latches();
    std::memcpy(out, &m_, sizeof m_);
    out += sizeof m_;
    std::copy(slot_.ram.begin(), slot_.ram.end(), out);
    out += slot_.ram.size();
    for (int buffer : {0, 1}) {
        framebuffers_.save(buffer, out);
        out += kFrameBytes;
    }
}

namespace {

// Returns whether every index in a machine is within its array. No other value can cause undefined behaviour.
bool sound_indices(const Machine& m, const Cartridge& cartridge) {
    const Tia& t = m.tia;
    const size_t banks = cartridge.type() == CartridgeType::k3F || cartridge.type() == CartridgeType::k3E
                             ? cartridge.size() / 2048
                             : std::max<size_t>(1, cartridge.size() / 4096);
    bool good = m.cart.bank < banks;
    for (uint8_t slice : m.cart.slice) good &= slice < (cartridge.type() == CartridgeType::k3E ? 32 : 8);
    for (uint16_t counter : m.cart.counter) good &= counter < 2048;
    for (uint8_t position : t.pos) good &= position < kScreenWidth;
    good &= t.current <= 1 && t.m0_variant <= kOff && t.ark_counter < 4;
    good &= t.to_line_end >= 0 && t.to_line_end <= kClocksPerLine && t.write_pos >= 0 && t.write_pos <= kFrameBytes;
    good &= t.playfield < 1u << 20;
    good &= m.riot.shift <= 10;
    good &= m.random_words < MachineRandom::kFurthest;
    for (int32_t resistance : m.inputs.resistance) good &= resistance >= 0;
    good &= std::abs(m.cart.fraction) <= 1.0;
    for (uint8_t nibble : t.hm) good &= nibble < 16;
    // `pending` may be any clock if a program never ends a frame. It needs no check, as rendering stops at draw_stop.
    for (int32_t clock : {t.draw_start, t.draw_stop, t.drawn_to}) good &= clock > -(1 << 30) && clock < 1 << 30;
    if (!good) return false;
    // The pixels still to be rendered must fit into the framebuffer.
    const int32_t left = t.draw_stop - t.drawn_to;
    const int32_t lines_after = left > t.to_line_end ? (left - t.to_line_end + kClocksPerLine - 1) / kClocksPerLine : 0;
    return left <= 0 || t.write_pos + std::min(kScreenWidth, t.to_line_end) + lines_after * kScreenWidth <= kFrameBytes;
}

}  // namespace

bool Console::load(const uint8_t* in) {
    Machine machine;
    std::memcpy(&machine, in, sizeof machine);
    if (!sound_indices(machine, cartridge())) return false;
    m_ = machine;
    in += sizeof machine;
    std::copy_n(in, slot_.ram.size(), slot_.ram.begin());
    in += slot_.ram.size();
    for (int buffer : {0, 1}) {
        std::memcpy(framebuffers_.use(buffer, Framebuffers::kMost), in, kFrameBytes);
        in += kFrameBytes;
    }
    renderer_.touch(kAllObjects);
    slot_.map_segments();
    return true;
}

std::unique_ptr<ConsoleSnapshot> Console::snapshot() const {
    auto snapshot = std::make_unique<ConsoleSnapshot>();
    snapshot_into(*snapshot, {0, 0});
    return snapshot;
}

void Console::snapshot_into(ConsoleSnapshot& snapshot, const std::size_t (&skipped)[2]) const {
    snapshot.machine = m_;
    snapshot.cart_ram = slot_.ram;
    const std::size_t size = config_.framebuffer_bytes();
    for (int buffer : {0, 1})
        snapshot.framebuffers[buffer].assign(framebuffers_[buffer] + skipped[buffer], framebuffers_[buffer] + size);
}

void Console::restore(const ConsoleSnapshot& snapshot) {
    framebuffers_.cut(config_.framebuffer_bytes());
    restore_from(snapshot, false);
}

void Console::restore_from(const ConsoleSnapshot& snapshot, bool swapped) {
    m_ = snapshot.machine;
    m_.tia.current ^= static_cast<uint8_t>(swapped);
    slot_.ram = snapshot.cart_ram;
    for (int buffer : {0, 1})
        framebuffers_.restore(buffer, snapshot.framebuffers[buffer ^ static_cast<int>(swapped)],
                              config_.framebuffer_bytes());
    renderer_.touch(kAllObjects);
    slot_.map_segments();
}

}  // namespace atari
