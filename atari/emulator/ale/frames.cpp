// The frames of an environment: actions are held, writes to RAM applied and the rules evaluated.
#include <algorithm>

#include "environment_parts.hpp"
#include "ale/programs/evaluate.hpp"

namespace atari {

// Runs frames with an action of player 1 held. ALE reads all of RAM after the last of them.
void Environment::Parts::hold(int action, int frames) {
    for (int i = 0; i < frames; ++i) hold_frame(action);
    leave_ram_on_bus();
}

void Environment::Parts::hold_frame(int action) {
    const Controllers controls = controllers();
    controls.release_all();
    if (action == kReset) controls.hold_reset();
    controls.hold(0, action, 1.0f);
    controls.connect_paddles();
    play_frame();
}

// Runs a frame with an action of each player held.
void Environment::Parts::play_actions(const int32_t* actions, int players, float strength) {
    const Controllers controls = controllers();
    controls.release_all();
    for (int player = 0; player < players; ++player) controls.hold(player, actions[player], strength);
    controls.connect_paddles();
    play_frame();
    leave_ram_on_bus();
}

// Runs a frame and evaluates the rules.
void Environment::Parts::play_frame() {
    if (active_writes) return play_frame_with_writes();
    console->run_frame();
    evaluate_step();
}

// The rules are evaluated after the writes. If some writes are not paid, the rules are also evaluated before those
// writes, and this gives the reward. All other results are those after all writes.
void Environment::Parts::play_frame_with_writes() {
    const int32_t frame = next_frame();
    writes.begin_frame(*console, state.writes);
    console->run_frame();
    writes.apply(*console, state.writes, frame, true);
    int32_t before[kMaxVariables];
    std::copy_n(state.variables, kMaxVariables, before);
    evaluate_step();
    if (!writes.apply(*console, state.writes, frame, false)) return;
    int32_t rewards[kMaxPlayers];
    for (size_t player = 0; player < kMaxPlayers; ++player) rewards[player] = state.variables[game->rewards[player]];
    std::copy_n(before, kMaxVariables, state.variables);
    evaluate_step();
    for (size_t player = 0; player < kMaxPlayers; ++player) state.variables[game->rewards[player]] = rewards[player];
}

// Applies the writes of a reset. All rewards of a reset are discarded, also rewards of the writes.
void Environment::Parts::begin_writes() {
    state.first_frame = state.episode_frame;
    active_writes = writes.empty() ? nullptr : &writes;
    if (active_writes && writes.apply_at_reset(*console, state.writes)) discard_reward();
}

bool Environment::Parts::add_write(std::shared_ptr<const Write> write, bool now) {
    const bool paid = write->paid;
    const int slot = writes.add(std::move(write), state.writes);
    active_writes = writes.empty() ? nullptr : &writes;
    if (slot < 0) return false;
    const bool changed = now && writes.apply_now(slot, *console, state.writes, next_frame() - 1);
    if (changed && !paid) discard_reward();
    return true;
}

int Environment::Parts::remove_write(const Write* write) {
    const int slot = writes.remove(write);
    if (writes.empty()) active_writes = nullptr;
    return slot;
}

void Environment::Parts::set_writes(Writes::Slots slots) {
    writes.set(std::move(slots));
    active_writes = writes.empty() ? nullptr : &writes;
}

// Evaluates the rules after the writes, so that the next frame does not reward them.
void Environment::Parts::discard_reward() {
    evaluate_step();
    clear_rewards();
    leave_ram_on_bus();
}

void Environment::Parts::clear_rewards() {
    for (int variable : game->rewards) state.variables[variable] = 0;
}

// Returns the number of the next frame of the episode, counted from 1. The sum is unsigned, so that it wraps.
int32_t Environment::Parts::next_frame() const {
    return static_cast<int32_t>(static_cast<uint32_t>(state.episode_frame) + 1 -
                                static_cast<uint32_t>(state.first_frame));
}

// Unsigned, so that the counters wrap after 2^31 frames instead of overflowing.
void Environment::Parts::count_frame() {
    for (int32_t* counter : {&state.frame, &state.episode_frame})
        *counter = static_cast<int32_t>(static_cast<uint32_t>(*counter) + 1);
}

// The functions that a rule program calls.
struct Environment::Parts::RuleHost {
    Parts& parts;
    int32_t* variables = parts.state.variables;

    int64_t byte(int64_t address) { return parts.console->read_ram(static_cast<uint8_t>(address)); }
    int64_t xbyte(int64_t address) {
        const Console& console = *parts.console;
        return console.cartridge_ram_size() >= 128 ? console.cartridge_ram()[address & 0x7f] : 0;
    }
    uint32_t random() { return parts.state.random.next(); }
    void spend(int frames) { parts.spend(frames); }
    void press_select(int64_t frames) { parts.press_select(frames); }
    void soft_reset() {
        spend(kResetFrames);
        parts.soft_reset();
    }
    void act(int action) {
        spend(parts.settings.frame_skip);
        parts.act({action}, std::min(parts.game->players, 2), 1.0f);
    }
};

void Environment::Parts::run(const Program& program) { evaluate(program, RuleHost{*this}); }

}  // namespace atari
