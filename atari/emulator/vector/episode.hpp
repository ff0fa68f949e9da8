// `Episode`: the rules, counters and frames of the episodes that are played on a game. It nests the layers of
// `atari.wrappers` as its settings specify.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include "ale/programs/labels.hpp"
#include "ale/programs/reward.hpp"
#include "observations/observation_stack.hpp"
#include "episode_random.hpp"
#include "episode_settings.hpp"
#include "played_game.hpp"

namespace atari {

struct Outcome {
    OfPlayers<int> reward{};
    bool terminated = false, truncated = false;
    bool limited = false;  // a limit was reached; `truncated` hides this where a lost life is reported
    uint8_t out = 0;       // bit p: player p is out of the game, which goes on or has ended
    bool ended = false;    // The next step resets. With `life_loss_info`, a lost life sets `terminated` without this.
    bool game_over = false;
    OfPlayers<int> game_reward{};  // not clipped
    int game_steps = 0;            // steps of the game, this one included
    double own_reward = 0.0;       // the value of the task's expression, if it has one

    // The part that a state has, as a byte.
    uint8_t saved() const {
        return static_cast<uint8_t>(terminated | truncated << 1 | ended << 2 | game_over << 3 | out << 4);
    }
    static Outcome of_saved(uint8_t saved, int players) {
        Outcome outcome;
        outcome.terminated = saved & 1;
        outcome.truncated = saved >> 1 & 1;
        outcome.ended = saved >> 2 & 1;
        outcome.game_over = saved >> 3 & 1;
        outcome.out = static_cast<uint8_t>(saved >> 4 & ((1 << players) - 1));
        return outcome;
    }
};

// A whole game that ended: over in the emulator, or truncated.
struct EndedGame {
    OfPlayers<int64_t>
        score;       // the sum of all rewards since the emulator's reset, no-ops and FIRE included, not clipped
    int frames;      // emulated since that reset
    double seconds;  // since that reset
};

// The actions of a game that can begin an episode.
struct StartActions {
    bool has_noop, has_fire;
    int third;            // ALE's number of the action with index 2
    OfPlayers<int> idle;  // ALE's number of the user's action with index 0, which is played for players who are out
};

// Owns the agent's stack of frames, and plays a game that its owner has.
class Episode {
  public:
    // `observation` reads the frames of `game`. `formula` is the reward of a task that has its own, for one player, or
    // null.
    Episode(PlayedGame& game, std::unique_ptr<ObservationStack> observation, const EpisodeSettings& settings,
            const StartActions& start, EpisodeRandom random, std::shared_ptr<const RewardFormula> formula = nullptr)
        : settings_(settings), start_(start), layers_(layers_of(settings)), game_(game),
          observation_(std::move(observation)), random_(std::move(random)), formula_(std::move(formula)),
          inputs_(formula_ ? formula_->inputs() : 0) {}

    // Begins an episode, after seeding all generators if `seed` is not null. After a lost life this may continue the
    // game, but not with a seed or `new_game`. `noops` is the number of no-ops in place of a drawn one; FIRE is pressed
    // only with `press_fire`. Throws as PlayedGame::begin does.
    void reset(const Seed* seed, bool new_game, std::optional<int> noops = std::nullopt, bool press_fire = true);
    // Plays an action of each player, an ALE number, until the skip or the episode ends.
    Outcome step(const int* actions, float strength);
    // Continues a game of one player that another object has played since the emulator's reset; the stack begins anew.
    void go_on(int64_t score, int steps, int first_frame);
    // Returns the last game that ended since the last call, in a step or in a reset.
    std::optional<EndedGame> take_ended_game() { return std::exchange(ended_game_, std::nullopt); }
    int players() const { return settings_.players; }
    bool has_own_reward() const { return formula_ != nullptr; }
    // Returns the steps of the present game, which lost lives do not end.
    int game_steps() const { return static_cast<int>(state_.game_steps); }
    int first_frame() const { return state_.first_frame; }  // the emulator's episode frame number after its reset

    uint8_t out() const { return state_.out; }  // bit p: player p is out of the present game

    const OfPlayers<int64_t>& score() const { return score_; }  // the present game's, since the emulator's reset

    const ObservationStack& observation() const { return *observation_; }
    // See ObservationStack::set_draws.
    void set_draws(bool draws) { observation_->set_draws(draws); }
    // Returns the number of steps, the first ones of several, whose frames the observation after the last step does not
    // contain. That is one frame fewer than it could be, because a step that ends an episode may repeat the frame before.
    size_t undrawn(size_t steps) const {
        const auto drawn = static_cast<size_t>(observation_->settings().stack_num) + 1;
        return observation_->planes() && !delays_frames() && steps > drawn ? steps - drawn : 0;
    }
    // The 128 bytes that the agent sees beside the images.
    const uint8_t* ram() const { return delays_frames() ? oldest_frame() + frame_size_ : game_.ram(); }

    // The state, without the game's.
    size_t state_size() const;
    void save(uint8_t* out) const;
    void load(const uint8_t* in);
    // Returns the offset of the generator in a state. A state without one, of `EpisodeRandom::Draw`, is otherwise equal.
    size_t generator_offset() const { return observation_->state_size(); }
    EpisodeRandom& random() { return random_; }

  private:
    enum class Layer : uint8_t { kGame, kLives, kNoops, kFire, kPlayers, kActionDelay, kObservationDelay, kSkip };
    struct Request {
        const Seed* seed;
        bool new_game;
        std::optional<int> noops;
        bool press_fire;
    };
    struct Move {
        OfPlayers<int> actions{};
        float strength = 1.0f;
    };
    struct Ends {
        bool terminated, truncated;
        bool any() const { return terminated || truncated; }
    };

