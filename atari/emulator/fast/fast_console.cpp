#include "fast_console.hpp"

#include <algorithm>

#include "machine/tia/tia_registers.hpp"

namespace atari {

FastConsole::FastConsole(std::shared_ptr<const FastCartridge> cartridge, const ConsoleConfig& config)
    : Console(cartridge, config), program_(*cartridge), first_instruction_(program_.code()),
      base_instruction_(first_instruction_) {
    for (unsigned page = 0; page < 256; ++page)
        if (const unsigned address = 64 * page; (address & 0x1280) == 0x80)
            pages_[page] = m_.riot.ram + (address & 0x7f);
    map_cartridge_ram();
    for (unsigned segment = 0; segment < 4; ++segment)
        if (slot_.plain.from < 1024 * (segment + 1) && 1024 * segment < slot_.plain.from + slot_.plain.size)
            code_segments_ |= 0x1010u << segment;
    std::fill(std::begin(ram_code_), std::end(ram_code_),
              DecodedInstruction{code_of(kRamCode), kRamCode, 0, 0, 0, Loop::kNone});
}

void FastConsole::reset() {
    Console::reset();
    break_off_history();
    history_.clear();
}

void FastConsole::segments_changed() {
    bank_ = slot_.image + slot_.segment[12];
    map_pages();
    remapped_ = true;
}

// A page that is only partly plain image gets no entry.
void FastConsole::map_pages() {
    const unsigned first = (slot_.plain.from + 63) / 64, last = (slot_.plain.from + slot_.plain.size) / 64;
    for (const unsigned half : {4u, 12u}) {
        const uint32_t* const starts = slot_.segment + half;
        const uint8_t** const pages = pages_ + 16 * half;
        const auto map = [&](unsigned from, unsigned to, uint32_t start) {
            const uint8_t* const* const shown = program_.pages() + start / 64;
            if (from < to) std::copy(shown, shown + (to - from), pages + from);
        };
        bool one_bank = true;
        for (uint32_t i = 1; i < 4; ++i) one_bank &= starts[i] == starts[0] + 1024 * i;
        if (one_bank) map(first, last, starts[0] + 64 * first);
        else
            for (unsigned i = 0; i < 4; ++i) {
                const unsigned from = std::max(first, 16 * i);
                map(from, std::min(last, 16 * i + 16), starts[i] + 64 * (from - 16 * i));
            }
    }
}

// Maps the RAM of the cartridge types that always show it at the same addresses.
void FastConsole::map_cartridge_ram() {
    using Type = CartridgeType;
    unsigned first = 2, count = 2;
    switch (cartridge().type()) {
        case Type::kF8SC:
        case Type::kF6SC:
        case Type::kF4SC: break;
        case Type::kFASC: first = count = 4; break;
        default: return;
    }
    for (unsigned i = 0; i < count; ++i) pages_[64 + first + i] = pages_[192 + first + i] = slot_.ram.data() + 64 * i;
}

// --- frames ---

void FastConsole::emulate_frame(bool whole) {
    if (whole && run_deferred()) return;
    rendered(m_.tia.current);
    settle_latches();
    break_off_history();
    renderer_.touch(kAllObjects);
    run_counted();
    catch_up();
}

// Returns false and changes nothing if this frame cannot be deferred. There are three cases. The frame could reach the
// instruction limit: instructions are not counted here. An illegal opcode stops the processor before a write ends the
// frame. The frame ends in the line of an HMOVE blank.
bool FastConsole::run_deferred() {
    machine_before_ = m_;
    cart_ram_before_ = slot_.ram;
    const FrameHistory::Marks marks_before = history_.marks();
    m_.cpu.stop = false;
    begin_log();
    deferred_ = true;
    const bool ended = run_fast() && !ends_in_blanked_line();
    deferred_ = false;
    if (!ended) {
        m_ = machine_before_;
        std::copy(cart_ram_before_.begin(), cart_ram_before_.end(), slot_.ram.begin());
        slot_.map_segments();
        history_.give_up_frame(marks_before);
        collision_cache_.forget();
        return false;
    }
    end_log();
    return true;
}

void FastConsole::begin_log() {
    Tia& t = m_.tia;
    FrameLog& log = history_.begin_frame(t, line_cache_.log());
    log_end_ = log.writes;
    applied_ = collisions_from_ = log.writes;
    first_cycle_ = static_cast<uint32_t>(t.frame_start / 3);
    deadline_ = first_cycle_ + static_cast<uint32_t>(kCyclesPerLine * (last_line(config_.pal) + 1));
    for (uint32_t n = 0; n < kDeadlines; ++n) deadlines_[n] = deadline_ - n;
    collider_.begin(history_.watched());
    collision_cache_.begin(log.writes, history_.watched());

    shadow_.fill(t);
}

// Returns the clock up to which an access of the TIA at `clock` renders. The access may be the frame's end. The last
// write may show a little later.
int32_t FastConsole::rendered_by(int32_t clock) {
    const bool empty = log_end_ == history_.current().writes;
    return empty ? clock : std::max(clock, shown_at(log_end_[-1], first_cycle_));
}

// Returns whether the frame ends in a line that an HMOVE blanks, before the pixels that could stay black. The end of
// the black there depends on the first access of the TIA after the HMOVE, and the log may lack that access.
bool FastConsole::ends_in_blanked_line() {
    const Tia& t = m_.tia;
    const int32_t end = rendered_by(end_clock_);
    if (!config_.hmove_blanks || end <= t.draw_start || end >= t.draw_stop) return false;
    const int32_t in_line = (end - t.draw_start) % kClocksPerLine, line = end - in_line;
    if (in_line == 0 || in_line >= 2 * kHblankClocks + kHmoveBlank) return false;
    const bool first = line == t.draw_start;  // An HMOVE in any line above blanks this line.
    const FrameLog& log = history_.current();
    for (const TiaWrite* write = log_end_; write != log.writes;) {
        --write;
        const auto clock = static_cast<int32_t>(3 * write->cycle);
        if (!first && clock < line - 3) return false;  // in the line above, before its last cycle
        const bool moves = write->reg == HMOVE || write->reg == STILL;
        if (moves && hmove_blanks((write->cycle - first_cycle_) % kCyclesPerLine)) return true;
    }
    return first && log.start.hmove_blank;
}

void FastConsole::end_log() {
    Tia& t = m_.tia;
    FrameLog& log = history_.current();
    log.size = static_cast<int>(log_end_ - log.writes);
    apply_log(rendered_by(end_clock_));
    collider_.finish();
    for (int i = 0; i < 4; ++i) t.colour[i] = colour_of(shadow_.reg[COLUP0 + i], config_.pal, t);
    t.ctrlpf = shadow_.reg[CTRLPF];
    for (int object = kP0; object <= kBL; ++object) t.hm[object] = shadow_.reg[HMP0 + object] >> 4;
    log.reached = t.pending;
    log.replaced = t.write_pos;
    if (!history_.cleared()) settle_latches();  // otherwise latches would stay pending over more and more logs
    // If the framebuffer is still owed an older frame that reaches further than this one, that frame's last pixels stay
    // visible, so it is rendered first.
    const FrameLog* const owed = history_.owed(t.current);
    if (owed && owed->replaced > t.write_pos) rendered(t.current);
    history_.end_frame(t.current);
}

// Brings the state of the TIA up to an access at a clock.
void FastConsole::apply_log(int32_t clock) {
    collision_cache_.apply(applied_, log_end_, collisions_from_, clock);
    applied_ = log_end_;
}

void FastConsole::end_frame() {
    Console::end_frame();
    end_clock_ = clock_at(m_.cycles);
}

// --- collision latches ---

void FastConsole::before_tia_read(int reg) {
    if (!deferred_) return Console::before_tia_read(reg);
    if (reg < 8) update_latches(reg, rendered_by(clock_at(m_.cycles)));
}

// Brings the two latches of a read register up to date, up to a clock.
void FastConsole::update_latches(int reg, int32_t clock) {
    apply_log(clock);
    const unsigned latches = 3u << (14 - 2 * reg);
    history_.note_read(latches);
    if (!(latches & ~history_.watched())) return;
    find_pending_latches();
    history_.watch(latches);
    collider_.watch(history_.watched());
    collision_cache_.forget();
}

void FastConsole::settle_latches() {
    find_pending_latches();
    history_.settled();
}

void FastConsole::find_pending_latches() {
    const unsigned found = history_.find_pending(config_, deferred_ ? log_end_ : nullptr, m_.tia.pending);
    m_.tia.collisions = static_cast<uint16_t>(m_.tia.collisions | found);
}

// --- the state ---

bool FastConsole::load(const uint8_t* in) {
    if (!Console::load(in)) return false;
    break_off_history();
    history_.clear();
    return true;
}

std::unique_ptr<ConsoleSnapshot> FastConsole::snapshot() const {
    auto snapshot = std::make_unique<FastConsoleSnapshot>();
    const int whole = kScreenWidth * config_.height;
    std::size_t skipped[2];
    for (int buffer : {0, 1}) {
        snapshot->replaced[buffer] = history_.has_whole_frame(buffer, whole);
        skipped[buffer] = snapshot->replaced[buffer] ? static_cast<std::size_t>(whole) : 0;
    }
    snapshot_into(*snapshot, skipped);
    history_.snapshot(snapshot->history, whole);
    return snapshot;
}

void FastConsole::restore(const ConsoleSnapshot& snapshot) {
    framebuffers_.cut(config_.framebuffer_bytes());
    restore_all(snapshot, false);
}

void FastConsole::restore_all(const ConsoleSnapshot& snapshot, bool swapped) {
    Console::restore_from(snapshot, swapped);
    history_.restore(static_cast<const FastConsoleSnapshot&>(snapshot).history, swapped);
    collision_cache_.forget();
    line_cache_.forget();
}

void FastConsole::resume(const ConsoleSnapshot& snapshot, bool swapped) {
    const uint64_t words = m_.random_words;
    const Sound sound = m_.sound;
    const unsigned latches = history_.marks().read;
    restore_all(snapshot, swapped);
    m_.random_words = words;
    m_.sound.keep_generator_of(sound);
    history_.note_read(latches);
}

// To be called when the next frames are rendered as they run, or when another state replaces this one.
void FastConsole::break_off_history() {
    history_.break_off();
    collision_cache_.forget();
    line_cache_.forget();
}

// --- TIA writes ---

// Makes a TIA write that no handler of the fast interpreter logs. Every write that could delay a later one is logged.
void FastConsole::log_write(uint8_t reg, uint8_t value) {
    if (m_.cycles >= deadline_) end_frame();
    TiaShadow& shadow = shadow_;
    uint16_t beside = 0;
    uint8_t kind;
    switch (kTiaRegisters[reg].store) {
        case TiaStore::kNone: return;
        case TiaStore::kVsync:
            if (tia_.write_vsync(value, m_.cycles)) end_frame();
            return;
        case TiaStore::kWsync: return halt_until_line_start();
        case TiaStore::kSound: return m_.sound.write(reg, value);
        case TiaStore::kHmclr: return shadow.clear_motions();
        case TiaStore::kMotion:
            if (!shadow.write_motion(reg, value)) return;
            break;
        case TiaStore::kVblank:
            if (tia_.switch_dump(shadow.reg[VBLANK], value, m_.cycles)) time_inputs();
            shadow.reg[VBLANK] = value;
            break;
        case TiaStore::kValue: shadow.write_value(reg, value); break;
        case TiaStore::kNusiz: shadow.write_nusiz(reg, value); break;
        case TiaStore::kCtrlpf: shadow.write_ctrlpf(value, m_.cycles - first_cycle_, kind); break;
        case TiaStore::kGrp0:
            shadow.write_grp0(value);
            beside = shadow.beside_grp0();
            break;
        case TiaStore::kGrp1:
            shadow.write_grp1(value);
            beside = shadow.beside_grp1();
            break;
        case TiaStore::kStrobe: shadow.reg[reg] = 1; break;
        case TiaStore::kHmove:
        case TiaStore::kCxclr: break;
    }
    // JSR and BRK push two or three bytes in the same cycle. If the stack pointer is in TIA space, these are TIA
    // writes.
    if (log_end_ != history_.current().writes && log_end_[-1].cycle == m_.cycles)
        *log_end_++ = {m_.cycles, SAME_TIME, 0, 0};
    if (reg == HMOVE) return log_hmove(m_.cycles);
    if (reg == CXCLR) return log_cxclr(m_.cycles);
    *log_end_++ = {m_.cycles, reg, value, beside};
}

void FastConsole::log_hmove(uint32_t cycles) {
    *log_end_++ = {cycles, HMOVE, shadow_.ball_motion(), shadow_.beside_hmove()};
}

void FastConsole::log_cxclr(uint32_t cycles) {
    collisions_from_ = log_end_;
    history_.clear_latches(log_end_);
    *log_end_++ = {cycles, CXCLR, 0, 0};
}

void FastConsole::time_inputs() {
    for (int port = 0; port < 6; ++port) inputs_from_[port] = tia_.input_from(port, m_.inputs);
}

const uint8_t* FastConsole::rendered(int buffer) {
    if (const FrameLog* const owed = history_.pay(buffer)) line_cache_.draw(*owed, framebuffers_, buffer);
    return framebuffers_[buffer];
}

}  // namespace atari
