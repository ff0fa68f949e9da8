// The frames of a fast console that have been run but not rendered, and the collision latches that have been deferred.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "fast/tia/frame_log.hpp"

namespace atari {

struct ConsoleConfig;

// Owns the write logs of the latest frames, and records for what each is still needed: a framebuffer is owed a frame
// until that has been rendered, and latches are pending until they have been found.
//
// A game reads few collision latches. After a frame that cleared all latches by CXCLR, only latches that the game has
// read before are watched, so kept up to date. The others are pending: if one is read after all, it is found in the logs.
//
// Between frames:
// - each owed log is the whole frame that its framebuffer shows once it has been rendered;
// - the log with the first pending write is that of the last frame, or no latch is pending;
// - at most three logs are needed, that of the frame rendered last included, so that a frame always finds a free one.
// While a frame is run its log is needed too, and pending writes may begin in it or in the log of the frame before.
//
// In memory, `snapshot` and `restore` copy all of this. As bytes a history is nothing: before a state is saved its frames
// are rendered and its latches are found, and after one is loaded the history is empty (`clear`).
class FrameHistory {
  public:
    static constexpr int kLogs = 4;

    // All but the logs. Logs are numbered, -1 is none.
    struct Marks {
        int current = 0;           // the log of the frame that is being run, or that was run last
        int last = -1;             // that of the frame before the next one, if that frame was logged
        int owed[2] = {-1, -1};    // by framebuffer: what is still to be rendered into it
        int pending = -1;          // the log with the first write from which the latches that are not watched are pending
        std::ptrdiff_t pending_from = 0;  // that write
        unsigned read = 0;         // latches that the game has ever read
        unsigned watched = 0xffff; // latches that are kept up to date
        bool cleared = false;      // CXCLR was written in the frame that is being run, or in the last one
    };

    struct Snapshot {
        struct Log {
            bool used;
            Tia start;
            int32_t reached;
            int replaced, extent;
            std::vector<TiaWrite> writes;
        };
        Marks marks;
        Log logs[kLogs];
    };

    FrameHistory() : logs_(std::make_unique_for_overwrite<FrameLog[]>(kLogs)) {}

    // Begins a frame in a free log, and chooses the latches that it watches. `rendered`: the log that the line cache
    // needs, or null.
    FrameLog& begin_frame(const Tia& start, const TiaWrite* rendered);
    FrameLog& current() { return logs_[marks_.current]; }
    // The frame has ended: `buffer` is owed it.
    void end_frame(int buffer) { marks_.owed[buffer] = marks_.last = marks_.current; }

    // Gives up a frame: back to what `marks` returned before `begin_frame`. Reads of latches stay noted.
    const Marks& marks() const { return marks_; }
    void give_up_frame(const Marks& before);

    // The next frame does not follow one that was logged. What is owed stays so; no latch may be pending.
    void break_off() {
        marks_.last = marks_.pending = -1;
        marks_.cleared = false;
    }
    // The state is another one: nothing is owed either.
    void clear() {
        break_off();
        marks_.owed[0] = marks_.owed[1] = -1;
    }

    // What is owed to a framebuffer, or null. `pay` ends that.
    const FrameLog* owed(int buffer) const { return marks_.owed[buffer] < 0 ? nullptr : &logs_[marks_.owed[buffer]]; }
    const FrameLog* pay(int buffer);

    unsigned watched() const { return marks_.watched; }
    bool cleared() const { return marks_.cleared; }
    // CXCLR is the next write: latches that are not watched are pending from there on.
    void clear_latches(const TiaWrite* cxclr);
    void note_read(unsigned latches) { marks_.read |= latches; }
    // Keeps these latches up to date, too, now that all pending ones have been found. Others stay pending from where
    // they were: a CXCLR or a frame's beginning, where alone a collider can begin to collect.
    void watch(unsigned latches);
    bool pending() const { return marks_.pending >= 0; }
    void settled() { marks_.pending = -1; }
    // Those of the pending latches that are set. `end` and `clock`: where the frame that is being run is; null between
    // frames. What is found twice does no harm: since the first pending write nothing has been cleared.
    unsigned find_pending(const ConsoleConfig& config, const TiaWrite* end, int32_t clock) const;

    void snapshot(Snapshot& out) const;
    // `swapped`: framebuffers change places.
    void restore(const Snapshot& in, bool swapped);

  private:
    Marks marks_;
    std::unique_ptr<FrameLog[]> logs_;
};

}  // namespace atari
