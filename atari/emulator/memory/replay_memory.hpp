// A replay memory that stores each frame once, in rows of one frame for each lane (environment).
//
// Step (row, lane) is the frame of this row, the action on it, and the reward and end that followed. The observation
// after the step is the stack at the next row. If the next row has the first frame of the next episode, the last
// observation has no row, and is stored apart (`finals`). Rows count from 0 and lie in a ring of slots.
#pragma once

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "frames.hpp"
#include "geometry.hpp"
#include "max_tree.hpp"
#include "state.hpp"
#include "sum_tree.hpp"
#include "valid_steps.hpp"

namespace atari::memory {

// The results of a step of a vector environment, lane by lane. `finals` has, by part, the frames of all lanes; frames
// of lanes that have not ended are not read. It is empty without final observations.
struct StepResults {
    const uint8_t* actions;
    const float* rewards;
    const uint8_t* terminated;
    const uint8_t* truncated;
    std::vector<const uint8_t*> finals;
};

// The options of a call that samples.
struct Choice {
    int64_t count;  // steps that are drawn
    int64_t reach;  // n of n-step returns; the length of sequences
    double discount;
    std::optional<double> beta;  // exponent of importance weights, for draws by priority; empty for uniform draws
    std::vector<int> stacks;     // by part, the frames of an observation
    int threads;
};

// The arrays of a batch. Sequences have no `next`, `discounts` and `weights`; transitions have no `mask`. With n = 1,
// transitions may have no `next` either: then each observation also has the newest frame of the next observation.
struct Target {
    std::vector<uint8_t*> observations, next;  // by part
    uint8_t* actions;
    float* rewards;
    float* discounts;
    uint8_t* terminated;
    uint8_t* truncated;
    uint8_t* mask;
    int64_t* indices;
    float* weights;
};

// A call would overwrite rows or frames of the last saved state.
struct Overwrites : std::runtime_error {
    using std::runtime_error::runtime_error;
};

class ReplayMemory {
  public:
    // `block` has `Layout(geometry).bytes` bytes: zeros, or the block of an earlier memory of this geometry.
    ReplayMemory(const Geometry& geometry, uint8_t* block);
    ReplayMemory(const ReplayMemory&) = delete;
    ReplayMemory& operator=(const ReplayMemory&) = delete;

    const Geometry& geometry() const { return geometry_; }
    const State& state() const { return state_; }
    void seed(uint64_t seed) { state_.generator.seed(seed); }

    // The offset of the frames of a part in the block, and the number of rows that have a place there, lane by lane.
    size_t frames_offset(size_t part) const { return layout_.frames[part]; }
    int64_t places() const { return frames_.places(); }
    // The place of the next row's frames. Nothing reads them before `add`.
    int64_t next_place() const { return frames_.place(state_.started ? state_.head + 1 : 0); }
    // Whether the next `add`, or a reset, would overwrite rows or frames of the last saved state if all episodes ended
    // and no frame could be compressed. A save makes space for one `add` and for the resets of a mask after it.
    bool must_save() const;
    // Throws `Overwrites` if the next row's place has a row of the last saved state.
    void check_row() const;
    // Begins new episodes in all lanes, with the next row's frames. Episodes that have not ended are cut. Like the next
    // two functions, throws `Overwrites` before it changes anything, but not if `must_save` is false.
    void reset();
    // Begins new episodes in some lanes. Their frames replace the frames of the pending row.
    void reset(const uint8_t* mask, const std::vector<const uint8_t*>& frames);
    // Completes the pending row. The next row's frames must be in place. Throws before it changes anything.
    void add(const StepResults& results);

    // The number of steps after which `reach` steps, or an end, are stored.
    int64_t count(int64_t reach) const;
    // Writes the stacks at the pending row, the agent's present observations.
    void observe(const std::vector<int>& stacks, const std::vector<uint8_t*>& to) const;
    void sample(const Choice& choice, const Target& target);
    void sample_sequences(const Choice& choice, const Target& target);
    // Sets the priorities of steps. The last of equal indices counts; overwritten steps are left out.
    void update_priorities(const int64_t* indices, const double* priorities, int64_t count);

