// `VectorEngine`: plays many environments by a pool of threads, and writes their results straight into the arrays that
// the user gets.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "batch.hpp"
#include "lane.hpp"
#include "sequence.hpp"
#include "thread_pool.hpp"

namespace atari {

enum class Autoreset { kNextStep, kSameStep, kDisabled };

struct VectorSettings {
    int batch_size = 1;
    int threads = 1;
    int first_core = -1;  // thread i is bound to core first_core + i; -1 binds none
    Autoreset autoreset = Autoreset::kNextStep;
};

// Owns the environments and the threads. Calls must not overlap. The threads run between a `reset` or `step` and the
// `receive` of its results.
class VectorEngine {
  public:
    VectorEngine(std::vector<std::unique_ptr<Lane>> lanes, const VectorSettings& settings);
    ~VectorEngine();

    int size() const { return static_cast<int>(slots_.size()); }
    int batch_size() const { return settings_.batch_size; }
    // The shape of batches whose observations have these parts.
    BatchShape shape(bool pixels, bool ram) const {
        return {recent_.size(),
                static_cast<size_t>(players_),
                pixels ? slot(0).lane->episode().observation().size() : 0,
                ram ? sizeof(Slot::final_ram) : 0,
                settings_.autoreset == Autoreset::kSameStep,
                slot(0).lane->episode().has_own_reward() ? size_t{1} : 0};
    }
    // The number of environments whose results have not been received.
    int pending() const { return pool_->pending(); }
    // The environments of the last batch, by row. Before the first batch, the environments with the lowest numbers.
    const std::vector<int>& recent() const { return recent_; }
    // Waits until no environment is being played. Results that have not been received can still be received.
    void settle() { pool_->settle(); }
    int actions_of(int environment) const { return static_cast<int>(slot(environment).lane->actions().size()); }

    // `reset` and `step` start work on environments; `receive` waits for the results. If a batch has all environments,
    // the results of lane i go to row i, and `batch` must live until `receive`. Otherwise `batch` may be null.
    //
    // Resets the chosen environments, with `seeds[i]` if it is not null. The others repeat their last observation.
    // With `new_games`, a reset after a lost life begins a new game too.
    void reset(const std::vector<bool>& chosen, const std::vector<const Seed*>& seeds, const Batch* batch,
               bool new_games = false);
    // Action i * players() + p is for player p of lane `environments[i]`; it is an index. Strength i is a factor for
    // paddles. If a batch has all environments, those without an action repeat their last observation. Otherwise the
    // environments are those of `recent()`, in any order.
    void step(const std::vector<int>& environments, const int64_t* actions, const float* strengths, const Batch* batch);
    // Plays `sequence->steps` steps of the environments, if batches have all environments: step k of lane
    // `environments[i]` has the actions and the strength with the number i * steps + k. The batch gets the results of the
    // last step, or a row of results for each step, and the sequence gets its own results.
    void play(const std::vector<int>& environments, const int64_t* actions, const float* strengths, const Batch* batch,
              std::shared_ptr<Sequence> sequence);
    // Waits for a batch; returns whether an episode or a game ended in it. Rethrows the deferred error of an
    // environment; all environments must then be reset.
    bool receive(const Batch& batch);
    // Waits for all pending results and drops them, deferred errors included.
    void drain();

    Lane& lane(int environment) {
        apply_restore(slot(environment));
        return *slot(environment).lane;
    }
    // Returns RAM, 128 bytes. By kNow: the present RAM. By kResult: the RAM of the last result, whose copies lie side
    // by side and are faster to read. By kFinal: the RAM at the end of an episode, if one ended and was reset in the
    // last step, otherwise the RAM of kResult.
    enum class RamOf { kNow, kResult, kFinal };
    const uint8_t* ram(int environment, RamOf of) {
        if (of == RamOf::kNow) return lane(environment).environment().ram();
        if (of == RamOf::kFinal && slot(environment).has_final) return slot(environment).final_ram;
        return result_rams_.data() + 128 * static_cast<size_t>(environment);
    }
    const Game& game(int environment) const { return *slot(environment).lane->environment().parts().game; }
    int players() const { return players_; }  // in each environment
    // Returns whether the next step resets the environment, or without autoreset plays nothing.
    bool ended(int environment) const { return slot(environment).outcome.ended; }
    // The state of a lane as bytes. `load` returns false and changes nothing if no such lane can have saved the
    // bytes.
    size_t state_size(int environment) const { return 1 + slot(environment).lane->state_size(); }
    void save(int environment, uint8_t* out);
    bool load(int environment, const uint8_t* in);

