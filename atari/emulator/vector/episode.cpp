#include "episode.hpp"

#include <algorithm>
#include <cstring>

namespace atari {

Outcome Episode::step(const int* actions, float strength) {
    const OfPlayers<int64_t> score_before = score_;
    const int lives_before = game_.lives();
    const uint8_t were_out = state_.out;
    ++state_.game_steps;
    ++state_.steps;
    const Ends ends = step_layer(layers_.size() - 1, move_of(actions, strength));
    // TimeLimit
    const auto& most_steps = settings_.max_episode_steps;
    const bool no_more_steps = most_steps && state_.steps >= static_cast<uint32_t>(*most_steps);
    if ((ends.truncated || no_more_steps) && !ended_game_) end_game();  // by a limit that the emulator does not have
    // A reported loss of a life hides that the same step was truncated, as in ale-py's vector environment.
    const bool reports_loss = settings_.life_loss_info && !ends.terminated && has_lost_life(lives_before);
    Outcome outcome;
    outcome.terminated = ends.terminated || reports_loss;
    outcome.truncated = (ends.truncated && !reports_loss) || no_more_steps;
    outcome.limited = ends.truncated || no_more_steps;
    outcome.ended = ends.any() || no_more_steps;
    outcome.out = state_.out;
    outcome.game_over = game_.game_over();
    outcome.game_steps = game_steps();
    pay(outcome, score_before, were_out);
    return outcome;
}

// The engine plays the idle action for players who are out.
Episode::Move Episode::move_of(const int* actions, float strength) const {
    Move move{{}, strength};
    for (int player = 0; player < settings_.players; ++player) {
        const auto at = static_cast<size_t>(player);
        move.actions[at] = state_.out >> player & 1 ? start_.idle[at] : actions[player];
    }
    return move;
}

// ClipReward, after ExpressionReward and GameStatistics. Players who were out before the step get nothing.
void Episode::pay(Outcome& outcome, const OfPlayers<int64_t>& score_before, uint8_t were_out) {
    const int64_t low = settings_.reward_clipping ? -1 : INT32_MIN, high = settings_.reward_clipping ? 1 : INT32_MAX;
    for (size_t player = 0; player < kMaxPlayers; ++player) {
        const int64_t reward = score_[player] - score_before[player];
        outcome.game_reward[player] = static_cast<int>(reward);
        if (!(were_out >> player & 1)) outcome.reward[player] = static_cast<int>(std::clamp(reward, low, high));
    }
    if (!formula_) return;
    const double paid = formula_->pay(inputs_.data(), game_.ram(), game_.lives(), outcome.game_reward[0]);
    outcome.own_reward = settings_.reward_clipping ? std::clamp(paid, -1.0, 1.0) : paid;
}

void Episode::go_on(int64_t score, int steps, int first_frame) {
    state_ = {};
    state_.game_steps = state_.steps = static_cast<uint32_t>(steps);
    state_.first_frame = first_frame;
    state_.frame_number = game_.frame_number();
    state_.lives = game_.lives();
    score_[0] = score;
    show();
    observation_->begin(true);
}

void Episode::end_game() {
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - game_began_;
    ended_game_ = {score_, game_.episode_frame_number() - state_.first_frame, seconds.count()};
}

size_t Episode::state_size() const {
    size_t size = observation_->state_size() + random_.state_size();
    each_part(*this, [&](const auto* data, size_t count) { size += sizeof *data * count; });
    return size;
}

void Episode::save(uint8_t* out) const {
    out = observation_->save(out);
    random_.save(out);
    out += random_.state_size();
    each_part(*this, [&](const auto* data, size_t count) {
        if (count) std::memcpy(out, data, sizeof *data * count);
        out += sizeof *data * count;
    });
}

void Episode::load(const uint8_t* in) {
    in = observation_->load(in);
    random_.load(in);
    in += random_.state_size();
    each_part(*this, [&](auto* data, size_t count) {
        if (count) std::memcpy(data, in, sizeof *data * count);
        in += sizeof *data * count;
    });
    repair();
}

}  // namespace atari
