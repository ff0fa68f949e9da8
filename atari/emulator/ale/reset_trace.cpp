#include "reset_trace.hpp"

#include <algorithm>
#include <cstring>

#include "fast/fast_console.hpp"

namespace atari {
namespace {

// Returns the part of the state that the frames of a reset trace depend on. It leaves out the number of random words
// drawn, the sound generator, the number of the current framebuffer, and the data bus (`ResetTrace::add`).
Machine essence(Machine machine) {
    machine.random_words = 0;
    machine.bus = 0;
    machine.sound.keep_generator_of(Sound{});
    machine.tia.current = 0;
    return machine;
}

std::vector<uint8_t> both_framebuffers(Console& console) {
    const size_t size = console.config().framebuffer_bytes();
    std::vector<uint8_t> framebuffers(console.framebuffer(), console.framebuffer() + size);
    framebuffers.insert(framebuffers.end(), console.previous_framebuffer(), console.previous_framebuffer() + size);
    return framebuffers;
}

}  // namespace

// A frame that begins with a fetch from TIA space also depends on the byte that the rules left on the data bus. That
// byte may depend on the rules' variables, so a program with such a frame has no trace.
bool ResetTrace::add(Console& console, int frame) {
    if (!(console.machine().cpu.pc & 0x1080)) return false;
    std::copy_n(console.ram(), 128, ram_[frame]);
    if (frame < kCheckpoints) {
        console.settle_latches();
        checkpoints_[frame] = {console.machine(), both_framebuffers(console)};
    }
    return true;
}

void ResetTrace::end(const Console& console) {
    end_ = console.snapshot();
    if (!static_cast<const FastConsoleSnapshot&>(*end_).replaces_framebuffers()) return;
    for (Checkpoint& checkpoint : checkpoints_) checkpoint.framebuffers = {};
}

bool ResetTrace::matches(Console& console, int frame) const {
    const Checkpoint& then = checkpoints_[frame];
    console.settle_latches();
    const Machine a = essence(console.machine()), b = essence(then.machine);
    return std::memcmp(&a, &b, sizeof a) == 0 &&
           (then.framebuffers.empty() || then.framebuffers == both_framebuffers(console));
}

void ResetTrace::resume(Console& console, int frame) const {
    const bool swapped = console.machine().tia.current != checkpoints_[frame].machine.tia.current;
    static_cast<FastConsole&>(console).resume(*end_, swapped);
}

}  // namespace atari