    struct LaneSnapshot {
        std::shared_ptr<const Game> game;
        LaneState state;
        Outcome outcome;
        std::vector<uint8_t> bytes() const;  // the bytes that `save` would write
    };
    using Snapshot = std::shared_ptr<const LaneSnapshot>;
    Snapshot snapshot(int environment);
    // Returns the snapshot of the state that `load` would read, or null if `load` would fail. The environment does not
    // change.
    Snapshot parse(int environment, const uint8_t* in);
    bool fits(int environment, const LaneSnapshot& snapshot) const;
    // The state is copied when the environment is next played or read, so mostly by the threads. It is never copied if
    // another restore comes first. The restored state's result replaces a result that has not been received. With
    // `own_generators` the environment's next draws are those that it would have made.
    void restore(int environment, Snapshot snapshot, bool own_generators = false);

  private:
    enum class Task : uint8_t { kReset, kStep, kPlay, kObserve, kNothing };

    // A lane with its task and its last results.
    struct Slot {
        std::unique_ptr<Lane> lane;
        Snapshot pending_restore;
        Task task = Task::kObserve;
        bool new_game = false;  // whether a reset begins a new game
        const Seed* seed = nullptr;
        Seed seed_value{};
        int actions[kMaxPlayers]{};
        float strength = 1.0f;
        size_t played_row = 0;                // of the sequence's actions, for kPlay
        Outcome outcome;                      // the last step's
        std::optional<EndedGame> ended_game;  // ended in the last task
        bool has_final = false;
        bool final_is_whole = true;                    // see ObservationStack::is_whole
        std::optional<EndedGame> final_game;           // ended in the step before the reset of the same task
        std::vector<uint8_t> final_pixels;             // used while the row of the batch is not known
        uint8_t final_ram[128], final_shown_ram[128];  // the emulator's, and what the agent sees
        int32_t final_numbers[2];                      // frame and episode frame
        int32_t final_lives[kMaxPlayers];
    };

    Slot& slot(int environment) { return slots_[static_cast<size_t>(environment)]; }
    const Slot& slot(int environment) const { return slots_[static_cast<size_t>(environment)]; }
    static void apply_restore(Slot& slot, bool own_generators = false);
    void run_task(int environment);
    void play(Slot& slot, int row);
    void play_sequence(Slot& slot, int environment);
    size_t play_steps(Slot& slot, int environment, size_t undrawn);
    void keep_final(Slot& slot, int row);
    void write_results(Slot& slot, int environment, int row, const Batch& batch);
    void write_players(Slot& slot, int row, const Batch& batch);
    // The arrays of a batch for games that ended.
    struct GameArrays {
        bool* ended;
        double *score, *frames, *seconds;
    };
    void write_game(const std::optional<EndedGame>& ended, int row, const GameArrays& arrays) const;
    void write_final(Slot& slot, int row, const Batch& batch);
    // Returns whether results go to rows in the order in which environments finish.
    bool queued() const { return settings_.batch_size < size(); }

    const VectorSettings settings_;
    const int players_;
    std::vector<Slot> slots_;
    std::vector<int> recent_;
    std::vector<uint8_t> result_rams_;    // 128 bytes for each environment
    const Batch* batch_ = nullptr;        // a batch of all environments, which the threads write to
    std::shared_ptr<Sequence> sequence_;  // which they play; null if they play single steps
    std::unique_ptr<ThreadPool> pool_;
    long process_;  // the process that made the threads
};

}  // namespace atari
