// One environment of a vector: an `Environment` and what is around it. How an episode begins, how long an action is held
// and what ends an episode differs between implementations; each is a `Player`.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "environment.hpp"
#include "pcg64.hpp"
#include "random.hpp"
#include "view.hpp"

namespace atari {

struct Seed {
    uint32_t emulator;  // of sticky actions
    uint32_t own[8];    // of everything else: the state of NumPy's generator, or for ALE one word
};

struct Outcome {
    int reward = 0;
    bool terminated = false, truncated = false;
    bool ended = false;  // a reset is due; a life that was lost may be told as a termination without
};

enum class Fire { kNever, kBeforeNoops, kAfterNoops };
enum class OnReset { kNoop, kContinue, kNewGame };  // what a reset does after a lost life

struct PlaySettings {
    std::pair<int, int> frame_skip{4, 5};  // low, and one more than high
    // An episode begins with so many no-ops, FIRE counted as one of them or not.
    int noop_min = 0, noop_max = 29;
    bool fire_counts = true;
    Fire fire = Fire::kBeforeNoops;  // in games that have it
    bool episodic_life = false, life_loss_info = false;
    OnReset on_reset = OnReset::kNewGame;
    bool last_life = false;       // whether losing the last life counts, where the game goes on after it
    bool seamless_lives = false;  // a lost life does not cut the skip and its reset does not clear the stack
    bool clip_reward = true;
    int max_frames = 108000;      // of an episode, not counting those that begin it
};

// Of the game's actions, what the beginning of an episode needs.
struct Start {
    bool has_noop, has_fire;
    int third;  // ALE's number of the action with index 2
};

class Player {
  public:
    Player(std::unique_ptr<Environment> environment, const PlaySettings& settings, const ViewSettings& view,
           std::shared_ptr<const Scaler> scaler, const Start& start)
        : settings_(settings), start_(start), environment_(std::move(environment)),
          view_(*environment_, view, std::move(scaler)) {}
    virtual ~Player() = default;

    // Begins an episode; with a seed, after all generators have been given it. May throw, as Environment::reset.
    virtual void reset(const Seed* seed) = 0;
    virtual Outcome step(int action, float strength) = 0;

    Environment& environment() { return *environment_; }
    const View& view() const { return view_; }

    size_t state_size() const { return environment_->state_size() + view_.state_size() + own_state_size(); }
    void save(uint8_t* out);
    bool load(const uint8_t* in);  // false, and nothing changed, if no player could have saved it

    // The same in memory and faster, for players of the same game and settings.
    struct Copy {
        EnvironmentCopy environment;
        std::vector<uint8_t> rest;
    };
    void copy_to(Copy& copy) const;
    void copy_from(const Copy& copy);

  protected:
    // What the class itself keeps between calls.
    virtual size_t own_state_size() const = 0;
    virtual void save_own(uint8_t* out) const = 0;
    virtual void load_own(const uint8_t* in) = 0;

    const PlaySettings settings_;
    const Start start_;
    std::unique_ptr<Environment> environment_;
    View view_;
};

// ale-py's AtariVectorEnv (0.12), to the byte.
class AlePlayer final : public Player {
  public:
    AlePlayer(std::unique_ptr<Environment> environment, const PlaySettings& settings, const ViewSettings& view,
              std::shared_ptr<const Scaler> scaler, const Start& start, const Seed& seed)
        : Player(std::move(environment), settings, view, std::move(scaler), start) {
        state_.random.seed(seed.own[0]);
    }

    void reset(const Seed* seed) override;
    Outcome step(int action, float strength) override;

  private:
    size_t own_state_size() const override { return sizeof state_; }
    void save_own(uint8_t* out) const override;
    void load_own(const uint8_t* in) override;

    struct {
        MersenneTwister random;
        int elapsed;
        int lives;  // after the last step
    } state_{};
};

// The wrappers of atari/wrappers in C++, to the byte. What they have in common; the classes below are the orders in which
// presets put them around each other.
class WrappedPlayer : public Player {
  public:
    WrappedPlayer(std::unique_ptr<Environment> environment, const PlaySettings& settings, const ViewSettings& view,
                  std::shared_ptr<const Scaler> scaler, const Start& start, const Seed& seed)
        : Player(std::move(environment), settings, view, std::move(scaler), start) {
        state_.random.set(seed.own);
    }

  protected:
    struct Ends {
        bool terminated, truncated;
        bool any() const { return terminated || truncated; }
    };

    void start_game(const Seed* seed);
    Ends play(int action, float strength, int64_t& reward);
    bool lose_life(const Ends& ends);
    int draw_noops();
    int clipped(int64_t reward) const;

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

// EpisodicLife, NoopReset and FireReset, frame by frame, beneath DqnPreprocessing.
class FramePlayer final : public WrappedPlayer {
  public:
    using WrappedPlayer::WrappedPlayer;
    void reset(const Seed* seed) override;
    Outcome step(int action, float strength) override;

  private:
    struct Request {
        const Seed* seed;
        bool new_game;
    };
    void reset_life(const Request& request);
    void reset_with_fire(const Request& request);
    void reset_with_noops(const Request& request);
    Ends frame(int action, float strength, int64_t& reward);
};

// NoopReset beneath DqnPreprocessing; EpisodicLife and FireReset around it, by whole skips (OpenAI's Baselines).
class BaselinesPlayer final : public WrappedPlayer {
  public:
    using WrappedPlayer::WrappedPlayer;
    void reset(const Seed* seed) override;
    Outcome step(int action, float strength) override;

  private:
    void reset_life(const Seed* seed);
    void reset_game(const Seed* seed);
    Ends skip(int action, float strength, int64_t& reward);
    Ends skip_with_lives(int action, float strength, int64_t& reward);
};

}  // namespace atari
