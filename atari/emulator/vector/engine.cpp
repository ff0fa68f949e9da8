#include "engine.hpp"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <utility>

#if defined(_WIN32)
#include <process.h>
#else
#include <unistd.h>
#endif

namespace atari {
namespace {

// Begins to load the memory of an observation into the cache. The user's memory may be outside of it.
void prefetch([[maybe_unused]] const uint8_t* to, [[maybe_unused]] size_t size) {
#if defined(__GNUC__)
    constexpr size_t kMost = size_t{1} << 15, kLine = 64;
    for (size_t i = 0; i < std::min(size, kMost); i += kLine) __builtin_prefetch(to + i, 1, 2);
#endif
}

long process_number() {
#if defined(_WIN32)
    return _getpid();
#else
    return getpid();
#endif
}

}  // namespace

VectorEngine::VectorEngine(std::vector<std::unique_ptr<Lane>> lanes, const VectorSettings& settings)
    : settings_(settings), players_(lanes[0]->episode().players()), process_(process_number()) {
    slots_.resize(lanes.size());
    recent_.resize(static_cast<size_t>(settings.batch_size));
    result_rams_.resize(128 * lanes.size());
    std::iota(recent_.begin(), recent_.end(), 0);
    for (size_t i = 0; i < lanes.size(); ++i) slots_[i].lane = std::move(lanes[i]);
    pool_ = std::make_unique<ThreadPool>(size(), settings.threads, queued(), settings.first_core,
                                         [this](int environment) { run_task(environment); });
}

// A forked child process has none of the threads, and cannot join them.
VectorEngine::~VectorEngine() {
    if (process_ != process_number()) static_cast<void>(pool_.release());
}

void VectorEngine::reset(const std::vector<bool>& chosen, const std::vector<const Seed*>& seeds, const Batch* batch,
                         bool new_games) {
    for (size_t i = 0; i < slots_.size(); ++i) {
        Slot& slot = slots_[i];
        slot.task = chosen[i] ? Task::kReset : Task::kObserve;
        slot.new_game = new_games;
        if (seeds[i]) slot.seed_value = *seeds[i];
        slot.seed = seeds[i] ? &slot.seed_value : nullptr;
    }
    batch_ = batch;
    sequence_ = nullptr;
    if (!queued()) return pool_->submit_all();
    std::vector<int> all(slots_.size());
    std::iota(all.begin(), all.end(), 0);
    pool_->submit(all.data(), size());
}

void VectorEngine::step(const std::vector<int>& environments, const int64_t* actions, const float* strengths,
                        const Batch* batch) {
    if (!queued() && environments.size() < slots_.size())
        for (Slot& slot : slots_) slot.task = Task::kObserve;
    for (size_t i = 0; i < environments.size(); ++i) {
        Slot& slot = this->slot(environments[i]);
        slot.task = Task::kStep;
        for (int player = 0; player < players_; ++player)
            slot.actions[player] = slot.lane->actions()[static_cast<size_t>(*actions++)];
        slot.strength = strengths ? strengths[i] : 1.0f;
    }
    batch_ = batch;
    sequence_ = nullptr;
    if (queued()) pool_->submit(environments.data(), static_cast<int>(environments.size()));
    else pool_->submit_all();
}

void VectorEngine::play(const std::vector<int>& environments, const int64_t* actions, const float* strengths,
                        const Batch* batch, std::shared_ptr<Sequence> sequence) {
    const size_t lanes = slots_.size(), players = static_cast<size_t>(players_);
    // With rows for each step, the batch has none for an environment that does not play.
    for (Slot& slot : slots_) slot.task = sequence->every ? Task::kNothing : Task::kObserve;
    sequence->actions.reserve(environments.size() * sequence->steps * players);
    for (size_t i = 0; i < environments.size(); ++i) {
        Slot& slot = this->slot(environments[i]);
        slot.task = Task::kPlay;
        slot.played_row = i;
        for (size_t k = 0; k < sequence->steps * players; ++k)
            sequence->actions.push_back(slot.lane->actions()[static_cast<size_t>(*actions++)]);
    }
    sequence->strengths.assign(strengths, strengths + environments.size() * sequence->steps);
    sequence->rewards.resize(lanes * players);
    sequence->played.resize(lanes);
    sequence->rams.resize(lanes * sequence->rows() * 128);
    batch_ = batch;
    sequence_ = std::move(sequence);
    pool_->submit_all();
}

bool VectorEngine::receive(const Batch& batch) {
    pool_->wait(settings_.batch_size);
    if (queued()) {
        recent_ = pool_->take(settings_.batch_size);
        for (int row = 0; row < settings_.batch_size; ++row) {
            const int environment = recent_[static_cast<size_t>(row)];
            apply_restore(slot(environment));
            write_results(slot(environment), environment, row, batch);
        }
    }
    bool any = false;
    const int rows = settings_.batch_size * (sequence_ ? static_cast<int>(sequence_->rows()) : 1);
    for (int at = 0; at < rows * players_; ++at) any |= batch.terminated[at] || batch.truncated[at];
    for (int row = 0; row < rows; ++row) any |= batch.game_ended[row];
    return any;
}

void VectorEngine::drain() {
    const int left = pool_->pending();
    try {
        pool_->wait(left);
        if (queued()) pool_->take(left);
    } catch (...) {  // the deferred error of a batch whose results are dropped
    }
}

void VectorEngine::apply_restore(Slot& slot, bool own_generators) {
    if (!slot.pending_restore) return;
    const LaneState& state = slot.pending_restore->state;
    if (own_generators) slot.lane->restore_with_own_generators(state);
    else slot.lane->restore(state);
    slot.outcome = slot.pending_restore->outcome;
    slot.outcome.reward = {};  // the reward of the step before the snapshot
    slot.outcome.own_reward = 0.0;
    slot.has_final = false;
    slot.pending_restore = nullptr;
}

void VectorEngine::run_task(int environment) {
    apply_restore(slot(environment));
    if (slot(environment).task == Task::kPlay) return play_sequence(slot(environment), environment);
    if (slot(environment).task == Task::kNothing) return;
    if (!queued() && batch_->pixels) {
        const size_t size = lane(environment).episode().observation().size();
        prefetch(batch_->pixels + size * static_cast<size_t>(environment), size);
    }
    play(slot(environment), environment);
    if (!queued()) write_results(slot(environment), environment, environment, *batch_);
}

// Plays the slot's task, and writes a final observation to this row.
void VectorEngine::play(Slot& slot, int row) {
    Episode& episode = slot.lane->episode();
    slot.has_final = false;
    const bool over = slot.outcome.ended;
    const bool idle = over && settings_.autoreset == Autoreset::kDisabled;  // until it is reset
    if (slot.task == Task::kObserve || (slot.task != Task::kReset && idle)) {
        slot.outcome.reward = slot.outcome.game_reward = {};
        slot.outcome.own_reward = 0.0;
    } else if (slot.task == Task::kReset || over) {
        const bool asked = slot.task == Task::kReset;
        episode.reset(asked ? slot.seed : nullptr, asked && slot.new_game);
        slot.outcome = Outcome{};
        slot.outcome.game_steps = episode.game_steps();
        slot.outcome.game_over = slot.lane->environment().game_over();  // A mode may begin with the end of a game.
    } else {
        slot.outcome = episode.step(slot.actions, slot.strength);
        if (slot.outcome.ended && settings_.autoreset == Autoreset::kSameStep) {
            keep_final(slot, row);
            episode.reset(nullptr, false);
            slot.outcome.ended = false;
        }
    }
    slot.ended_game = episode.take_ended_game();
}

void VectorEngine::play_sequence(Slot& slot, int environment) {
    Sequence& sequence = *sequence_;
    Episode& episode = slot.lane->episode();
    // Images that no result has are not drawn. If the lane stops before its observation is whole, it plays again, from
    // its beginning to the same end.
    size_t undrawn = sequence.every || slot.lane->game().records() ? 0 : episode.undrawn(sequence.steps);
    LaneState beginning;
    const Outcome outcome = slot.outcome;
    if (undrawn) slot.lane->snapshot(beginning);
    for (;;) {
        const size_t played = play_steps(slot, environment, undrawn);
        if (episode.observation().is_whole() && (!slot.has_final || slot.final_is_whole)) break;
        undrawn = episode.undrawn(std::min(played, undrawn));
        slot.lane->restore(beginning);
        slot.outcome = outcome;
    }
    if (sequence.every) return;
    write_results(slot, environment, environment, *batch_);
    std::copy_n(slot.lane->environment().ram(), 128, sequence.rams.data() + 128 * static_cast<size_t>(environment));
}

// Plays the steps of a sequence, the first `undrawn` of them without images. Returns the number of steps played.
size_t VectorEngine::play_steps(Slot& slot, int environment, size_t undrawn) {
    Sequence& sequence = *sequence_;
    Episode& episode = slot.lane->episode();
    const auto players = static_cast<size_t>(players_), lane = static_cast<size_t>(environment);
    double* const rewards = sequence.rewards.data() + lane * players;
    std::fill_n(rewards, players, 0.0);
    const struct Drawing {
        Episode& episode;
        ~Drawing() { episode.set_draws(true); }
    } drawing{episode};
    double weight = 1.0;
    size_t step = 0;
    for (bool goes_on = true; goes_on && step < sequence.steps; weight *= sequence.discount) {
        const bool idle = slot.outcome.ended && settings_.autoreset == Autoreset::kDisabled;
        const size_t from = slot.played_row * sequence.steps + step, row = lane * sequence.rows() + step;
        std::copy_n(sequence.actions.data() + from * players, players, slot.actions);
        slot.strength = sequence.strengths[from];
        episode.set_draws(step >= undrawn);
        play(slot, static_cast<int>(sequence.every ? row : lane));
        if (idle && sequence.stops) break;
        goes_on = !sequence.stops || !(slot.outcome.ended || slot.has_final);
        for (size_t player = 0; player < players; ++player)
            rewards[player] +=
                weight * (episode.has_own_reward() ? slot.outcome.own_reward : slot.outcome.reward[player]);
        if (sequence.every) {
            write_results(slot, environment, static_cast<int>(row), *batch_);
            std::copy_n(slot.lane->environment().ram(), 128, sequence.rams.data() + 128 * row);
        }
        ++step;
    }
    sequence.played[lane] = static_cast<int32_t>(step);
    return step;
}

void VectorEngine::keep_final(Slot& slot, int row) {
    slot.has_final = true;
    Episode& episode = slot.lane->episode();
    slot.final_game = episode.take_ended_game();
    Environment& e = slot.lane->environment();
    if (queued()) {
        slot.final_pixels.resize(episode.observation().size());
        episode.observation().write(slot.final_pixels.data());
    } else if (batch_->final_pixels) {
        const size_t at = episode.observation().size() * static_cast<size_t>(row);
        episode.observation().write(batch_->final_pixels + at);
        batch_->ended[row] = true;  // so that the row is cleared if a later step of a sequence has no final observation
        slot.final_is_whole = episode.observation().is_whole();
    }
    std::copy_n(e.ram(), 128, slot.final_ram);
    std::copy_n(episode.ram(), 128, slot.final_shown_ram);
    for (int player = 0; player < players_; ++player) slot.final_lives[player] = e.lives(player);
    slot.final_numbers[0] = e.frame_number();
    slot.final_numbers[1] = e.episode_frame_number();
}

void VectorEngine::write_results(Slot& slot, int environment, int row, const Batch& batch) {
    Episode& episode = slot.lane->episode();
    Environment& e = slot.lane->environment();
    const auto at = static_cast<size_t>(row);
    const Outcome& outcome = slot.outcome;
    if (batch.pixels) episode.observation().write(batch.pixels + episode.observation().size() * at);
    std::copy_n(e.ram(), 128, result_rams_.data() + 128 * static_cast<size_t>(environment));
    if (batch.ram) std::copy_n(episode.ram(), 128, batch.ram + 128 * at);
    batch.env_id[at] = environment;
    batch.elapsed_step[at] = outcome.game_steps;
    batch.game_over[at] = outcome.game_over;
    write_players(slot, row, batch);
    if (episode.has_own_reward()) {
        batch.own_reward[at] = outcome.own_reward;
        batch.own_reward_float[at] = static_cast<float>(outcome.own_reward);
    }
    batch.frame_number[at] = e.frame_number();
    batch.episode_frame_number[at] = e.episode_frame_number();
    write_game(slot.ended_game, row, {batch.game_ended, batch.score, batch.frames, batch.seconds});
    if (settings_.autoreset == Autoreset::kSameStep) write_final(slot, row, batch);
}

void VectorEngine::write_players(Slot& slot, int row, const Batch& batch) {
    const Outcome& outcome = slot.outcome;
    for (int player = 0; player < players_; ++player) {
        const auto from = static_cast<size_t>(player), at = static_cast<size_t>(row * players_ + player);
        const bool out = outcome.out >> player & 1;
        batch.reward[at] = outcome.reward[from];
        batch.game_reward[at] = outcome.game_reward[from];
        batch.terminated[at] = outcome.terminated || out;
        batch.truncated[at] = outcome.truncated && !out;
        batch.lives[at] = slot.lane->environment().lives(player);
    }
}

void VectorEngine::write_game(const std::optional<EndedGame>& ended, int row, const GameArrays& arrays) const {
    const auto at = static_cast<size_t>(row);
    const EndedGame game = ended.value_or(EndedGame{{}, 0, 0.0});
    arrays.ended[at] = ended.has_value();
    for (int player = 0; player < players_; ++player)
        arrays.score[row * players_ + player] = static_cast<double>(game.score[static_cast<size_t>(player)]);
    arrays.frames[at] = game.frames;
    arrays.seconds[at] = game.seconds;
}

// A row of the final observations is zero if no episode of its environment ended in this step.
void VectorEngine::write_final(Slot& slot, int row, const Batch& batch) {
    const auto at = static_cast<size_t>(row);
    const size_t size = slot.lane->episode().observation().size();
    uint8_t* const pixels = batch.final_pixels ? batch.final_pixels + size * at : nullptr;
    uint8_t* const ram = batch.final_ram ? batch.final_ram + 128 * at : nullptr;
    if (slot.has_final) {
        if (pixels && queued()) std::copy(slot.final_pixels.begin(), slot.final_pixels.end(), pixels);
        if (ram) std::copy_n(slot.final_shown_ram, 128, ram);
    } else if (batch.ended[at]) {  // a final observation of an earlier step
        if (pixels) std::memset(pixels, 0, size);
        if (ram) std::memset(ram, 0, 128);
    }
    batch.ended[at] = slot.has_final;
    const auto number = [&](int i) { return slot.has_final ? slot.final_numbers[i] : 0; };
    for (int player = 0; player < players_; ++player)
        batch.final_lives[row * players_ + player] = slot.has_final ? slot.final_lives[player] : 0;
    batch.final_frame_number[at] = number(0);
    batch.final_episode_frame_number[at] = number(1);
    write_game(slot.has_final ? slot.final_game : std::nullopt, row,
               {batch.final_game_ended, batch.final_score, batch.final_frames, batch.final_seconds});
}

void VectorEngine::save(int environment, uint8_t* out) {
    Lane& restored = lane(environment);
    *out = slot(environment).outcome.saved();
    restored.save(out + 1);
}

bool VectorEngine::load(int environment, const uint8_t* in) {
    if (!lane(environment).load(in + 1)) return false;
    Outcome& outcome = slot(environment).outcome;
    outcome = Outcome::of_saved(*in, players_);
    outcome.game_steps = lane(environment).episode().game_steps();
    return true;
}

std::vector<uint8_t> VectorEngine::LaneSnapshot::bytes() const {
    const std::vector<uint8_t> environment = state.environment.bytes(*game);
    std::vector<uint8_t> bytes(1 + environment.size() + state.episode.size());
    bytes[0] = outcome.saved();
    uint8_t* const end = std::copy(environment.begin(), environment.end(), bytes.data() + 1);
    std::copy(state.episode.begin(), state.episode.end(), end);
    return bytes;
}

VectorEngine::Snapshot VectorEngine::snapshot(int environment) {
    const Slot& source = slot(environment);
    if (source.pending_restore) return source.pending_restore;
    auto snapshot = std::make_shared<LaneSnapshot>();
    snapshot->game = source.lane->environment().parts().game;
    source.lane->snapshot(snapshot->state);
    snapshot->outcome = source.outcome;
    return snapshot;
}

VectorEngine::Snapshot VectorEngine::parse(int environment, const uint8_t* in) {
    Snapshot now = snapshot(environment);
    if (!load(environment, in)) return nullptr;
    Snapshot parsed = snapshot(environment);
    restore(environment, std::move(now));
    return parsed;
}

void VectorEngine::restore(int environment, Snapshot snapshot, bool own_generators) {
    Slot& to = slot(environment);
    if (own_generators) apply_restore(to);  // a restore that waits decides the generators
    to.pending_restore = std::move(snapshot);
    if (own_generators) apply_restore(to, true);
}

bool VectorEngine::fits(int environment, const LaneSnapshot& snapshot) const {
    const Environment& e = slot(environment).lane->environment();
    return snapshot.game == e.parts().game &&
           snapshot.state.episode.size() + 1 + e.state_size() == state_size(environment);
}

}  // namespace atari
