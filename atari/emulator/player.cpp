#include "player.hpp"

#include <algorithm>
#include <cstring>

namespace atari {

void Player::save(uint8_t* out) {
    environment_->save(out);
    save_own(view_.save(out + environment_->state_size()));
}

bool Player::load(const uint8_t* in) {
    if (!environment_->load(in)) return false;
    load_own(view_.load(in + environment_->state_size()));
    return true;
}

void Player::copy_to(Copy& copy) const {
    environment_->copy_to(copy.environment);
    copy.rest.resize(view_.state_size() + own_state_size());
    save_own(view_.save(copy.rest.data()));
}

void Player::copy_from(const Copy& copy) {
    load_own(view_.load(copy.rest.data()));  // first, so that pictures need not be held
    environment_->copy_from(copy.environment);
}

// The order of things, and that FIRE counts as one of the no-ops and is not pressed again when the game ends in them,
// are those of the original.
void AlePlayer::reset(const Seed* seed) {
    Environment& e = *environment_;
    if (seed) {
        e.seed(seed->emulator);
        state_.random.seed(seed->own[0]);
    }
    e.reset();
    const bool fire = settings_.fire != Fire::kNever && start_.has_fire;
    if (fire) e.act(1, 1.0f);
    const int noops = static_cast<int>(state_.random.below(static_cast<uint32_t>(settings_.noop_max) + 1));
    for (int i = fire; i < noops; ++i) {
        e.act(0, 1.0f);
        if (e.game_over()) e.reset();
    }
    view_.begin(true);
    state_.elapsed = 0;
    state_.lives = e.lives();
}

Outcome AlePlayer::step(int action, float strength) {
    Environment& e = *environment_;
    const auto [low, high] = settings_.frame_skip;
    int left = low;
    if (high > low + 1) left += static_cast<int>(state_.random.below(static_cast<uint32_t>(high - low)));
    Outcome outcome;
    bool over = false, lost = false;
    int64_t total = 0;
    while (left > 0 && !outcome.ended) {
        --left;
        total += e.act(action, strength);
        ++state_.elapsed;
        over = e.game_over();
        lost = e.lives() > 0 && e.lives() < state_.lives;
        outcome.ended = over || state_.elapsed >= settings_.max_frames || (settings_.episodic_life && lost);
        view_.played(left, outcome.ended);
    }
    view_.end(left, outcome.ended);
    state_.lives = e.lives();
    outcome.terminated = over || (lost && (settings_.episodic_life || settings_.life_loss_info));
    outcome.truncated = state_.elapsed >= settings_.max_frames && !outcome.terminated;
    const int64_t most = settings_.clip_reward ? 1 : INT32_MAX;
    outcome.reward = static_cast<int>(std::clamp(total, -most, most));
    return outcome;
}

void AlePlayer::save_own(uint8_t* out) const { std::memcpy(out, &state_, sizeof state_); }

void AlePlayer::load_own(const uint8_t* in) {
    std::memcpy(&state_, in, sizeof state_);
    state_.random.position = std::min(state_.random.position, 624u);
}

}  // namespace atari
