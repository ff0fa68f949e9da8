// The layers of an episode: the wrappers of `atari.wrappers` in C++, to the byte. The comment above each function names
// the wrapper's method that it implements.
#include "episode.hpp"

namespace atari {

std::vector<Episode::Layer> Episode::layers_of(const EpisodeSettings& settings) {
    const bool lives = settings.episodic_life, skips_of_lives = settings.lives_unit == Unit::kSkip;
    const bool fire_last = settings.fire == FirePress::kAfterNoops, skips_of_fire = settings.fire_unit == Unit::kSkip;
    std::vector<Layer> layers{Layer::kGame};
    const auto add = [&](Layer layer, bool wanted) {
        if (wanted) layers.push_back(layer);
    };
    add(Layer::kLives, lives && !skips_of_lives);
    add(Layer::kFire, settings.fire == FirePress::kBeforeNoops);
    add(Layer::kNoops, true);
    add(Layer::kFire, fire_last && !skips_of_fire);
    add(Layer::kPlayers, settings.players > 1);
    add(Layer::kActionDelay, settings.action_delay.second > 0);
    add(Layer::kObservationDelay, settings.observation_delay.second > 0);
    add(Layer::kSkip, true);
    add(Layer::kLives, lives && skips_of_lives);
    add(Layer::kFire, fire_last && skips_of_fire);
    return layers;
}

void Episode::reset(const Seed* seed, bool new_game, std::optional<int> noops, bool press_fire) {
    const int before = delays_frames() ? game_.frame_number() : 0;
    {
        if (delays_frames()) observation_->source().read_own();
        resets_ = true;
        begun_ = false;
        const struct End {
            bool& resets;
            ~End() { resets = false; }
        } end{resets_};
        reset_layer(layers_.size() - 1, {seed, new_game, noops, press_fire});
    }
    // The stack is a `FrameStack` outside of all layers if one of them is outside of the skip; a reset fills it anew.
    if (layers_.back() != Layer::kSkip) observation_->repeat(true);
    if (!goes_on()) {
        begin_action_line();
        begin_frame_line(state_.same_game && !begun_ && game_.frame_number() == before);
    }
    state_.steps = 0;
    if (formula_) formula_->begin(inputs_.data(), game_.ram(), game_.lives());
}

void Episode::reset_layer(size_t level, const Request& request) {
    switch (layers_[level]) {
        case Layer::kGame: return reset_game(request);
        case Layer::kLives: return reset_lives(level, request);
        case Layer::kNoops: return reset_noops(level, request);
        case Layer::kFire: return reset_fire(level, request);
        case Layer::kPlayers: return reset_players(level, request);
        case Layer::kActionDelay:
        case Layer::kObservationDelay: return reset_layer(level - 1, request);
        case Layer::kSkip: return reset_skip(level, request);
    }
}

Episode::Ends Episode::step_layer(size_t level, const Move& move) {
    switch (layers_[level]) {
        case Layer::kGame: return step_game(move);
        case Layer::kLives: return step_lives(level, move);
        case Layer::kPlayers: return step_players(level, move);
        case Layer::kActionDelay: return step_action_delay(level, move);
        case Layer::kObservationDelay: return step_observation_delay(level, move);
        case Layer::kSkip: return step_skip(level, move);
        case Layer::kNoops:
        case Layer::kFire: break;  // These act in resets alone.
    }
    return step_layer(level - 1, move);
}

// AtariEnv.reset
void Episode::reset_game(const Request& request) {
    if (request.seed) random_.seed(*request.seed);
    game_.begin(request.seed ? &request.seed->emulator : nullptr);
    begun_ = true;
    score_ = {};
    state_.game_steps = 0;
    state_.first_frame = game_.episode_frame_number();
    game_began_ = std::chrono::steady_clock::now();
}

// AtariEnv.step, of one frame
Episode::Ends Episode::step_game(const Move& move) {
    const OfPlayers<int> rewards = game_.act(move.actions, settings_.players, move.strength);
    for (size_t player = 0; player < kMaxPlayers; ++player) score_[player] += rewards[player];
    const Ends ends{game_.game_over(), game_.truncated()};
    if (ends.any()) end_game();
    return ends;
}

// Returns whether fewer lives are left than before.
bool Episode::has_lost_life(int lives_before) const {
    const int lives = game_.lives();
    return lives < lives_before && (lives > 0 || settings_.last_life);
}

// EpisodicLife.reset
void Episode::reset_lives(size_t level, const Request& request) {
    const bool new_game = request.seed || settings_.on_reset == OnReset::kNewGame || request.new_game;
    state_.same_game = state_.life_lost && !new_game;
    if (!state_.same_game || settings_.on_reset != OnReset::kContinue) {
        if (state_.same_game) state_.same_game = !step_layer(level - 1, Move{}).any();
        if (!state_.same_game) reset_layer(level - 1, request);
        state_.lives = game_.lives();
    }
    state_.life_lost = false;  // after a game has begun: if it cannot, the next reset still goes on
}

// EpisodicLife.step
Episode::Ends Episode::step_lives(size_t level, const Move& move) {
    Ends ends = step_layer(level - 1, move);
    const bool lost = has_lost_life(state_.lives);
    state_.lives = game_.lives();
    state_.life_lost = (state_.life_lost || lost) && !ends.any();
    ends.terminated |= lost;
    return ends;
}

// NoopReset.reset
void Episode::reset_noops(size_t level, Request request) {
    reset_layer(level - 1, request);
    int left =
        request.noops ? *request.noops : random_.noops(settings_.noops) - (settings_.fire_counts && start_.has_fire);
    request.press_fire &= settings_.fire_again;
    for (; left > 0; --left) {
        // NOOP is no action of some games; NoopReset then plays it past EpisodicLife.
        const Ends ends = start_.has_noop ? step_layer(level - 1, Move{}) : step_game(Move{});
        if (ends.any()) reset_layer(level - 1, request);
    }
}

// FireReset.reset
void Episode::reset_fire(size_t level, const Request& request) {
    reset_layer(level - 1, request);
    if (!start_.has_fire || !request.press_fire) return;
    if (step_layer(level - 1, Move{{1}}).any()) reset_layer(level - 1, request);
    if (settings_.third_action && step_layer(level - 1, Move{{start_.third}}).any()) reset_layer(level - 1, request);
}

void Episode::reset_players(size_t level, const Request& request) {
    reset_layer(level - 1, request);
    state_.out = 0;
}

// Players whose lives are negative are out, as in PettingZoo; the episode ends when all are.
Episode::Ends Episode::step_players(size_t level, const Move& move) {
    Ends ends = step_layer(level - 1, move);
    for (int player = 0; player < settings_.players; ++player)
        state_.out |= static_cast<uint8_t>((game_.lives(player) < 0) << player);
    ends.terminated |= state_.out == (1 << settings_.players) - 1;
    return ends;
}

// ActionDelay.reset
void Episode::begin_action_line() {
    if (moves_.empty()) return;
    const auto [low, high] = settings_.action_delay;
    action_line_ = {static_cast<uint32_t>(random_.frames({low, high + 1})), 0};
    std::fill(moves_.begin(), moves_.end(), settings_.players > 1 ? Move{start_.idle} : Move{});
}

// ActionDelay.step, of one frame
Episode::Ends Episode::step_action_delay(size_t level, const Move& move) {
    if (resets_ || !action_line_.length) return step_layer(level - 1, move);
    Move& oldest = moves_[action_line_.oldest];
    action_line_.oldest = (action_line_.oldest + 1) % action_line_.length;
    return step_layer(level - 1, std::exchange(oldest, move));
}

// Copies the present frame, or what else the stack reads, and the RAM.
void Episode::read_frame(uint8_t* to) {
    FrameSource& source = observation_->source();
    source.read_own();
    game_.show(*observation_);
    if (frame_size_) std::copy_n(observation_->planes() ? source.current().pixels : source.ram(), frame_size_, to);
    std::copy_n(game_.ram(), kRamSize, to + frame_size_);
}

// ObservationDelay.reset. With `held` no frame was played, so the frame that the agent saw last is the first one.
void Episode::begin_frame_line(bool held) {
    if (!delays_frames()) return;
    const auto [low, high] = settings_.observation_delay;
    const auto delay = static_cast<uint32_t>(random_.frames({low, high + 1}));
    if (!held) read_frame(frame(0));
    else if (frame_line_.oldest) std::copy_n(oldest_frame(), frame_size_ + kRamSize, frame(0));
    frame_line_ = {delay + 1, 0};
    for (uint32_t entry = 1; entry <= static_cast<uint32_t>(high); ++entry)
        std::copy_n(frame(0), frame_size_ + kRamSize, frame(entry));
}

// ObservationDelay.step, of one frame
Episode::Ends Episode::step_observation_delay(size_t level, const Move& move) {
    const int before = game_.frame_number();
    const Ends ends = step_layer(level - 1, move);
    if (resets_ || game_.frame_number() == before) return ends;
    read_frame(frame(frame_line_.oldest));
    frame_line_.oldest = (frame_line_.oldest + 1) % frame_line_.length;
    return ends;
}

// Called before the stack reads a frame: the present one, or in a step the delayed one. A reset that goes on with the
// same stack shows the delayed one, too.
void Episode::show() {
    const bool delayed = delays_frames() && (!resets_ || goes_on());
    if (delayed) observation_->source().read(oldest_frame());
    else game_.show(*observation_);
}

bool Episode::has_played_max_frames() const {
    return settings_.max_frames && state_.frames_played >= static_cast<uint32_t>(*settings_.max_frames);
}

// DqnPreprocessing.reset
void Episode::reset_skip(size_t level, Request request) {
    request.new_game |= has_played_max_frames();
    reset_layer(level - 1, request);
    if (!state_.same_game) state_.frames_played = 0;
    const bool fill = !state_.same_game || !settings_.seamless_lives;
    if (state_.same_game && game_.frame_number() == state_.frame_number) return observation_->repeat(fill);
    show();
    observation_->begin(fill);
}

// DqnPreprocessing.step
Episode::Ends Episode::step_skip(size_t level, const Move& move) {
    Ends ends{};
    int left = random_.frames(settings_.frameskip);
    while (left > 0 && !ends.any()) {
        --left;
        ends = step_layer(level - 1, move);
        if (settings_.seamless_lives && state_.life_lost) ends.terminated = false;  // reported after the skip
        ++state_.frames_played;
        ends.truncated |= has_played_max_frames() && !ends.terminated;
        if (left == 1) show();
        observation_->frame_played(left, ends.any());
    }
    show();
    observation_->skip_ended(left, ends.any());
    for (; settings_.acts_after_end && left > 0; --left) game_.act(move.actions, 1, move.strength);
    if (settings_.seamless_lives && state_.life_lost) ends.terminated = !ends.truncated;
    state_.frame_number = game_.frame_number();
    return ends;
}

}  // namespace atari
