// The wrappers of atari/wrappers: each function is a method of one of them, and its comment says which.
#include <algorithm>
#include <cstring>

#include "player.hpp"

namespace atari {

// AtariEnv.reset
void WrappedPlayer::start_game(const Seed* seed) {
    if (seed) {
        environment_->seed(seed->emulator);
        state_.random.set(seed->own);
    }
    environment_->reset();
}

// AtariEnv.play_frames, of one frame
WrappedPlayer::Ends WrappedPlayer::play(int action, float strength, int64_t& reward) {
    reward += environment_->act(action, strength);
    return {environment_->game_over(), environment_->truncated()};
}

// EpisodicLife.observe
bool WrappedPlayer::lose_life(const Ends& ends) {
    const int lives = environment_->lives();
    const bool lost = lives < state_.lives && (lives > 0 || settings_.last_life);
    state_.lives = lives;
    state_.life_lost = (state_.life_lost || lost) && !ends.any();
    return lost;
}

// NoopReset._draw
int WrappedPlayer::draw_noops() {
    if (settings_.noop_max == 0) return 0;
    const int noops = state_.random.integers(settings_.noop_min, settings_.noop_max + 1);
    return noops - (settings_.fire_counts && start_.has_fire);
}

// ClipReward
int WrappedPlayer::clipped(int64_t reward) const {
    const int64_t low = settings_.clip_reward ? -1 : INT32_MIN, high = settings_.clip_reward ? 1 : INT32_MAX;
    return static_cast<int>(std::clamp(reward, low, high));
}

void WrappedPlayer::save_own(uint8_t* out) const { std::memcpy(out, &state_, sizeof state_); }

void WrappedPlayer::load_own(const uint8_t* in) { std::memcpy(&state_, in, sizeof state_); }

// EpisodicLife.reset
void FramePlayer::reset_life(const Request& request) {
    if (!settings_.episodic_life) return start_game(request.seed);
    const bool new_game = request.seed || settings_.on_reset == OnReset::kNewGame || request.new_game;
    state_.same_game = state_.life_lost && !new_game;
    state_.life_lost = false;
    if (state_.same_game) return;  // and it goes on
    start_game(request.seed);
    state_.lives = environment_->lives();
}

// FireReset.reset
void FramePlayer::reset_with_fire(const Request& request) {
    const auto reset = [&] { settings_.fire == Fire::kAfterNoops ? reset_with_noops(request) : reset_life(request); };
    reset();
    int64_t reward = 0;
    if (start_.has_fire && frame(1, 1.0f, reward).any()) reset();
}

// NoopReset.reset
void FramePlayer::reset_with_noops(const Request& request) {
    const auto reset = [&] { settings_.fire == Fire::kBeforeNoops ? reset_with_fire(request) : reset_life(request); };
    reset();
    int64_t reward = 0;
    for (int left = draw_noops(); left > 0; --left) {
        // Doing nothing is no action of some games; then EpisodicLife does not see it.
        const Ends ends = start_.has_noop ? frame(0, 1.0f, reward) : play(0, 1.0f, reward);
        if (ends.any()) reset();
    }
}

// EpisodicLife.step, on a frame
FramePlayer::Ends FramePlayer::frame(int action, float strength, int64_t& reward) {
    Ends ends = play(action, strength, reward);
    if (settings_.episodic_life) ends.terminated |= lose_life(ends);
    return ends;
}

// DqnPreprocessing.reset
void FramePlayer::reset(const Seed* seed) {
    const Request request{seed, state_.frames_played >= settings_.max_frames};
    settings_.fire == Fire::kAfterNoops ? reset_with_fire(request) : reset_with_noops(request);
    const bool same_game = settings_.episodic_life && state_.same_game;
    if (!same_game) state_.frames_played = 0;
    const bool fill = !same_game || !settings_.seamless_lives;
    if (same_game && environment_->frame_number() == state_.frame_number) view_.repeat(fill);
    else view_.begin(fill);
}

// DqnPreprocessing.step
Outcome FramePlayer::step(int action, float strength) {
    const bool seamless = settings_.episodic_life && settings_.seamless_lives;
    Ends ends{};
    int64_t reward = 0;
    int left = settings_.frame_skip.first;
    while (left > 0 && !ends.any()) {
        --left;
        ends = frame(action, strength, reward);
        if (seamless && state_.life_lost) ends.terminated = false;  // it is told when the skip has been played
        ++state_.frames_played;
        ends.truncated |= state_.frames_played >= settings_.max_frames && !ends.terminated;
        view_.played(left, ends.any());
    }
    view_.end(left, ends.any());
    if (seamless && state_.life_lost) ends.terminated = !ends.truncated;
    state_.frame_number = environment_->frame_number();
    return {clipped(reward), ends.terminated, ends.truncated, ends.any()};
}

// DqnPreprocessing.step
BaselinesPlayer::Ends BaselinesPlayer::skip(int action, float strength, int64_t& reward) {
    Ends ends{};
    int left = settings_.frame_skip.first;
    while (left > 0 && !ends.any()) {
        --left;
        ends = play(action, strength, reward);
        view_.played(left, ends.any());
    }
    view_.end(left, ends.any());
    return ends;
}

// EpisodicLife.step
BaselinesPlayer::Ends BaselinesPlayer::skip_with_lives(int action, float strength, int64_t& reward) {
    Ends ends = skip(action, strength, reward);
    if (settings_.episodic_life) ends.terminated |= lose_life(ends);
    return ends;
}

// NoopReset.reset, then DqnPreprocessing.reset
void BaselinesPlayer::reset_game(const Seed* seed) {
    start_game(seed);
    int64_t reward = 0;
    for (int left = draw_noops(); left > 0; --left)
        if (play(0, 1.0f, reward).any()) start_game(seed);
    view_.begin(true);
}

// EpisodicLife.reset
void BaselinesPlayer::reset_life(const Seed* seed) {
    if (!settings_.episodic_life) return reset_game(seed);
    state_.same_game = state_.life_lost && !seed;
    state_.life_lost = false;
    int64_t reward = 0;
    if (state_.same_game) state_.same_game = !skip(0, 1.0f, reward).any();
    if (!state_.same_game) reset_game(seed);
    state_.lives = environment_->lives();
}

// FireReset.reset, then FrameStack.reset
void BaselinesPlayer::reset(const Seed* seed) {
    reset_life(seed);
    int64_t reward = 0;
    if (start_.has_fire)
        for (int action : {1, start_.third})
            if (skip_with_lives(action, 1.0f, reward).any()) reset_life(seed);
    view_.repeat(true);
}

Outcome BaselinesPlayer::step(int action, float strength) {
    int64_t reward = 0;
    const Ends ends = skip_with_lives(action, strength, reward);
    return {clipped(reward), ends.terminated, ends.truncated, ends.any()};
}

}  // namespace atari
