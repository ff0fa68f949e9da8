// Frames that are run without drawing: writes to the TIA are kept in a log, with their times. The state of the TIA is
// brought up to date from the log when a program asks for it and at the end of the frame; the picture is drawn from the
// log if somebody wants to see it.
#include <algorithm>
#include <tuple>
#include <utility>

#include "console.hpp"
#include "tia_registers.hpp"

namespace atari {

// False if this frame cannot be run so (no limit of instructions is kept here, and a processor that stops for good never
// ends it): then nothing has happened.
bool Console::run_deferred() {
    *before_ = m_;
    cart_ram_before_ = cart_ram_;
    const auto latches_before = std::tuple(open_log_, open_from_, watched_latches_, cleared_);
    m_.cpu.stop = false;
    begin_log();
    deferred_ = true;
    const bool ended = run_fast();
    deferred_ = false;
    if (!ended) {
        m_ = *before_;
        std::copy(cart_ram_before_.begin(), cart_ram_before_.end(), cart_ram_.begin());
        map_segments();
        std::tie(open_log_, open_from_, watched_latches_, cleared_) = latches_before;
        log_ = last_log_;
        collision_cache_.forget();
        return false;
    }
    end_log();
    return true;
}

void Console::begin_log() {
    Tia& t = m_.tia;
    log_ = 0;
    const auto is_needed = [&](int log) {
        return log == owed_[0] || log == owed_[1] || log == last_log_ || logs_[log].writes == line_cache_->log();
    };
    while (is_needed(log_)) ++log_;
    FrameLog& log = logs_[log_];
    log.start = t;
    log_end_ = log.writes;
    applied_ = collisions_from_ = log.writes;
    first_cycle_ = static_cast<uint32_t>(t.frame_start / 3);
    overlong_ = first_cycle_ + 76 * (config_.pal ? 343 : 291);
    watched_latches_ = cleared_ ? read_latches_ : 0xffff;
    cleared_ = false;
    collider_.begin(watched_latches_);
    collision_cache_.begin(log.writes, watched_latches_);
    if (open_log_ < 0 && watched_latches_ != 0xffff) {
        open_log_ = log_;
        open_from_ = log.writes;
    }

    Written& w = written_;
    w.reg[VBLANK] = t.vblank;
    for (int i = 0; i < 4; ++i) w.reg[COLUP0 + i] = t.colour[i] & 0xfe;
    w.reg[PF0] = static_cast<uint8_t>(t.playfield << 4);
    w.reg[PF1] = static_cast<uint8_t>(t.playfield >> 4);
    w.reg[PF2] = static_cast<uint8_t>(t.playfield >> 12);
    for (int i = 0; i < 2; ++i) {
        w.reg[REFP0 + i] = t.refp[i] ? 8 : 0;
        w.reg[GRP0 + i] = t.grp[i];
        w.reg[ENAM0 + i] = t.enam[i] ? 2 : 0;
        w.reg[VDELP0 + i] = t.vdelp[i] ? 1 : 0;
        w.reg[RESMP0 + i] = t.resmp[i] ? 2 : 0;
        w.reg[NUSIZ0 + i] = t.nusiz[i];
        w.reg[RESP0 + i] = t.skip_first[i] ? 1 : 0;
    }
    w.reg[ENABL] = t.enabl ? 2 : 0;
    w.reg[VDELBL] = t.vdelbl ? 1 : 0;
    for (int i = 0; i < 5; ++i) w.reg[HMP0 + i] = static_cast<uint8_t>(t.hm[i] << 4);
    w.old_grp0 = t.old_grp[0];
    w.old_grp1 = t.old_grp[1];
    w.old_enabl = t.old_enabl ? 2 : 0;
    w.reg[CTRLPF] = t.ctrlpf;
    w.mirror_waits = t.pf_mirror != (t.ctrlpf & 1);
    w.ark = t.cosmic_ark || t.m0_variant != kPlain;
}

void Console::end_log() {
    Tia& t = m_.tia;
    FrameLog& log = logs_[log_];
    log.size = static_cast<int>(log_end_ - log.writes);
    // A frame that is too long ends at a write, which may show a little later.
    apply_kept(log.size > 0 ? std::max(end_clock_, shown_at(log_end_[-1], first_cycle_)) : end_clock_);
    collider_.finish();
    for (int i = 0; i < 4; ++i) t.colour[i] = colour_of(written_.reg[COLUP0 + i], config_.pal, t);
    t.ctrlpf = written_.reg[CTRLPF];
    for (int object = kP0; object <= kBL; ++object) t.hm[object] = written_.reg[HMP0 + object] >> 4;
    log.reached = t.pending;
    log.replaced = t.write_pos;
    // In front of the last line a blank may reach further.
    log.extent = t.write_pos + (t.hmove_blank && t.drawn_to < t.draw_stop ? kScreenWidth : 0);
    last_log_ = log_;
    if (!cleared_) settle_latches();  // or ever more logs would be needed
    // An older frame that has not been drawn would still show where it reaches further.
    const int owed = owed_[t.current];
    if (owed >= 0 && logs_[owed].extent > t.write_pos) drawn(t.current);
    owed_[t.current] = log_;
}

// Brings the state of the TIA up to an access at a clock.
void Console::apply_kept(int32_t clock) {
    collision_cache_.apply(applied_, log_end_, collisions_from_, clock);
    applied_ = log_end_;
}

// The two latches of a read register.
void Console::read_latches(int reg) {
    apply_kept(clock());
    const unsigned latches = 3u << (14 - 2 * reg);
    read_latches_ |= latches;
    if (!(latches & ~watched_latches_)) return;
    const int open_log = open_log_;
    settle_latches();
    watched_latches_ |= latches;
    collider_.watch(watched_latches_);
    collision_cache_.forget();
    // Others, if any, are found from where they were unknown, now or later: it is a CXCLR, or the beginning of a frame, and
    // only there the collider can begin to collect.
    if (watched_latches_ != 0xffff) open_log_ = open_log;
}

// Finds the latches that have not been kept up to date. What is found twice does no harm: between `open_from_` and now
// nothing is cleared.
void Console::settle_latches() {
    if (open_log_ < 0) return;
    unsigned found = 0;
    const int numbers[2] = {open_log_, log_};
    for (int i = open_log_ == log_ ? 1 : 0; i < 2; ++i) {
        const int number = numbers[i];
        const FrameLog& log = logs_[number];
        const bool running = deferred_ && number == log_;
        Tia tia = log.start;
        tia.collisions = 0;
        tia.pending = tia.draw_start;
        Collider collider(tia, config_);
        collider.begin(~watched_latches_ & 0xffff);
        const Write* end = running ? log_end_ : log.writes + log.size;
        const Write* const from = number == open_log_ ? open_from_ : log.writes;
        collider.collect(false);
        collider.apply(log.writes, from);
        collider.collect(true);
        collider.apply(from, end);
        collider.reach(running ? m_.tia.pending : log.reached);
        found |= tia.collisions;
    }
    m_.tia.collisions = static_cast<uint16_t>(m_.tia.collisions | found);
    open_log_ = -1;
}

void Console::copy_to(ConsoleCopy& copy) const {
    copy.machine = m_;
    copy.cart_ram = cart_ram_;
    const size_t shown = config_.picture_bytes();
    const auto whole = static_cast<int>(kScreenWidth) * config_.height;
    bool needed[kLogs] = {};
    for (int buffer : {0, 1}) {
        const int owed = owed_[buffer];
        copy.owed[buffer] = owed;
        if (owed >= 0) needed[owed] = true;
        const bool replaced = owed >= 0 && logs_[owed].replaced >= whole;
        copy.replaced[buffer] = replaced;
        copy.pictures[buffer].assign(pictures_[buffer] + (replaced ? whole : 0), pictures_[buffer] + shown);
    }
    if (open_log_ >= 0) needed[open_log_] = needed[log_] = true;
    for (int i = 0; i < kLogs; ++i) {
        copy.logs[i].used = needed[i];
        if (!needed[i]) continue;
        const FrameLog& log = logs_[i];
        copy.logs[i] = {true, log.start, log.reached, log.replaced, log.extent, {log.writes, log.writes + log.size}};
    }
    copy.log = log_;
    copy.last_log = last_log_;
    copy.open_log = open_log_;
    copy.open_from = open_log_ >= 0 ? open_from_ - logs_[open_log_].writes : 0;
    copy.read_latches = read_latches_;
    copy.watched_latches = watched_latches_;
    copy.cleared = cleared_;
    copy.plain = plain();
}

void Console::copy_from(const ConsoleCopy& copy, bool swapped) {
    m_ = copy.machine;
    m_.tia.current ^= static_cast<uint8_t>(swapped);
    cart_ram_ = copy.cart_ram;
    for (int buffer : {0, 1}) {
        const int from = buffer ^ static_cast<int>(swapped);
        owed_[buffer] = copy.owed[from];
        pictures_.restore(buffer, copy.pictures[from], config_.picture_bytes());
    }
    for (int i = 0; i < kLogs; ++i) {
        const ConsoleCopy::Log& from = copy.logs[i];
        if (!from.used) continue;
        FrameLog& log = logs_[i];
        log.start = from.start;
        log.reached = from.reached;
        log.replaced = from.replaced;
        log.extent = from.extent;
        log.size = static_cast<int>(from.writes.size());
        std::copy(from.writes.begin(), from.writes.end(), log.writes);
    }
    log_ = copy.log;
    last_log_ = copy.last_log;
    open_log_ = copy.open_log;
    open_from_ = open_log_ >= 0 ? logs_[open_log_].writes + copy.open_from : nullptr;
    read_latches_ = copy.read_latches;
    watched_latches_ = copy.watched_latches;
    cleared_ = copy.cleared;
    collision_cache_.forget();
    if (line_cache_) line_cache_->forget();
    stale_ = 0x3f;
    map_segments();
}

void Console::follow(const ConsoleCopy& copy, bool swapped) {
    const uint64_t words = m_.random_words;
    const Sound sound = m_.sound;
    const unsigned latches = read_latches_;
    copy_from(copy, swapped);
    m_.random_words = words;
    m_.sound.keep_generator_of(sound);
    read_latches_ |= latches;
}

// From here on frames are drawn as they are run, or the state is another.
void Console::forget_logs() {
    open_log_ = last_log_ = -1;
    cleared_ = false;
    collision_cache_.forget();
    if (line_cache_) line_cache_->forget();
}

// A write that the fast interpreter does not take itself. Each is kept that could delay a later one.
void Console::keep_write(uint8_t reg, uint8_t value) {
    if (m_.cycles >= overlong_) end_frame();
    Written& w = written_;
    switch (reg) {
        case VSYNC: return write_vsync(value);
        case WSYNC: return halt_until_line_start();
        case AUDC0: case AUDC1: case AUDF0: case AUDF1: case AUDV0: case AUDV1:
            return m_.sound.write(reg - AUDC0, value);
        case VBLANK: switch_dump(w.reg[VBLANK], value); break;
        case GRP0: w.old_grp1 = w.reg[GRP1]; break;
        case GRP1:
            w.old_grp0 = w.reg[GRP0];
            w.old_enabl = w.reg[ENABL];
            break;
        case HMP0: case HMP1: case HMM0: case HMM1: case HMBL: {
            const bool trick = reg == HMM0 && w.reg[reg] >> 4 == 7 && value >> 4 == 6;
            w.reg[reg] = value;
            if (!trick) return;
            w.ark = true;
            break;
        }
        case HMCLR: std::fill_n(w.reg + HMP0, 5, uint8_t{0}); return;
        case RESP0: case RESP1: value = 1; break;
        case CTRLPF: w.mirror(w.reg[CTRLPF] ^ value, m_.cycles - first_cycle_); break;
        default:
            if (reg > CXCLR || reg == RSYNC) return;
    }
    w.reg[reg] = value;
    // JSR and BRK push two or three bytes at the same time, into the TIA if the stack is there.
    if (log_end_ != logs_[log_].writes && log_end_[-1].cycle == m_.cycles) *log_end_++ = {m_.cycles, SAME_TIME, 0, 0};
    if (reg == HMOVE) return keep_hmove(m_.cycles);
    if (reg == CXCLR) return keep_cxclr(m_.cycles);
    const int beside = reg == GRP0 ? w.old_grp1 : reg == GRP1 ? w.beside_grp1() : 0;
    *log_end_++ = {m_.cycles, reg, value, static_cast<uint16_t>(beside)};
}

void Console::keep_hmove(uint32_t cycles) {
    *log_end_++ = {cycles, HMOVE, written_.ball_motion(), written_.motions()};
}

void Console::keep_cxclr(uint32_t cycles) {
    collisions_from_ = log_end_;
    cleared_ = true;
    if (watched_latches_ != 0xffff) {
        open_log_ = log_;
        open_from_ = log_end_;
    }
    *log_end_++ = {cycles, CXCLR, 0, 0};
}

// The picture, after what is missing has been drawn.
const uint8_t* Console::drawn(int buffer) {
    const int owed = std::exchange(owed_[buffer], -1);
    if (owed >= 0) line_cache_->draw(logs_[owed], pictures_, buffer);
    return pictures_[buffer];
}

}  // namespace atari
