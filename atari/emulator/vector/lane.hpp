// `Lane`: an environment of the vector engine, with the episode that is played on it.
#pragma once

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "ale/environment_parts.hpp"
#include "episode.hpp"

namespace atari {

class LaneGame final : public PlayedGame {
  public:
    explicit LaneGame(std::unique_ptr<Environment> environment) : environment_(std::move(environment)) {}

    void begin(const uint32_t* seed) override {
        if (seed) environment_->seed(*seed);
        environment_->reset();
    }
    OfPlayers<int> act(const OfPlayers<int>& actions, int players, float strength) override {
        if (records_) [[unlikely]]
            moves_.emplace_back(actions[0], strength);
        return environment_->act(actions, players, strength);
    }
    int lives(int player) const override { return environment_->lives(player); }
    bool game_over() const override { return environment_->game_over(); }
    bool truncated() const override { return environment_->truncated(); }
    int frame_number() const override { return environment_->frame_number(); }
    int episode_frame_number() const override { return environment_->episode_frame_number(); }
    const uint8_t* ram() const override { return environment_->ram(); }

    Environment& environment() const { return *environment_; }

    // Records the first player's ALE action and its strength in each frame, until `take_moves`.
    void record_moves() {
        records_ = true;
        moves_.clear();
    }
    bool records() const { return records_; }
    std::vector<std::pair<int, float>> take_moves() {
        records_ = false;
        return std::exchange(moves_, {});
    }

  private:
    const std::unique_ptr<Environment> environment_;
    bool records_ = false;
    std::vector<std::pair<int, float>> moves_;
};

// The state of a lane in memory, for lanes of the same game and settings.
struct LaneState {
    EnvironmentSnapshot environment;
    std::vector<uint8_t> episode;  // as `Episode::save` writes it
};

class Lane {
  public:
    // `actions` has ALE's number of each action index that the user gives; `observation` reads `environment`.
    Lane(std::unique_ptr<Environment> environment, std::unique_ptr<ObservationStack> observation,
         const EpisodeSettings& settings, const StartActions& start, const Seed& seed,
         std::shared_ptr<const RewardFormula> formula, std::vector<int> actions)
        : game_(std::move(environment)), episode_(game_, std::move(observation), settings, start,
                                                  EpisodeRandom(settings.seeding, seed), std::move(formula)),
          actions_(std::move(actions)) {}
    Lane(const Lane&) = delete;
    Lane& operator=(const Lane&) = delete;

    Environment& environment() const { return game_.environment(); }
    LaneGame& game() { return game_; }
    Episode& episode() { return episode_; }
    const Episode& episode() const { return episode_; }
    const std::vector<int>& actions() const { return actions_; }

    size_t state_size() const { return environment().state_size() + episode_.state_size(); }
    void save(uint8_t* out) {
        environment().save(out);
        episode_.save(out + environment().state_size());
    }
    // Returns false, and changes nothing, if no `save` can have written these bytes.
    bool load(const uint8_t* in) {
        if (!environment().load(in)) return false;
        episode_.load(in + environment().state_size());
        return true;
    }
    void snapshot(LaneState& state) const {
        state.environment = environment().snapshot();
        state.episode.resize(episode_.state_size());
        episode_.save(state.episode.data());
    }
    // The observation releases the framebuffers that it holds; the environment then overwrites them without a copy.
    void restore(const LaneState& state) {
        episode_.load(state.episode.data());
        environment().restore(state.environment);
    }
    // The next draws are those that the lane would have made: of no-ops, skips, sticky actions and writes.
    void restore_with_own_generators(const LaneState& state) {
        EnvironmentState& own = environment().parts().state;
        const EnvironmentState before = own;
        const EpisodeRandom drawn = episode_.random();
        restore(state);
        own.random = before.random;
        std::copy_n(before.writes.random, 2, own.writes.random);
        episode_.random() = drawn;
    }

  private:
    LaneGame game_;
    Episode episode_;
    const std::vector<int> actions_;
};

}  // namespace atari
