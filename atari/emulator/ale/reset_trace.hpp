// `ResetTrace`: the frames between a console's reset and the selection of a mode. A game and its settings have one.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "machine/console.hpp"

namespace atari {

// Frames after a reset of the console: first frames without input, then frames in which RESET is held.
inline constexpr int kNoopFrames = 60, kResetFrames = 4;

// Most games clear their RAM first, so these frames hardly depend on the state before the reset. If the machine is in
// the state of a checkpoint, the reset resumes from the trace and skips the remaining frames. The frames draw no random
// words, so they depend only on the state that `matches` compares. Only a `FastConsole` has a trace.
class ResetTrace {
  public:
    static constexpr int kFrames = kNoopFrames + kResetFrames, kCheckpoints = 4;

    // Adds the frame that ran last. Returns false if the program can have no trace.
    bool add(Console& console, int frame);
    void end(const Console& console);  // after the last frame

    // Returns whether the machine is in the state of the checkpoint after `frame`.
    bool matches(Console& console, int frame) const;
    const uint8_t* ram(int frame) const { return ram_[frame]; }  // after the frame
    // Continues as the trace did to its end, from a state that matches.
    void resume(Console& console, int frame) const;

  private:
    // The state after each of the first frames. `framebuffers` is empty if the end of the trace replaces all of both.
    struct Checkpoint {
        Machine machine;
        std::vector<uint8_t> framebuffers;
    };
    Checkpoint checkpoints_[kCheckpoints];
    uint8_t ram_[kFrames][128];
    std::unique_ptr<const ConsoleSnapshot> end_;
};

}  // namespace atari