    // Save the present state, which `load` then reads, in three phases: see saving.cpp. Without `end_save`, after an
    // error of the disk, the save before stays the last one, and the next save has the same number.
    void begin_save();
    void write_save();
    void complete_save();
    void end_save();
    // Saves the present state in a copy of the block.
    void save_copy(uint8_t* copy) const;
    // Reads the last saved state, or the state of the save with this number, and forgets a later one. Throws
    // std::invalid_argument, which names the damaged place. `verify` reads all frames.
    void load(bool verify, std::optional<uint64_t> save);
    // Restores the pending row, after `load`. This may overwrite a row of a later save, which `load` has forgotten: the
    // block must be on the disk before.
    void resume();
    int64_t saves() const { return static_cast<int64_t>(saves_); }
    size_t used_bytes() const;

  private:
    struct Transition;
    struct Source;
    struct Span;
    class Writer;

    // replay_memory.cpp
    int64_t cell(int64_t row, int64_t lane) const { return row % slots_ * geometry_.lanes + lane; }
    uint8_t flags(int64_t row, int64_t lane) const { return flags_[cell(row, lane)]; }
    uint8_t* lane_frames(size_t part, int64_t row, int64_t lane) const;
    void check_results(const StepResults& results) const;
    void make_space(int64_t finals);
    bool finals_fit(int64_t finals) const { return state_.finals + finals - geometry_.finals <= saved_.first_final; }
    bool row_fits() const { return state_.head + 1 - slots_ < saved_.tail - geometry_.history(); }
    void forget_oldest();
    void release_chunks();
    double greatest_of_new() const { return greatest_->greatest() > 0 ? greatest_->greatest() : 1; }
    void set_greatest(int64_t row, double priority);
    int64_t kept_tail() const { return saving_ ? std::min(saved_.tail, state_.tail) : state_.tail; }
    void begin_row(int64_t lane, uint8_t flag) { flags_[cell(state_.head + 1, lane)] = flag; }
    void complete_row();
    void push_final(int64_t row, int64_t lane, const std::vector<const uint8_t*>& frames, int64_t frame);
    int64_t owner(int64_t entry) const { return final_owners_[entry % geometry_.finals]; }
    int64_t find_final(int64_t row, int64_t lane) const;

    // sampling.cpp
    bool continues(int64_t row, int64_t lane) const;
    Transition walk(int64_t row, int64_t lane, int64_t reach, double discount) const;
    Source source(int64_t row, int64_t lane, int64_t steps) const;
    Span span(int64_t reach) const;
    std::vector<int64_t> draw(const Choice& choice, float* weights);
    std::vector<int64_t> draw_by_priority(const Choice& choice, const Span& span, float* weights);
    int64_t index(int64_t cell) const;
    void prefetch_step(int64_t index) const;
    void check_choice(const Choice& choice) const;

    // saving.cpp
    uint8_t* section(uint64_t number) const { return block_ + layout_.sections[number % 2]; }
    uint64_t section_check(const uint8_t* section, uint64_t number) const;
    static void begin_section(uint8_t* section, uint64_t number);
    void write_section(uint8_t* section) const;
    void complete_section(uint8_t* section, uint64_t number) const;
    uint64_t complete_number(uint64_t which) const;
    bool may_follow(uint64_t which, uint64_t number) const;
    uint64_t newest_save() const;
    std::string complete_saves() const;
    void check_state(const State& state) const;
    void load_section(const uint8_t* section);
    void check_rows(bool verify) const;
    const uint8_t* pending_flags(const uint8_t* section) const;
    size_t pending_bytes() const;
    void rebuild(const uint8_t* pending);
    uint64_t row_check(int64_t row) const;
    uint64_t final_check(int64_t entry) const;
    std::string place(size_t offset) const;

    const Geometry geometry_;
    const Layout layout_;
    const int64_t slots_;
    uint8_t* const block_;
    uint8_t* const actions_;
    float* const rewards_;
    uint8_t* const flags_;
    uint64_t* const checks_;
    int64_t* const final_owners_;  // by slot, the index of the step before the final observation
    uint64_t* const final_checks_;

    State state_{};
    std::vector<uint8_t> waiting_;  // by lane: whether its episode has ended, so that its next action is ignored
    Frames frames_;
    ValidSteps valid_;
    std::optional<SumTree> tree_;
    std::optional<MaxTree> greatest_;  // by slot, the greatest priority that was given to a step of its row
    bool saving_ = false;              // whether the memory is a file with a saved state, which must stay readable
    State saved_{}, written_{};        // of the last save, and of the save that is not complete
    uint64_t saves_ = 0;
};

}  // namespace atari::memory
