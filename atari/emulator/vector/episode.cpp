#include "episode.hpp"

namespace atari {

void Episode::save(uint8_t* out) {
    environment_->save(out);
    save_own(observation_->save(out + environment_->state_size()));
}

bool Episode::load(const uint8_t* in) {
    if (!environment_->load(in)) return false;
    load_own(observation_->load(in + environment_->state_size()));
    return true;
}

void Episode::snapshot(EpisodeSnapshot& snapshot) const {
    snapshot.environment = environment_->snapshot();
    snapshot.rest.resize(observation_->state_size() + own_state_size());
    save_own(observation_->save(snapshot.rest.data()));
}

void Episode::restore(const EpisodeSnapshot& snapshot) {
    // The observation releases the framebuffers that it holds; the environment then overwrites them without a copy.
    load_own(observation_->load(snapshot.rest.data()));
    environment_->restore(snapshot.environment);
}

}  // namespace atari
