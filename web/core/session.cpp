#include "session.hpp"

#include <algorithm>
#include <cstring>

#include "ale/environment_parts.hpp"
#include "crc32.hpp"
#include "snapshot.hpp"

namespace atari::web {
namespace {

constexpr int kActionCount = 18, kMostAhead = 60;

Settings settings_of(const PageGame& game, const Options& options) {
    Settings settings = options.settings();
    settings.one_generator = settings.second_player_starts = game.players > 1;  // as Multi-Agent-ALE
    return settings;
}

bool contains(const std::vector<int32_t>& choices, int64_t value) {
    return std::find(choices.begin(), choices.end(), value) != choices.end();
}

void check(const Actions& actions) {
    for (const int action : actions)
        if (action < 0 || action >= kActionCount) throw Refused("an action is a number from 0 to 17");
}

const char* python_bool(bool value) { return value ? "True" : "False"; }

template <typename Value>
std::string list_of(int count, Value&& value) {
    std::string joined = "[";
    for (int i = 0; i < count; ++i) joined += (i ? ", " : "") + std::to_string(value(i));
    return joined + "]";
}

}  // namespace

PlaySession::PlaySession(std::shared_ptr<const PageGame> game, Options options)
    : game_(std::move(game)), options_(std::move(options)),
      environment_(game_->game, settings_of(*game_, options_), usable_seed(options_.seed, game_->players)),
      framebuffer_(static_cast<size_t>(environment_.height()) * Environment::kWidth) {
    const uint32_t* const rgb = environment_.parts().game->palette->rgb;
    for (size_t i = 0; i < rgba_.size(); ++i)
        rgba_[i] = {static_cast<uint8_t>(rgb[i] >> 16), static_cast<uint8_t>(rgb[i] >> 8), static_cast<uint8_t>(rgb[i]),
                    255};
    if (game_->players > 2) throw Refused("the page plays games of one or two players");
    if (options_.mode) environment_.set_mode(*options_.mode);
    if (options_.difficulty) environment_.set_difficulty(*options_.difficulty);
    for (const PageIntervention* const one : options_.interventions)
        for (const SharedWrite& write : one->writes) environment_.parts().add_write(write, false);
}

// ale-py replaces the seed 2^32 - 1 by the clock; `NativeCore` uses the one below.
uint32_t PlaySession::usable_seed(uint32_t seed, int players) {
    return players == 1 ? std::min(seed, UINT32_MAX - 1) : seed;
}

Writes::Slots PlaySession::slots() { return environment_.parts().writes.slots(); }

void PlaySession::seed(uint32_t seed) {
    fresh_ = false;
    end_episode();  // the seed drops the episode
    environment_.seed(usable_seed(seed, players()));
    if (recorder_) recorder_->record(EventKind::kSeed, seed);
}

void PlaySession::reset() {
    fresh_ = false;
    end_episode();
    if (recorder_) recorder_->record(EventKind::kReset);
    counters_ = {{}, true};
    environment_.reset();
}

bool PlaySession::act(const Actions& actions, float strength) {
    check(actions);
    if (!(strength >= -1000 && strength <= 1000)) throw Refused("the strength of a paddle is out of range");
    fresh_ = false;
    const int before = environment_.frame_number();
    rewards_ = environment_.act({actions[0], actions[1]}, players(), strength);
    const bool played = environment_.frame_number() != before;
    if (played)
        for (size_t player = 0; player < kMaxPlayers; ++player) counters_.score[player] += rewards_[player];
    if (recorder_) {
        const bool several = players() > 1;
        recorder_->act(several ? EventKind::kActions : EventKind::kAct,
                       static_cast<uint64_t>(actions[0] + (several ? kActionCount * actions[1] : 0)), strength, played);
        if (played) {
            recorder_->hash_frame(short_hash());
            if (recorder_->needs_full_hash()) recorder_->hash_fully(full_hash());
        }
    }
    return played;
}

void PlaySession::choose(EventKind kind, int64_t value) {
    const bool mode = kind == EventKind::kMode;
    // A replay of several players has the mode and the difficulty in its header.
    if (players() > 1) throw Refused("a game of several players keeps its mode and its difficulty; begin another game");
    if (!contains(mode ? game_->modes : game_->difficulties, value))
        throw Refused(game_->id + " has no such " + (mode ? "mode" : "difficulty"));
    fresh_ = false;
    if (mode) environment_.set_mode(static_cast<int>(value));
    else environment_.set_difficulty(static_cast<int>(value));
    if (recorder_) recorder_->record(kind, static_cast<uint64_t>(value));
}

void PlaySession::poke(int64_t index, int64_t value) {
    if (index < 0 || index > 127 || value < 0 || value > 255)
        throw Refused("a byte of RAM has an index 0..127 and a value 0..255");
    fresh_ = false;
    environment_.set_ram(static_cast<int>(index), static_cast<int>(value));
    if (recorder_) recorder_->record(EventKind::kPoke, static_cast<uint64_t>(index), static_cast<uint64_t>(value));
}

int PlaySession::add_write(const std::string& definition, bool now) {
    SharedWrite write = game_->write_of(definition);
    const Writes::Slots before = slots();
    const int slot = static_cast<int>(std::find(before.begin(), before.end(), nullptr) - before.begin());
    if (!environment_.parts().add_write(std::move(write), now)) throw Refused("a game has at most 64 writes; end one");
    fresh_ = false;
    if (recorder_) recorder_->add_write(definition, now);
    return slot;
}

void PlaySession::remove_write(uint64_t slot) {
    const Writes::Slots now = slots();
    if (slot >= now.size() || !now[slot]) throw Refused("there is no write in slot " + std::to_string(slot));
    fresh_ = false;
    environment_.parts().remove_write(now[slot].get());
    if (recorder_) recorder_->record(EventKind::kRemoveWrite, slot);
}

void PlaySession::screen_rgba(uint8_t* out) {
    environment_.screen(framebuffer_.data());
    for (size_t i = 0; i < framebuffer_.size(); ++i) std::memcpy(out + 4 * i, &rgba_[framebuffer_[i]], 4);
}

void PlaySession::screen_ahead(const Actions& actions, int frames, uint8_t* out) {
    check(actions);
    if (frames < 0 || frames > kMostAhead) throw Refused("the screen is shown 0 to 60 frames ahead");
    const EnvironmentSnapshot present = environment_.snapshot();
    for (int i = 0; i < frames; ++i) environment_.act({actions[0], actions[1]}, players());
    screen_rgba(out);
    environment_.restore(present);
}

Bytes PlaySession::state() {
    Bytes bytes(environment_.state_size());
    environment_.save(bytes.data());
    return bytes;
}

void PlaySession::load(View state) {
    if (state.size() != environment_.state_size() || !environment_.load(state.data()))
        throw Refused("the snapshot is damaged: its state is impossible");
}

Bytes PlaySession::snapshot() { return pack_snapshot(facts(), state()); }

void PlaySession::restore(View snapshot, bool any_sound) {
    load(unpack_snapshot(snapshot, facts(), any_sound));
    counters_ = {{}, true};
    fresh_ = false;
    if (recorder_) recorder_->load(snapshot);
}

void PlaySession::resume(View state, const Counters& counters, Writes::Slots slots) {
    environment_.parts().set_writes(std::move(slots));
    load(state);
    counters_ = counters;
    fresh_ = false;
}

void PlaySession::record_save() {
    if (recorder_) recorder_->record(EventKind::kSave);
}

void PlaySession::return_to(View state, const Counters& counters, uint64_t number) {
    resume(state, counters, slots());
    if (recorder_) recorder_->record(EventKind::kRestore, number);
}

void PlaySession::remember() {
    states_.push(state(), {counters_, recorder_ ? recorder_->mark() : Recorder::Mark{}, slots()});
}

bool PlaySession::go_back() {
    if (states_.size() == 0) return false;
    auto [state, place] = states_.pop();
    resume(state, place.counters, std::move(place.slots));
    if (recorder_) recorder_->go_back(place.mark);
    return true;
}

void PlaySession::start_recording(std::string_view package) {
    states_.clear();  // they have no place in the recording
    recorder_.emplace(header_of(*game_, options_, package));
    if (fresh_) {
        if (players() == 1) recorder_->record(EventKind::kSeed, options_.seed);  // the header has it for several
        return;
    }
    recorder_->load(snapshot());
    counters_ = {{}, true};
    size_t own = 0;
    for (const PageIntervention* const one : options_.interventions) own += one->writes.size();
    const Writes::Slots now = slots();
    for (size_t slot = own; slot < now.size(); ++slot)  // an ended write keeps its slot by one that is removed
        recorder_->add_write((now[slot] ? now[slot] : now.back())->definition, false);
    for (size_t slot = own; slot < now.size(); ++slot)
        if (!now[slot]) recorder_->record(EventKind::kRemoveWrite, slot);
}

Bytes PlaySession::replay() {
    if (!recorder_) throw Refused("this game is not recorded");
    return recorder_->file(episode_summary(), full_hash());
}

uint8_t PlaySession::short_hash() {
    const uint32_t ends = static_cast<uint32_t>(game_over()) << 1 | static_cast<uint32_t>(truncated());
    return crc32(ends, environment_.ram(), 128) & 3;
}

uint32_t PlaySession::full_hash() {
    const bool several = players() > 1;
    const std::string scores = several ? list_of(players(), [&](int i) { return score(i); }) : std::to_string(score());
    const std::string lives = several ? list_of(players(), [&](int i) { return environment_.lives(i); })
                                      : std::to_string(environment_.lives());
    const std::string text = scores + ' ' + lives + ' ' + python_bool(game_over()) + ' ' + python_bool(truncated());
    environment_.screen(framebuffer_.data());
    const uint32_t of_screen = crc32(crc32(0, environment_.ram(), 128), framebuffer_.data(), framebuffer_.size());
    return crc32(of_screen, view_of(text).data(), text.size());
}

std::string PlaySession::episode_summary() {
    if (!counters_.in_episode) return "";
    const std::string end = game_over() ? "game over" : truncated() ? "truncated" : "open";
    const std::string scores =
        players() > 1 ? ", \"scores\": " + list_of(players(), [&](int i) { return score(i); }) : std::string();
    return "{\"end\": \"" + end + "\", \"frames\": " + std::to_string(environment_.episode_frame_number()) +
           ", \"score\": " + std::to_string(score()) + scores + "}";
}

void PlaySession::end_episode() {
    if (recorder_ && counters_.in_episode) recorder_->end_episode(episode_summary());
    counters_.in_episode = false;
}

}  // namespace atari::web
