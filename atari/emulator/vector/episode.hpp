// `Episode`: plays the episodes of one environment of the vector engine. Implementations of the preprocessing differ in
// how an episode begins, how long an action is held, and what ends an episode. Each order is a derived class.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "ale/environment.hpp"
#include "observations/observation_stack.hpp"
#include "machine/random.hpp"
#include "pcg64.hpp"

namespace atari {

struct Seed {
    uint32_t emulator;  // of the emulator's generator: sticky actions
    uint32_t own[8];    // of the episode's generator: the state of NumPy's PCG64; for ALE one word, a seed
};

template <typename T>
using OfPlayers = std::array<T, kMaxPlayers>;  // zero for players that do not play

struct Outcome {
    OfPlayers<int> reward{};
    bool terminated = false, truncated = false;
    uint8_t out = 0;     // bit p: player p is out of the game, which goes on or has ended
    bool ended = false;  // The next step resets. With `life_loss_info`, a lost life sets `terminated` without this.
    bool game_over = false;
    OfPlayers<int> game_reward{};  // not clipped
    int game_steps = 0;            // steps of the game, this one included
};

// A whole game that ended: over in the emulator, or truncated.
struct EndedGame {
    OfPlayers<int64_t>
        score;       // the sum of all rewards since the emulator's reset, no-ops and FIRE included, not clipped
    int frames;      // emulated since that reset
    double seconds;  // since that reset
};

// AleEpisode, FrameEpisode, BaselinesEpisode, MultiplayerEpisode
enum class EpisodeKind { kAle, kFrames, kBaselines, kMultiplayer };
enum class FirePress { kNever, kBeforeNoops, kAfterNoops };
enum class OnReset { kNoop, kContinue, kNewGame };  // what a reset does after a lost life

// How episodes begin, are played, and end. The names are those of the wrappers' arguments.
struct EpisodeSettings {
    EpisodeKind kind = EpisodeKind::kAle;
    int players = 1;  // more for kMultiplayer only
    double repeat_action_probability = 0.0;
    int max_num_frames_per_episode = 0;        // the emulator's limit: no-ops count, 0 is no limit
    std::pair<int, int> frame_skip{4, 5};      // each step draws from first .. second-1
    std::pair<int, int> noops{0, 29};          // an episode begins with first .. second no-ops
    bool fire_counts = true;                   // whether FIRE is one of the no-ops
    FirePress fire = FirePress::kBeforeNoops;  // in games that have FIRE
    bool episodic_life = false, life_loss_info = false;
    OnReset on_reset = OnReset::kNewGame;
    bool last_life = false;       // whether losing the last life counts if the game continues after it
    bool seamless_lives = false;  // a lost life does not cut the skip and its reset does not clear the stack
    bool clip_reward = true;
    int max_frames = 108000;  // the episode's limit, without the no-ops and FIRE that begin it

    Settings emulator() const {
        Settings settings{repeat_action_probability, 1, max_num_frames_per_episode};
        settings.one_generator = settings.second_player_starts = kind == EpisodeKind::kMultiplayer;
        return settings;
    }
};

// The actions of a game that can begin an episode.
struct StartActions {
    bool has_noop, has_fire;
    int third;  // ALE's number of the action with index 2
    int idle;   // of the action with index 0 that a user gives: what players who are out do
};

// The state of an episode in memory, for episodes of the same game and settings.
struct EpisodeSnapshot {
    EnvironmentSnapshot environment;
    std::vector<uint8_t> rest;  // observation and own state, as `save` writes them
};

// Owns the environment that it plays and the agent's stack of frames.
class Episode {
  public:
    Episode(std::unique_ptr<Environment> environment, std::unique_ptr<ObservationStack> observation,
            const EpisodeSettings& settings, const StartActions& start)
        : settings_(settings), start_(start), environment_(std::move(environment)),
          observation_(std::move(observation)) {}
    virtual ~Episode() = default;

    // Begins an episode, after seeding all generators if `seed` is not null. Throws as Environment::reset does.
    virtual void reset(const Seed* seed) = 0;
    // Makes the next reset begin a new game, also after a lost life.
    virtual void abandon_game() {}
    // Plays an action of each player, an ALE number, until the skip or the episode ends.
    Outcome step(const int* actions, float strength);
    // The last game that ended since the last call, in a step or in a reset.
    std::optional<EndedGame> take_ended_game() { return std::exchange(ended_game_, std::nullopt); }
    int players() const { return settings_.players; }
    // The steps of the present game, lost lives do not matter.
    int game_steps() const { return game_.steps; }

    Environment& environment() { return *environment_; }
    const ObservationStack& observation() const { return *observation_; }

    size_t state_size() const { return environment_->state_size() + rest_size(); }
    void save(uint8_t* out);
    bool load(const uint8_t* in);  // Returns false, and changes nothing, if no `save` can have written these bytes.
    void snapshot(EpisodeSnapshot& snapshot) const;
    void restore(const EpisodeSnapshot& snapshot);

  protected:
    virtual Outcome play_step(const int* actions, float strength) = 0;
    // The emulator's reset and frames, counted. Derived classes play through these alone.
    void begin_game();
    int act(int action, float strength) {
        const int reward = environment_->act(action, strength);
        game_.score[0] += reward;
        if (environment_->game_over() || environment_->truncated()) end_game();
        return reward;
    }
    // The same for all players; adds the reward of each.
    void act(const int* actions, OfPlayers<int64_t>& rewards);

