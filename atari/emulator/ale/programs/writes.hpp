// Writes to RAM: rules by which an environment changes bytes of RAM after each emulated frame. Interventions, frozen
// bytes and pokes are writes.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "machine/console.hpp"
#include "program.hpp"

namespace atari {

inline constexpr int kMaxWrites = 64;
inline constexpr const char* kTooManyWrites = "an environment has at most 64 writes; release a Freeze or a Poke";

// The variables of the programs of a write.
enum WriteVariable { kResult, kOld, kFrame, kLabelByte, kWriteVariables };

// One write: the bits of a byte, their new value, and the frames. Its programs store their result in `kResult`.
// Immutable and shared.
struct Write {
    std::string definition;  // its source, for replays; opaque here
    int index = 0;           // the byte's, 0..127
    uint8_t mask = 0xff;
    bool every_frame = false, at_reset = false;
    std::vector<int32_t> frames;  // frames of the episode at whose end it is applied, from 1 on
    bool once = false;            // applied once, not in each episode
    bool paid = true;             // whether the rules reward its changes
    bool remembers = false;       // whether a program uses `kOld`
    bool conditional = false;
    Program condition, value;
    // If `of_label`, `value` is the value of a label, which the program `label` computes from the byte `kLabelByte`.
    bool of_label = false;
    Program label;
    std::vector<int32_t> label_values;  // by byte; empty if the label's value depends on other bytes too

    // Fills `label_values`. Throws std::invalid_argument if a number is out of range.
    void prepare();
};

// The part of the writes' state that a snapshot has.
struct WriteState {
    uint32_t random[2];  // the generator of `random` in programs, PCG32 (O'Neill 2014)
    uint32_t done[2];    // by slot, a bit: whether a write that is applied once has been applied

    void seed(uint32_t value);
    uint32_t next();
};

// The writes of an environment, by slot. They are applied in the order of the slots.
class Writes {
  public:
    using Slots = std::vector<std::shared_ptr<const Write>>;

    int add(std::shared_ptr<const Write> write, WriteState& state);  // returns the slot, or -1 if none is free
    int remove(const Write* write);                                  // returns the slot that it had, or -1
    void set(Slots slots) { slots_ = std::move(slots); }             // at most kMaxWrites; the last is not null
    const Slots& slots() const { return slots_; }
    bool empty() const { return slots_.empty(); }

    // Stores the values before a frame, which programs read as `kOld`.
    void begin_frame(const Console& console, WriteState& state);
    // Applies the writes of a frame whose `paid` is this value. Returns whether a byte has changed.
    bool apply(Console& console, WriteState& state, int32_t frame, bool paid);
    bool apply_at_reset(Console& console, WriteState& state);
    bool apply_now(int slot, Console& console, WriteState& state, int32_t frame);

  private:
    template <typename Chosen>
    bool apply_if(Chosen&& chosen, Console& console, WriteState& state, int32_t frame);
    bool apply(const Write& write, int slot, Console& console, WriteState& state, int32_t frame);

    Slots slots_;                // null where a write was removed; the last is not null
    int32_t old_[kMaxWrites]{};  // by slot, the values before the frame
};

}  // namespace atari
