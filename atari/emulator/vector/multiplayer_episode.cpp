// Games of two to four players. tests/multiplayer/test_vector.py compares with `MultiplayerEnv` and NumPy.
#include <algorithm>
#include <cstring>

#include "episode.hpp"

namespace atari {

void MultiplayerEpisode::reset(const Seed* seed) {
    if (seed) {
        environment_->seed(seed->emulator);
        state_.random.seed(seed->own[0]);
    }
    begin_game();
    static constexpr int kNoops[kMaxPlayers] = {};
    const auto [low, high] = settings_.noops;
    int noops = high == 0 ? 0 : low + static_cast<int>(state_.random.below(static_cast<uint32_t>(high - low) + 1));
    for (OfPlayers<int64_t> rewards; noops > 0; --noops) {
        act(kNoops, rewards);
        if (environment_->game_over()) begin_game();
    }
    observation_->begin(true);
    state_.elapsed = 0;
    state_.out = 0;
}

Outcome MultiplayerEpisode::play_step(const int* actions, float) {
    const auto [low, high] = settings_.frame_skip;
    int left = low;
    if (high > low + 1) left += static_cast<int>(state_.random.below(static_cast<uint32_t>(high - low)));
    const uint8_t was_out = state_.out;
    int held[kMaxPlayers] = {};
    for (int player = 0; player < settings_.players; ++player)
        held[player] = was_out >> player & 1 ? start_.idle : actions[player];
    Outcome outcome;
    OfPlayers<int64_t> total{};
    while (left > 0 && !outcome.ended) {
        --left;
        act(held, total);
        ++state_.elapsed;
        state_.out |= players_out();
        outcome.terminated = environment_->game_over() || state_.out == (1 << settings_.players) - 1;
        outcome.truncated = state_.elapsed >= settings_.max_frames && !outcome.terminated;
        outcome.ended = outcome.terminated || outcome.truncated;
        observation_->frame_played(left, outcome.ended);
    }
    observation_->skip_ended(left, outcome.ended);
    outcome.out = state_.out;
    const int64_t most = settings_.clip_reward ? 1 : INT32_MAX;
    for (size_t player = 0; player < kMaxPlayers; ++player)
        if (!(was_out >> player & 1)) outcome.reward[player] = static_cast<int>(std::clamp(total[player], -most, most));
    return outcome;
}

uint8_t MultiplayerEpisode::players_out() const {
    int out = 0;
    for (int player = 0; player < settings_.players; ++player) out |= (environment_->lives(player) < 0) << player;
    return static_cast<uint8_t>(out);
}

void MultiplayerEpisode::save_own(uint8_t* out) const {
    std::memcpy(out, &state_, sizeof state_);
    std::memset(out + sizeof state_, 0, static_cast<size_t>(settings_.players));
}

void MultiplayerEpisode::load_own(const uint8_t* in) {
    std::memcpy(&state_, in, sizeof state_);
    state_.random.position = std::min(state_.random.position, 624u);
    state_.out &= static_cast<uint8_t>((1 << settings_.players) - 1);
}

}  // namespace atari
