#include "episode.hpp"

#include <algorithm>
#include <cstring>

namespace atari {

// As in ale-py: FIRE counts as one of the no-ops, and is not pressed again if the game ends during them.
void AleEpisode::reset(const Seed* seed) {
    Environment& e = *environment_;
    if (seed) {
        e.seed(seed->emulator);
        state_.random.seed(seed->own[0]);
    }
    begin_game();
    const bool fire = settings_.fire != FirePress::kNever && start_.has_fire;
    if (fire) act(1, 1.0f);
    const int noops = static_cast<int>(state_.random.below(static_cast<uint32_t>(settings_.noops.second) + 1));
    for (int i = fire; i < noops; ++i) {
        act(0, 1.0f);
        if (e.game_over()) begin_game();
    }
    observation_->begin(true);
    state_.elapsed = 0;
    state_.lives = e.lives();
}

Outcome AleEpisode::play_step(const int* actions, float strength) {
    Environment& e = *environment_;
    const auto [low, high] = settings_.frame_skip;
    int left = low;
    if (high > low + 1) left += static_cast<int>(state_.random.below(static_cast<uint32_t>(high - low)));
    Outcome outcome;
    bool over = false, lost = false;
    int64_t total = 0;
    while (left > 0 && !outcome.ended) {
        --left;
        total += act(*actions, strength);
        ++state_.elapsed;
        over = e.game_over();
        lost = e.lives() > 0 && e.lives() < state_.lives;
        outcome.ended = over || state_.elapsed >= settings_.max_frames || (settings_.episodic_life && lost);
        observation_->frame_played(left, outcome.ended);
    }
    observation_->skip_ended(left, outcome.ended);
    state_.lives = e.lives();
    outcome.terminated = over || (lost && (settings_.episodic_life || settings_.life_loss_info));
    outcome.truncated = state_.elapsed >= settings_.max_frames && !outcome.terminated;
    const int64_t most = settings_.clip_reward ? 1 : INT32_MAX;
    outcome.reward[0] = static_cast<int>(std::clamp(total, -most, most));
    return outcome;
}

void AleEpisode::save_own(uint8_t* out) const { std::memcpy(out, &state_, sizeof state_); }

void AleEpisode::load_own(const uint8_t* in) {
    std::memcpy(&state_, in, sizeof state_);
    state_.random.position = std::min(state_.random.position, 624u);
}

}  // namespace atari