    // episode_layers.cpp. A layer resets and steps the next inner layer, whose level is lower by one.
    static std::vector<Layer> layers_of(const EpisodeSettings& settings);
    void reset_layer(size_t level, const Request& request);
    Ends step_layer(size_t level, const Move& move);
    void reset_game(const Request& request);
    Ends step_game(const Move& move);
    void reset_lives(size_t level, const Request& request);
    Ends step_lives(size_t level, const Move& move);
    void reset_noops(size_t level, Request request);
    void reset_fire(size_t level, const Request& request);
    void reset_players(size_t level, const Request& request);
    Ends step_players(size_t level, const Move& move);
    // Returns whether the last reset goes on with the stack of the same game, and so with what is delayed.
    bool goes_on() const { return state_.same_game && settings_.seamless_lives && !begun_; }
    void begin_action_line();
    Ends step_action_delay(size_t level, const Move& move);
    bool delays_frames() const { return !frames_.empty(); }
    uint8_t* frame(uint32_t entry) { return frames_.data() + entry * (frame_size_ + kRamSize); }
    const uint8_t* oldest_frame() const { return frames_.data() + frame_line_.oldest * (frame_size_ + kRamSize); }
    void read_frame(uint8_t* to);
    void begin_frame_line(bool held);
    Ends step_observation_delay(size_t level, const Move& move);
    void show();
    void reset_skip(size_t level, Request request);
    Ends step_skip(size_t level, const Move& move);
    bool has_lost_life(int lives_before) const;
    bool has_played_max_frames() const;

    Move move_of(const int* actions, float strength) const;
    void pay(Outcome& outcome, const OfPlayers<int64_t>& score_before, uint8_t were_out);
    void end_game();

    // Calls visit(data, count) with the values of each part of the state of `self`, beside observation and generator.
    // Only scores of players who play are parts: states of another number of players have another size, and do not fit.
    template <typename Self, typename Visit>
    static void each_part(Self& self, Visit&& visit) {
        static_assert(std::has_unique_object_representations_v<State>);  // all bytes have a value
        visit(&self.state_, 1);
        visit(self.score_.data(), static_cast<size_t>(self.settings_.players));
        visit(self.inputs_.data(), self.inputs_.size());
        visit(self.moves_.data(), self.moves_.size());
        visit(&self.action_line_, self.moves_.empty() ? size_t{0} : size_t{1});
        visit(self.frames_.data(), self.frames_.size());
        visit(&self.frame_line_, self.frames_.empty() ? size_t{0} : size_t{1});
    }
    // Replaces loaded values that have no meaning here, because another setting has saved them.
    void repair() {
        if (!settings_.episodic_life) state_.life_lost = state_.same_game = 0;
        state_.out &= static_cast<uint8_t>(settings_.players == 1 ? 0 : (1 << settings_.players) - 1);
        action_line_.length = std::min(action_line_.length, static_cast<uint32_t>(moves_.size()));
        action_line_.oldest = std::min(action_line_.oldest, std::max(action_line_.length, 1u) - 1);
        for (Move& move : moves_) {
            for (int& action : move.actions) action = std::clamp(action, 0, 17);
            if (!std::isfinite(move.strength)) move.strength = 1.0f;
        }
        const auto most_frames = static_cast<uint32_t>(settings_.observation_delay.second) + 1;
        frame_line_.length = std::clamp(frame_line_.length, 1u, most_frames);
        frame_line_.oldest = std::min(frame_line_.oldest, frame_line_.length - 1);
    }

    const EpisodeSettings settings_;
    const StartActions start_;
    const std::vector<Layer> layers_;  // from the inside out
    PlayedGame& game_;
    std::unique_ptr<ObservationStack> observation_;
    EpisodeRandom random_;
    const std::shared_ptr<const RewardFormula> formula_;
    std::vector<double> inputs_;  // of the formula, after the last step or reset
    OfPlayers<int64_t> score_{};
    // Counters are unsigned, so that they wrap instead of overflowing.
    struct State {
        uint32_t game_steps;     // the present game's
        uint32_t frames_played;  // the present game's, without those that began it
        uint32_t steps;          // the episode's
        int32_t first_frame;     // the emulator's episode frame number after its reset
        int32_t frame_number;    // the emulator's, after the last skip
        int32_t lives;           // when kLives compared them last
        uint8_t life_lost;       // since the last reset, and the game continues
        uint8_t same_game;       // whether the last reset continued the game
        uint8_t out;             // bit p: player p
        uint8_t unused;
    };
    State state_{};
    // The entries of a line: the first `length`, the oldest of which is the next to leave it.
    struct Line {
        uint32_t length, oldest;
    };
    std::vector<Move> moves_ = std::vector<Move>(static_cast<size_t>(settings_.action_delay.second));
    Line action_line_{};  // of `moves_`, on their way to the console
    // The frames on their way to the agent: what the stack reads, a frame or RAM or nothing, and the RAM.
    const size_t frame_size_ = observation_->planes()
                                   ? static_cast<size_t>(observation_->source().rows()) * kScreenWidth
                               : observation_->size() ? kRamSize
                                                      : 0;
    std::vector<uint8_t> frames_ = std::vector<uint8_t>(
        settings_.observation_delay.second
            ? (static_cast<size_t>(settings_.observation_delay.second) + 1) * (frame_size_ + kRamSize)
            : 0);
    Line frame_line_{1, 0};  // of `frames_`
    bool resets_ = false;    // true while a reset plays its steps, which are not delayed
    bool begun_ = false;     // whether the last reset has begun a game
    std::chrono::steady_clock::time_point game_began_ = std::chrono::steady_clock::now();
    std::optional<EndedGame> ended_game_;
};

}  // namespace atari
