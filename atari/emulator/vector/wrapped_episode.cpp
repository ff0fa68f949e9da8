// The wrappers of atari/wrappers. The comment above each function names the wrapper's method that it implements.
#include <algorithm>
#include <cstring>

#include "episode.hpp"

namespace atari {

// AtariEnv.reset
void WrappedEpisode::start_game(const Seed* seed) {
    if (seed) {
        environment_->seed(seed->emulator);
        state_.random.set(seed->own);
    }
    begin_game();
}

// AtariEnv.play_frames, of one frame
WrappedEpisode::Ends WrappedEpisode::play(int action, float strength, int64_t& reward) {
    reward += act(action, strength);
    return {environment_->game_over(), environment_->truncated()};
}

// EpisodicLife.observe
bool WrappedEpisode::lose_life(const Ends& ends) {
    const int lives = environment_->lives();
    const bool lost = lives < state_.lives && (lives > 0 || settings_.last_life);
    state_.lives = lives;
    state_.life_lost = (state_.life_lost || lost) && !ends.any();
    return lost;
}

// NoopReset._draw
int WrappedEpisode::draw_noops() {
    if (settings_.noops.second == 0) return 0;
    const int noops = state_.random.integers(settings_.noops.first, settings_.noops.second + 1);
    return noops - (settings_.fire_counts && start_.has_fire);
}

// ClipReward
Outcome WrappedEpisode::outcome(int64_t reward, const Ends& ends) const {
    const int64_t low = settings_.clip_reward ? -1 : INT32_MIN, high = settings_.clip_reward ? 1 : INT32_MAX;
    Outcome outcome;
    outcome.reward[0] = static_cast<int>(std::clamp(reward, low, high));
    outcome.terminated = ends.terminated;
    outcome.truncated = ends.truncated;
    outcome.ended = ends.any();
    return outcome;
}

void WrappedEpisode::save_own(uint8_t* out) const { std::memcpy(out, &state_, sizeof state_); }

void WrappedEpisode::load_own(const uint8_t* in) { std::memcpy(&state_, in, sizeof state_); }

// EpisodicLife.reset
void FrameEpisode::reset_life(const Request& request) {
    if (!settings_.episodic_life) return start_game(request.seed);
    const bool new_game = request.seed || settings_.on_reset == OnReset::kNewGame || request.new_game;
    state_.same_game = state_.life_lost && !new_game;
    state_.life_lost = false;
    if (state_.same_game) return;  // the same game continues
    start_game(request.seed);
    state_.lives = environment_->lives();
}

// FireReset.reset
void FrameEpisode::reset_with_fire(const Request& request) {
    const auto reset = [&] {
        settings_.fire == FirePress::kAfterNoops ? reset_with_noops(request) : reset_life(request);
    };
    reset();
    int64_t reward = 0;
    if (start_.has_fire && frame(1, 1.0f, reward).any()) reset();
}

// NoopReset.reset
void FrameEpisode::reset_with_noops(const Request& request) {
    const auto reset = [&] {
        settings_.fire == FirePress::kBeforeNoops ? reset_with_fire(request) : reset_life(request);
    };
    reset();
    int64_t reward = 0;
    for (int left = draw_noops(); left > 0; --left) {
        // NOOP is no action of some games; NoopReset then plays it past EpisodicLife.
        const Ends ends = start_.has_noop ? frame(0, 1.0f, reward) : play(0, 1.0f, reward);
        if (ends.any()) reset();
    }
}

// EpisodicLife.step, on a frame
FrameEpisode::Ends FrameEpisode::frame(int action, float strength, int64_t& reward) {
    Ends ends = play(action, strength, reward);
    if (settings_.episodic_life) ends.terminated |= lose_life(ends);
    return ends;
}

// DqnPreprocessing.reset
void FrameEpisode::reset(const Seed* seed) {
    const Request request{seed, state_.frames_played >= settings_.max_frames};
    settings_.fire == FirePress::kAfterNoops ? reset_with_fire(request) : reset_with_noops(request);
    const bool same_game = settings_.episodic_life && state_.same_game;
    if (!same_game) state_.frames_played = 0;
    const bool fill = !same_game || !settings_.seamless_lives;
    if (same_game && environment_->frame_number() == state_.frame_number) observation_->repeat(fill);
    else observation_->begin(fill);
}

// DqnPreprocessing.step
Outcome FrameEpisode::play_step(const int* actions, float strength) {
    const bool seamless = settings_.episodic_life && settings_.seamless_lives;
    Ends ends{};
    int64_t reward = 0;
    int left = settings_.frame_skip.first;
    while (left > 0 && !ends.any()) {
        --left;
        ends = frame(*actions, strength, reward);
        if (seamless && state_.life_lost) ends.terminated = false;  // reported after the skip
        ++state_.frames_played;
        ends.truncated |= state_.frames_played >= settings_.max_frames && !ends.terminated;
        observation_->frame_played(left, ends.any());
    }
    observation_->skip_ended(left, ends.any());
    if (seamless && state_.life_lost) ends.terminated = !ends.truncated;
    state_.frame_number = environment_->frame_number();
    return outcome(reward, ends);
}

// DqnPreprocessing.step
BaselinesEpisode::Ends BaselinesEpisode::skip(int action, float strength, int64_t& reward) {
    Ends ends{};
    int left = settings_.frame_skip.first;
    while (left > 0 && !ends.any()) {
        --left;
        ends = play(action, strength, reward);
        observation_->frame_played(left, ends.any());
    }
    observation_->skip_ended(left, ends.any());
    return ends;
}

// EpisodicLife.step
BaselinesEpisode::Ends BaselinesEpisode::skip_with_lives(int action, float strength, int64_t& reward) {
    Ends ends = skip(action, strength, reward);
    if (settings_.episodic_life) ends.terminated |= lose_life(ends);
    return ends;
}

// NoopReset.reset, then DqnPreprocessing.reset
void BaselinesEpisode::reset_game(const Seed* seed) {
    start_game(seed);
    int64_t reward = 0;
    for (int left = draw_noops(); left > 0; --left)
        if (play(0, 1.0f, reward).any()) start_game(seed);
    observation_->begin(true);
}

// EpisodicLife.reset
void BaselinesEpisode::reset_life(const Seed* seed) {
    if (!settings_.episodic_life) return reset_game(seed);
    state_.same_game = state_.life_lost && !seed;
    state_.life_lost = false;
    int64_t reward = 0;
    if (state_.same_game) state_.same_game = !skip(0, 1.0f, reward).any();
    if (!state_.same_game) reset_game(seed);
    state_.lives = environment_->lives();
}

// FireReset.reset, then FrameStack.reset
void BaselinesEpisode::reset(const Seed* seed) {
    reset_life(seed);
    int64_t reward = 0;
    if (start_.has_fire)
        for (int action : {1, start_.third})
            if (skip_with_lives(action, 1.0f, reward).any()) reset_life(seed);
    observation_->repeat(true);
}

Outcome BaselinesEpisode::play_step(const int* actions, float strength) {
    int64_t reward = 0;
    const Ends ends = skip_with_lives(*actions, strength, reward);
    return outcome(reward, ends);
}

}  // namespace atari
