#include "environment.hpp"

#include <cmath>
#include <cstdlib>
#include <cstring>

#include "ale/colours/averaging.hpp"
#include "ale/colours/colour_conversion.hpp"
#include "environment_parts.hpp"

namespace atari {

static_assert(Environment::kWidth == kScreenWidth);

Environment::Environment(std::shared_ptr<const Game> game, const Settings& settings, uint32_t seed,
                         const Environment* twin)
    : parts_(new Parts{game, settings, make_console(*game, settings.plain)}) {
    if (twin) parts_->loaded = twin->parts_->loaded;
    if (twin) parts_->reset_trace = twin->parts_->reset_trace;
    parts_->state.mode = game->default_mode;
    parts_->load(seed);
}

Environment::~Environment() = default;

void Environment::seed(uint32_t seed) { parts_->load(seed); }

void Environment::reset() {
    parts_->begin_episode();
    parts_->begin_writes();
}

OfPlayers<int> Environment::act(const OfPlayers<int>& actions, int players, float strength) {
    return parts_->act(actions, players, strength);
}

int Environment::mode() const { return parts_->state.mode; }
void Environment::set_mode(int mode) { parts_->state.mode = mode; }
int Environment::difficulty() const { return parts_->state.difficulty; }
void Environment::set_difficulty(int difficulty) { parts_->state.difficulty = difficulty; }

int Environment::lives(int player) const {
    return parts_->state.variables[parts_->game->lives[static_cast<size_t>(player)]];
}
bool Environment::game_over() const { return parts_->game_over(); }
bool Environment::truncated() const { return parts_->truncated(); }
int Environment::frame_number() const { return parts_->state.frame; }
int Environment::episode_frame_number() const { return parts_->state.episode_frame; }

int Environment::height() const { return parts_->game->height(); }
void Environment::screen(uint8_t* out) {
    std::memcpy(out, parts_->framebuffer(), static_cast<size_t>(height()) * kWidth);
}
void Environment::screen_rgb(uint8_t* out) { to_rgb(parts_->framebuffer(), height(), *parts_->game->palette, out); }
void Environment::screen_gray(uint8_t* out) { to_gray(parts_->framebuffer(), height(), *parts_->game->palette, out); }
void Environment::redraw(uint8_t* out) {
    const EnvironmentSnapshot before = snapshot();
    parts_->console->run_frame();
    screen_rgb(out);
    restore(before);
}

const uint8_t* Environment::audio() const { return parts_->state.audio; }
const uint8_t* Environment::ram() const { return parts_->console->ram(); }
void Environment::set_ram(int index, int value) {
    parts_->console->poke_ram(static_cast<uint8_t>(0x80 + index), static_cast<uint8_t>(value));
}

size_t Environment::state_size() const { return sizeof(EnvironmentState) + parts_->console->state_size(); }

void Environment::save(uint8_t* out) {
    std::memcpy(out, &parts_->state, sizeof(EnvironmentState));
    parts_->console->save(out + sizeof(EnvironmentState));
}

bool Environment::load(const uint8_t* in) {
    EnvironmentState state;
    std::memcpy(&state, in, sizeof state);
    bool good = state.random.position <= 624 && std::abs(state.held_strength) <= 1000.0f;
    for (int32_t action : state.held_action) good &= action >= 0 && action <= kReset;
    for (int32_t position : state.paddle) good &= position >= 0 && position <= kMaxResistance;
    if (!good || !parts_->console->load(in + sizeof state)) return false;
    parts_->state = state;
    return true;
}

EnvironmentSnapshot Environment::snapshot() const { return parts_->snapshot(); }
bool Environment::restore(const EnvironmentSnapshot& snapshot) { return parts_->restore(snapshot); }

std::vector<uint8_t> EnvironmentSnapshot::bytes(const Game& game) const {
    const auto restored = make_console(game, plain);
    restored->restore(*console);
    std::vector<uint8_t> bytes(sizeof state + restored->state_size());
    std::memcpy(bytes.data(), &state, sizeof state);
    restored->save(bytes.data() + sizeof state);
    return bytes;
}

bool Environment::Parts::restore(const EnvironmentSnapshot& snapshot) {
    if (snapshot.plain != settings.plain) return false;
    state = snapshot.state;
    console->restore(*snapshot.console);
    return true;
}

const uint8_t* Environment::Parts::framebuffer() {
    if (!settings.color_averaging) return console->framebuffer();
    averaged.resize(static_cast<size_t>(game->height()) * kScreenWidth);
    average_framebuffers(console->framebuffer(), console->previous_framebuffer(), averaged.size(), *game->palette,
                         averaged.data());
    return averaged.data();
}

}  // namespace atari
