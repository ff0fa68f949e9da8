#include "episode.hpp"

#include <cstring>

namespace atari {

Outcome Episode::step(int action, float strength) {
    const int64_t before = game_.score;
    ++game_.steps;
    Outcome outcome = play_step(action, strength);
    if (outcome.truncated && !ended_game_) end_game();  // by a limit that the emulator does not have
    outcome.game_over = environment_->game_over();
    outcome.game_reward = static_cast<int>(game_.score - before);
    outcome.game_steps = game_.steps;
    return outcome;
}

void Episode::begin_game() {
    environment_->reset();
    game_ = {0, 0, environment_->episode_frame_number()};
    game_began_ = std::chrono::steady_clock::now();
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
