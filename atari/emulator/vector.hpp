// Many environments, played by a pool of threads, with results written straight into the arrays that the user gets.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "player.hpp"
#include "thread_pool.hpp"

namespace atari {

enum class Autoreset { kNextStep, kSameStep, kDisabled };

// Where the results of a batch go: arrays with a row for each of its environments. Null is not wanted.
struct Batch {
    struct Observation {
        uint8_t* pixels = nullptr;
        uint8_t* ram = nullptr;  // 128 a row
    };
    struct Numbers {
        int32_t *lives = nullptr, *frame = nullptr, *episode_frame = nullptr;
    };
    Observation observation, final_observation;
    Numbers numbers, final_numbers;
    int32_t *reward = nullptr, *environment = nullptr;
    uint8_t *terminated = nullptr, *truncated = nullptr;
    uint8_t* ended = nullptr;  // whether the row of the final observation is one; kSameStep only
};

struct VectorSettings {
    int batch_size, threads, first_core = -1;
    Autoreset autoreset = Autoreset::kNextStep;
};

class Vector {
  public:
    struct Member {
        std::unique_ptr<Player> player;
        std::vector<int> actions;  // ALE's numbers, by the user's
    };

    Vector(std::vector<Member> members, const VectorSettings& settings);
    ~Vector();

    int size() const { return static_cast<int>(slots_.size()); }
    int batch_size() const { return settings_.batch_size; }
    // Environments whose results have not been received.
    int pending() const { return pool_->pending(); }
    int actions_of(int environment) const { return static_cast<int>(slot(environment).member.actions.size()); }

    // Each of these has environments worked on; `receive` gets the results. With a batch of all environments they go to
    // row i for environment i and `batch` must live until then; otherwise it may be null.
    // Resets environments, `seeds[i]` with a seed if it is not null. The others report what they showed last.
    void reset(const std::vector<bool>& chosen, const std::vector<const Seed*>& seeds, const Batch* batch);
    // Row i is about environment `environments[i]`; an action is an index.
    void step(const int* environments, const int64_t* actions, const float* strengths, int count, const Batch* batch);
    // Waits for a batch. Throws what an environment has thrown, after which all must be reset.
    void receive(const Batch& batch);
    // Waits for whatever is pending, and forgets it.
    void drain();

    Player& player(int environment) {
        settle(slot(environment));
        return *slot(environment).member.player;
    }
    const Game& game(int environment) const { return *slot(environment).member.player->environment().game(); }
    size_t pixels() const { return slot(0).member.player->view().size(); }  // bytes of an observation
    // The state of a member as bytes, and back; false, and nothing changed, if it is of no such member.
    size_t state_size(int environment) const { return 1 + slot(environment).member.player->state_size(); }
    void save(int environment, uint8_t* out);
    bool load(int environment, const uint8_t* in);

    // The same in memory and faster, for members of the same game.
    struct Copy {
        std::shared_ptr<const Game> game;
        Player::Copy player;
        Outcome outcome;
        std::vector<uint8_t> bytes() const;  // what `save` would write
    };
    using Snapshot = std::shared_ptr<const Copy>;
    Snapshot snapshot(int environment);
    // What `load` would make of bytes; null if it would refuse. The environment is as it was afterwards.
    Snapshot parse(int environment, const uint8_t* in);
    bool fits(int environment, const Copy& copy) const;
    // The copying is done where the environment is played or looked at next, so mostly by the threads, and not at all
    // if another restore comes first.
    void restore(int environment, Snapshot snapshot) { slot(environment).due = std::move(snapshot); }

  private:
    enum class Task : uint8_t { kReset, kStep, kReport };

    struct Slot {
        Member member;
        Snapshot due;  // to be continued from
        Task task = Task::kReport;
        const Seed* seed = nullptr;
        Seed seed_value{};
        int action = 0;
        float strength = 1.0f;
        Outcome outcome;  // of the last step
        bool has_final = false;
        std::vector<uint8_t> final_pixels;  // if they could not be written at once
        uint8_t final_ram[128];
        int32_t final_numbers[3];
    };

    Slot& slot(int environment) { return slots_[static_cast<size_t>(environment)]; }
    const Slot& slot(int environment) const { return slots_[static_cast<size_t>(environment)]; }
    static void settle(Slot& slot);
    void work(int environment);
    void play(Slot& slot, int environment);
    void keep_final(Slot& slot, int environment);
    void report(Slot& slot, int environment, int row, const Batch& batch);
    void report_final(Slot& slot, int row, const Batch& batch);
    bool queued() const { return settings_.batch_size < size(); }

    const VectorSettings settings_;
    std::vector<Slot> slots_;
    const Batch* batch_ = nullptr;  // where results are written as they come
    std::unique_ptr<ThreadPool> pool_;
    long process_;
};

}  // namespace atari
