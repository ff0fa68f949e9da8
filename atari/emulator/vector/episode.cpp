#include "episode.hpp"

#include <cstring>

namespace atari {

Outcome Episode::step(const int* actions, float strength) {
    const OfPlayers<int64_t> before = game_.score;
    ++game_.steps;
    Outcome outcome = play_step(actions, strength);
    if (outcome.truncated && !ended_game_) end_game();  // by a limit that the emulator does not have
    outcome.game_over = environment_->game_over();
    for (size_t player = 0; player < kMaxPlayers; ++player)
        outcome.game_reward[player] = static_cast<int>(game_.score[player] - before[player]);
    outcome.game_steps = game_.steps;
    return outcome;
}

void Episode::begin_game() {
    environment_->reset();
    game_ = {{}, 0, environment_->episode_frame_number()};
    game_began_ = std::chrono::steady_clock::now();
}

void Episode::act(const int* actions, OfPlayers<int64_t>& rewards) {
    int frame_rewards[kMaxPlayers];
    environment_->act(actions, settings_.players, frame_rewards);
    for (int player = 0; player < settings_.players; ++player) {
        game_.score[static_cast<size_t>(player)] += frame_rewards[player];
        rewards[static_cast<size_t>(player)] += frame_rewards[player];
    }
    if (environment_->game_over() || environment_->truncated()) end_game();
}

void Episode::end_game() {
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - game_began_;
    ended_game_ = {game_.score, environment_->episode_frame_number() - game_.first_frame, seconds.count()};
}

void Episode::save(uint8_t* out) {
    environment_->save(out);
    save_rest(out + environment_->state_size());
}

bool Episode::load(const uint8_t* in) {
    if (!environment_->load(in)) return false;
    load_rest(in + environment_->state_size());
    return true;
}

void Episode::snapshot(EpisodeSnapshot& snapshot) const {
    snapshot.environment = environment_->snapshot();
    snapshot.rest.resize(rest_size());
    save_rest(snapshot.rest.data());
}

void Episode::restore(const EpisodeSnapshot& snapshot) {
    // The observation releases the framebuffers that it holds; the environment then overwrites them without a copy.
    load_rest(snapshot.rest.data());
    environment_->restore(snapshot.environment);
}

void Episode::save_rest(uint8_t* out) const {
    out = observation_->save(out);
    std::memcpy(out, &game_, sizeof game_);
    save_own(out + sizeof game_);
}

void Episode::load_rest(const uint8_t* in) {
    in = observation_->load(in);
    std::memcpy(&game_, in, sizeof game_);
    load_own(in + sizeof game_);
}

}  // namespace atari
