// One environment of a vector: an `Environment` and what is around it. How an episode begins, how long an action is held
// and what ends an episode differs between implementations; each is a `Player`.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "environment.hpp"
#include "random.hpp"
#include "view.hpp"

namespace atari {

struct Seed {
    uint32_t emulator;  // of sticky actions
    uint32_t own;       // of everything else
};

struct Outcome {
    int reward = 0;
    bool terminated = false, truncated = false;
    bool ended = false;  // a reset is due; a life that was lost may be told as a termination without
};

struct PlaySettings {
    std::pair<int, int> frame_skip{4, 5};  // low, and one more than high
    int noop_max = 30;
    bool fire = true;           // at the beginning of an episode, if the game has it
    bool episodic_life = false, life_loss_info = false;
    bool clip_reward = true;
    int max_frames = 108000;    // of an episode, not counting those that begin it
};

class Player {
  public:
    Player(std::unique_ptr<Environment> environment, const PlaySettings& settings, const ViewSettings& view,
           std::shared_ptr<const Scaler> scaler, bool has_fire)
        : settings_(settings), has_fire_(has_fire), environment_(std::move(environment)),
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

  protected:
    // What the class itself keeps between calls.
    virtual size_t own_state_size() const = 0;
    virtual void save_own(uint8_t* out) const = 0;
    virtual void load_own(const uint8_t* in) = 0;

    const PlaySettings settings_;
    const bool has_fire_;
    std::unique_ptr<Environment> environment_;
    View view_;
};

// ale-py's AtariVectorEnv (0.12), to the byte.
class AlePlayer final : public Player {
  public:
    AlePlayer(std::unique_ptr<Environment> environment, const PlaySettings& settings, const ViewSettings& view,
              std::shared_ptr<const Scaler> scaler, bool has_fire, uint32_t seed)
        : Player(std::move(environment), settings, view, std::move(scaler), has_fire) {
        state_.random.seed(seed);
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

}  // namespace atari
