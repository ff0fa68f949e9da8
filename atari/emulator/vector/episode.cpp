#include "episode.hpp"

#include <algorithm>
#include <cstring>
#include <type_traits>

namespace atari {

void Episode::reset(const Seed* seed, bool new_game, std::optional<int> noops, bool press_fire) {
    reset_layer(layers_.size() - 1, {seed, new_game, noops, press_fire});
    // The stack is a `FrameStack` outside of all layers if one of them is outside of the skip; a reset fills it anew.
    if (layers_.back() != Layer::kSkip) observation_->repeat(true);
    state_.steps = 0;
    if (formula_) formula_->begin(inputs_.data(), game_.ram(), game_.lives());
}

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

void Episode::end_game() {
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - game_began_;
    ended_game_ = {score_, game_.episode_frame_number() - state_.first_frame, seconds.count()};
}

// Only scores of players who play are saved: states of another number of players have another size, and do not fit.
size_t Episode::state_size() const {
    return observation_->state_size() + random_.state_size() + sizeof state_ +
           sizeof score_[0] * static_cast<size_t>(settings_.players) + sizeof inputs_[0] * inputs_.size();
}

void Episode::save(uint8_t* out) const {
    static_assert(std::has_unique_object_representations_v<decltype(state_)>);  // all bytes have a value
    out = observation_->save(out);
    random_.save(out);
    out += random_.state_size();
    std::memcpy(out, &state_, sizeof state_);
    const size_t scores = sizeof score_[0] * static_cast<size_t>(settings_.players);
    std::memcpy(out + sizeof state_, score_.data(), scores);
    if (formula_) std::memcpy(out + sizeof state_ + scores, inputs_.data(), sizeof inputs_[0] * inputs_.size());
}

void Episode::load(const uint8_t* in) {
    in = observation_->load(in);
    random_.load(in);
    in += random_.state_size();
    std::memcpy(&state_, in, sizeof state_);
    const size_t scores = sizeof score_[0] * static_cast<size_t>(settings_.players);
    std::memcpy(score_.data(), in + sizeof state_, scores);
    if (formula_) std::memcpy(inputs_.data(), in + sizeof state_ + scores, sizeof inputs_[0] * inputs_.size());
    // Values that another setting has saved have no meaning here.
    if (!settings_.episodic_life) state_.life_lost = state_.same_game = 0;
    state_.out &= static_cast<uint8_t>(settings_.players == 1 ? 0 : (1 << settings_.players) - 1);
}

}  // namespace atari