    // The state of the derived class, as bytes.
    virtual size_t own_state_size() const = 0;
    virtual void save_own(uint8_t* out) const = 0;
    virtual void load_own(const uint8_t* in) = 0;

    const EpisodeSettings settings_;
    const StartActions start_;
    std::unique_ptr<Environment> environment_;
    std::unique_ptr<ObservationStack> observation_;  // reads `environment_`

  private:
    void end_game();
    // The state without the emulator's.
    size_t rest_size() const { return observation_->state_size() + sizeof game_ + own_state_size(); }
    void save_rest(uint8_t* out) const;
    void load_rest(const uint8_t* in);

    // Of the present game, since the emulator's reset.
    struct {
        OfPlayers<int64_t> score;
        int32_t steps;
        int32_t first_frame;  // the emulator's episode frame number after the reset
    } game_{};
    std::chrono::steady_clock::time_point game_began_ = std::chrono::steady_clock::now();
    std::optional<EndedGame> ended_game_;
};

// ale-py's AtariVectorEnv (0.12), to the byte.
class AleEpisode final : public Episode {
  public:
    AleEpisode(std::unique_ptr<Environment> environment, std::unique_ptr<ObservationStack> observation,
               const EpisodeSettings& settings, const StartActions& start, const Seed& seed)
        : Episode(std::move(environment), std::move(observation), settings, start) {
        state_.random.seed(seed.own[0]);
    }

    void reset(const Seed* seed) override;

  private:
    Outcome play_step(const int* actions, float strength) override;
    size_t own_state_size() const override { return sizeof state_; }
    void save_own(uint8_t* out) const override;
    void load_own(const uint8_t* in) override;

    struct {
        MersenneTwister random;
        int elapsed;
        int lives;  // after the last step
    } state_{};
};

// A game of several players, without lives that end an episode and without FIRE. Players whose lives are negative are
// out, as in PettingZoo; the episode ends when all are.
class MultiplayerEpisode final : public Episode {
  public:
    MultiplayerEpisode(std::unique_ptr<Environment> environment, std::unique_ptr<ObservationStack> observation,
                       const EpisodeSettings& settings, const StartActions& start, const Seed& seed)
        : Episode(std::move(environment), std::move(observation), settings, start) {
        state_.random.seed(seed.own[0]);
    }

    void reset(const Seed* seed) override;

  private:
    Outcome play_step(const int* actions, float strength) override;
    uint8_t players_out() const;
    // A byte more for each player: states of another number of players have another size, and do not fit.
    size_t own_state_size() const override { return sizeof state_ + static_cast<size_t>(settings_.players); }
    void save_own(uint8_t* out) const override;
    void load_own(const uint8_t* in) override;

    struct {
        MersenneTwister random;
        int elapsed;
        uint8_t out;  // bit p: player p
    } state_{};
};

// The wrappers of atari/wrappers in C++, to the byte: the parts that both orders of the wrappers share.
class WrappedEpisode : public Episode {
  public:
    WrappedEpisode(std::unique_ptr<Environment> environment, std::unique_ptr<ObservationStack> observation,
                   const EpisodeSettings& settings, const StartActions& start, const Seed& seed)
        : Episode(std::move(environment), std::move(observation), settings, start) {
        state_.random.set(seed.own);
    }

    void abandon_game() override { state_.life_lost = false; }

  protected:
    struct Ends {
        bool terminated, truncated;
        bool any() const { return terminated || truncated; }
    };

    void start_game(const Seed* seed);
    Ends play(int action, float strength, int64_t& reward);
    bool lose_life(const Ends& ends);
    int draw_noops();
    Outcome outcome(int64_t reward, const Ends& ends) const;

    struct {
        Pcg64 random;
        int lives;
        int frames_played;
        int frame_number;  // after the last step
        uint8_t life_lost, same_game;
    } state_{};

  private:
    size_t own_state_size() const override { return sizeof state_; }
    void save_own(uint8_t* out) const override;
    void load_own(const uint8_t* in) override;
};

// The order in which EpisodicLife, NoopReset and FireReset handle single frames, inside of DqnPreprocessing.
class FrameEpisode final : public WrappedEpisode {
  public:
    using WrappedEpisode::WrappedEpisode;
    void reset(const Seed* seed) override;

  private:
    Outcome play_step(const int* actions, float strength) override;
    struct Request {
        const Seed* seed;
        bool new_game;
    };
    void reset_life(const Request& request);
    void reset_with_fire(const Request& request);
    void reset_with_noops(const Request& request);
    Ends frame(int action, float strength, int64_t& reward);
};

// The order of OpenAI's Baselines: NoopReset is inside of DqnPreprocessing; EpisodicLife and FireReset are outside and
// handle whole skips.
class BaselinesEpisode final : public WrappedEpisode {
  public:
    using WrappedEpisode::WrappedEpisode;
    void reset(const Seed* seed) override;

  private:
    Outcome play_step(const int* actions, float strength) override;
    void reset_life(const Seed* seed);
    void reset_game(const Seed* seed);
    Ends skip(int action, float strength, int64_t& reward);
    Ends skip_with_lives(int action, float strength, int64_t& reward);
};

}  // namespace atari
