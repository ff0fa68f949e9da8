// `FrameHistory`: the frames of a fast console that have run but are not rendered, and the deferred collision latches.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "fast/tia/frame_log.hpp"

namespace atari {

struct ConsoleConfig;

// Owns the write logs of the latest frames, and stores what each is still needed for. A framebuffer is owed a frame
// until the frame is rendered. Latches are pending until they are found.
//
// A game reads few collision latches. After a frame that cleared all latches by CXCLR, only the latches that the game
// has ever read are watched, that is, kept up to date. The others are pending: if the game reads one after all, it is
// found in the logs.
//
// Between frames:
// - each owed log is the whole frame that its framebuffer shows once it is rendered;
// - the log with the first pending write is that of the last frame, or no latch is pending;
// - at most three logs are needed, including that of the frame rendered last, so a frame always finds a free one.
// While a frame is running, its log is needed too, and pending writes may begin in it or in the log of the frame
// before.
//
// `snapshot` and `restore` copy all of this in memory. A state in bytes contains no history: before it is saved, its
// frames are rendered and its latches are found; after it is loaded, the history is empty (`clear`).
class FrameHistory {
  public:
    static constexpr int kLogs = 4;

    // All data except the logs. Logs are numbered; -1 means none.
    struct Marks {
        int current = 0;                  // the log of the frame that is running, or that ran last
        int last = -1;                    // the log of the frame before the next one, if that frame was logged
        int owed[2] = {-1, -1};           // by framebuffer: the log to be rendered into it
        int shown[2] = {-1, -1};          // by framebuffer that is owed none: the log that was rendered into it
        int pending = -1;                 // the log with the first write from which unwatched latches are pending
        std::ptrdiff_t pending_from = 0;  // the index of that write in the log
        unsigned read = 0;                // latches that the game has ever read
        unsigned watched = 0xffff;        // latches that are kept up to date
        bool cleared = false;             // CXCLR was written in the frame that is running, or in the last one
    };

    struct Snapshot {
        struct Log {
            bool used;
            Tia start;
            int32_t reached;
            int replaced;
            std::vector<TiaWrite> writes;
        };
        Marks marks;
        Log logs[kLogs];
    };

    FrameHistory() : logs_(new FrameLog[kLogs]) {}

    // Begins a frame in a free log, and chooses the latches that it watches. `rendered` is the log that the line cache
    // needs, or null. The free log may be one that was shown in the frame's own framebuffer, but not in the other one,
    // whose frame is the last one.
    FrameLog& begin_frame(const Tia& start, const TiaWrite* rendered);
    FrameLog& current() { return logs_[marks_.current]; }
    // Ends the running frame. Framebuffer `buffer` is owed this frame from now on.
    void end_frame(int buffer) { marks_.owed[buffer] = marks_.last = marks_.current; }

    // The marks before `begin_frame` are passed to `give_up_frame`, which restores them. Reads of latches stay noted. As
    // the frame's log may have been one that was shown, `break_off` must follow.
    const Marks& marks() const { return marks_; }
    void give_up_frame(const Marks& before);

    // To be called if the next frame does not follow a logged one. Owed frames stay owed; no latch may be pending.
    void break_off() {
        marks_.last = marks_.pending = -1;
        marks_.shown[0] = marks_.shown[1] = -1;
        marks_.cleared = false;
    }
    // To be called if another state replaces this one: no frame is owed any more.
    void clear() {
        break_off();
        marks_.owed[0] = marks_.owed[1] = -1;
    }

    // Returns the frame that a framebuffer is owed, or null. After `pay` it is no longer owed.
    const FrameLog* owed(int buffer) const { return marks_.owed[buffer] < 0 ? nullptr : &logs_[marks_.owed[buffer]]; }
    const FrameLog* pay(int buffer);
    // Returns whether a log has the whole frame of a framebuffer, rendered or not: all its first `whole` pixels. A
    // snapshot has the log in place of these pixels.
    bool has_whole_frame(int buffer, int whole) const { return log_of(buffer, whole) >= 0; }

    unsigned watched() const { return marks_.watched; }
    bool cleared() const { return marks_.cleared; }
    // To be called before a CXCLR is logged: unwatched latches are pending from that write on.
    void clear_latches(const TiaWrite* cxclr);
    void note_read(unsigned latches) { marks_.read |= latches; }
    // Watches more latches. All pending latches must have been found. The latches still unwatched stay pending from the
    // same write. That write is a CXCLR or a frame's beginning, as a collider can begin to collect only there.
    void watch(unsigned latches);
    bool pending() const { return marks_.pending >= 0; }
    void settled() { marks_.pending = -1; }
    // Returns the pending latches that are set. `end` and `clock` are the position in the frame that is running; `end`
    // is null between frames. A latch may be found twice without harm, because no latch has been cleared since the
    // first pending write.
    unsigned find_pending(const ConsoleConfig& config, const TiaWrite* end, int32_t clock) const;

    // In the snapshot, a framebuffer with a log of its `whole` pixels is owed the frame.
    void snapshot(Snapshot& out, int whole) const;
    // If `swapped`, the framebuffers are exchanged.
    void restore(const Snapshot& in, bool swapped);

  private:
    int log_of(int buffer, int whole) const {
        const int log = marks_.owed[buffer] >= 0 ? marks_.owed[buffer] : marks_.shown[buffer];
        return log >= 0 && logs_[log].replaced >= whole ? log : -1;
    }

    Marks marks_;
    std::unique_ptr<FrameLog[]> logs_;
};

}  // namespace atari
