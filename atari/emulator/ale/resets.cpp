// How an environment is loaded, and how its episodes begin.
#include <algorithm>
#include <cstring>
#include <stdexcept>

#include "environment_parts.hpp"

namespace atari {
namespace {

constexpr int kFormatFrames = 60;     // frames by which ALE distinguishes PAL from NTSC
constexpr int kSelectFrames = 20000;  // far more than any game needs to select a mode

}  // namespace

// Loads the ROM. The result depends on the seed only if the selection of a mode draws random words or acts. Otherwise
// the loaded state is kept, and a later load copies it. (tests/cores/test_native.py compares both)
void Environment::Parts::load(uint32_t seed) {
    const WriteState before_load = state.writes;
    const int mode = state.mode, difficulty = state.difficulty;
    if (!loaded) {
        boot(seed);
        state = EnvironmentState{};
        std::copy(game->initial.begin(), game->initial.end(), state.variables);
        state.mode = game->default_mode;
        state.random.seed(seed);
        const MersenneTwister before = state.random;
        begin_episode();
        if (std::memcmp(&before, &state.random, sizeof before) == 0) {
            loaded = std::make_shared<EnvironmentSnapshot>(snapshot());
            record_reset_trace();
            restore(*loaded);
        }
    } else {
        restore(*loaded);
        state.random.seed(seed);
    }
    state.mode = mode;
    state.difficulty = difficulty;
    state.writes = before_load;
    state.writes.seed(seed);
    begin_writes();
}

void Environment::Parts::boot(uint32_t seed) {
    console->set_config(game->console);
    console->construct(settings.one_generator ? seed : MachineRandom::kSeed);
    console->inputs().switches = game->power_on_switches;
    if (game->detect_format) {
        // Games keep what the detection frames leave in RAM. These frames therefore run by NTSC rules even if the
        // format is known.
        ConsoleConfig watching = game->console;
        watching.pal = false;
        if (watching.pal != game->console.pal && watching.height == 250) watching.height = 210;
        console->set_config(watching);
        console->reset();
        for (int i = 0; i < kFormatFrames; ++i) console->run_frame();
        console->set_config(game->console);
    }
    console->reset();
}

void Environment::Parts::begin_episode() {
    active_writes = nullptr;
    select_budget = kSelectFrames;
    state.episode_frame = 0;
    restart();
    begin_game();
    state.variables[game->terminal] = 0;
    clear_rewards();
    for (size_t i = 0; i < game->initial.size(); ++i)
        if (!game->kept[i]) state.variables[i] = game->initial[i];
    state.variables[game->mode_variable] = state.mode;
    run(game->select_mode);
    soft_reset();
    for (int action : game->starting_actions) hold(action, 1);
    if (settings.second_player_starts) start_second_player();
}

void Environment::Parts::restart() {
    const int paddles = settings.second_player_starts ? kMaxPlayers : 2;
    std::fill_n(state.paddle, paddles, (game->paddle_min + game->paddle_max) / 2);
    console->reset();
    if (settings.one_generator) console->set_timer(state.random.next());
}

// If the machine is in the state of a checkpoint of the reset trace, its further frames equal those of the trace.
// (tests/cores/test_native.py compares with the reference core, which has no trace, after resets of every game)
void Environment::Parts::begin_game() {
    int frame = 0;
    for (; reset_trace && frame < ResetTrace::kCheckpoints; ++frame) {
        hold_frame(0);
        if (resume(*reset_trace, frame)) return;
    }
    hold(0, kNoopFrames - frame);
    soft_reset();
}

void Environment::Parts::record_reset_trace() {
    if (settings.plain || console->cartridge_ram_size() > 0) return;
    const auto trace = std::make_shared<ResetTrace>();
    restart();
    for (int frame = 0; frame < ResetTrace::kFrames; ++frame) {
        hold_frame(frame < kNoopFrames ? 0 : kReset);
        if (!trace->add(*console, frame)) return;
    }
    leave_ram_on_bus();
    trace->end(*console);
    reset_trace = trace;
}

// If the machine is in the state of the checkpoint after `frame`, continues as the trace did to its end and returns
// true. Otherwise changes nothing and returns false. The rules are evaluated on the trace's RAM.
bool Environment::Parts::resume(const ResetTrace& trace, int frame) {
    if (!trace.matches(*console, frame)) return false;
    for (int next = frame + 1; next < ResetTrace::kFrames; ++next) {
        console->set_ram(trace.ram(next));
        evaluate_step();
    }
    trace.resume(*console, frame);
    return true;
}

void Environment::Parts::start_second_player() {
    hold(0, 1);
    for (int action : game->starting_actions) {
        if (action == kReset) continue;
        const int32_t actions[] = {0, action};
        play_actions(actions, 2, 1.0f);
    }
    hold(0, 1);
}

void Environment::Parts::soft_reset() {
    hold(kReset, kResetFrames);
    std::fill_n(state.held_action, kMaxPlayers, 0);
}

// Holds SELECT for `frames` frames, in which the rules are not evaluated, then releases it for one frame.
void Environment::Parts::press_select(int64_t frames) {
    const int count = static_cast<int>(std::clamp<int64_t>(frames, 0, kSelectFrames));
    spend(count + 1);
    controllers().release_all();
    controllers().hold_select();
    for (int i = 0; i < count; ++i) console->run_frame();
    hold(0, 1);
    count_frame();
}

// Takes frames from the budget of a mode selection, because a ROM may never reach the mode under the rules of another
// game. Throws std::runtime_error when the budget is used up.
void Environment::Parts::spend(int frames) {
    if (frames < 0 || frames > select_budget)
        throw std::runtime_error("the mode cannot be selected: the game never reaches it (is this ROM of this game?)");
    select_budget -= frames;
}

}  // namespace atari
