#include "frame_history.hpp"

#include <algorithm>
#include <utility>

#include "fast/tia/collider.hpp"
#include "machine/console_config.hpp"

namespace atari {

FrameLog& FrameHistory::begin_frame(const Tia& start, const TiaWrite* rendered) {
    Marks& m = marks_;
    m.current = 0;
    const auto is_needed = [&](int log) {
        return log == m.owed[0] || log == m.owed[1] || log == m.last || logs_[log].writes == rendered;
    };
    while (is_needed(m.current)) ++m.current;
    FrameLog& log = logs_[m.current];
    log.start = start;
    m.watched = m.cleared ? m.read : 0xffff;
    m.cleared = false;
    if (m.pending < 0 && m.watched != 0xffff) {
        m.pending = m.current;
        m.pending_from = 0;
    }
    return log;
}

void FrameHistory::give_up_frame(const Marks& before) {
    const unsigned read = marks_.read;
    marks_ = before;
    marks_.read = read;
}

const FrameLog* FrameHistory::pay(int buffer) {
    const int owed = std::exchange(marks_.owed[buffer], -1);
    if (owed < 0) return nullptr;
    marks_.shown[buffer] = owed;
    return &logs_[owed];
}

void FrameHistory::clear_latches(const TiaWrite* cxclr) {
    marks_.cleared = true;
    if (marks_.watched == 0xffff) return;
    marks_.pending = marks_.current;
    marks_.pending_from = cxclr - current().writes;
}

void FrameHistory::watch(unsigned latches) {
    marks_.watched |= latches;
    if (marks_.watched == 0xffff) settled();
}

unsigned FrameHistory::find_pending(const ConsoleConfig& config, const TiaWrite* end, int32_t clock) const {
    if (!pending()) return 0;
    unsigned found = 0;
    const int numbers[2] = {marks_.pending, marks_.current};
    for (int i = numbers[0] == numbers[1] ? 1 : 0; i < 2; ++i) {
        const FrameLog& log = logs_[numbers[i]];
        const bool running = end && numbers[i] == marks_.current;
        Tia tia = log.start;
        tia.collisions = 0;
        tia.pending = tia.draw_start;
        Collider collider(tia, config);
        collider.begin(~marks_.watched & 0xffff);
        const TiaWrite* const from = log.writes + (numbers[i] == marks_.pending ? marks_.pending_from : 0);
        collider.collect(false);
        collider.apply(log.writes, from);
        collider.collect(true);
        collider.apply(from, running ? end : log.writes + log.size);
        collider.reach(running ? clock : log.reached);
        found |= tia.collisions;
    }
    return found;
}

void FrameHistory::snapshot(Snapshot& out, int whole) const {
    out.marks = marks_;
    for (int buffer : {0, 1}) {
        if (const int log = log_of(buffer, whole); log >= 0) out.marks.owed[buffer] = log;
        out.marks.shown[buffer] = -1;
    }
    for (int i = 0; i < kLogs; ++i) {
        out.logs[i].used = i == out.marks.owed[0] || i == out.marks.owed[1] || i == marks_.pending;
        if (!out.logs[i].used) continue;
        const FrameLog& log = logs_[i];
        out.logs[i] = {true, log.start, log.reached, log.replaced, {log.writes, log.writes + log.size}};
    }
}

void FrameHistory::restore(const Snapshot& in, bool swapped) {
    marks_ = in.marks;
    if (swapped) std::swap(marks_.owed[0], marks_.owed[1]);
    for (int i = 0; i < kLogs; ++i) {
        const Snapshot::Log& from = in.logs[i];
        if (!from.used) continue;
        FrameLog& log = logs_[i];
        log.start = from.start;
        log.reached = from.reached;
        log.replaced = from.replaced;
        log.size = static_cast<int>(from.writes.size());
        std::copy(from.writes.begin(), from.writes.end(), log.writes);
    }
}

}  // namespace atari
