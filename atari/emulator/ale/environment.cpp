#include "environment.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "averaging.hpp"
#include "colour_conversion.hpp"
#include "evaluate.hpp"

namespace atari {
namespace {

constexpr int kReset = 40;
constexpr int kFormatFrames = 60;     // frames by which ALE distinguishes PAL from NTSC
constexpr int kSelectFrames = 20000;  // far more than any game needs to select a mode

struct Motion {
    uint8_t stick;  // bits 0-3: up, down, left, right
    bool fire;
};

// The 18 actions in ALE's order.
constexpr Motion kMotions[18] = {
    {0, false}, {0, true}, {1, false}, {8, false}, {4, false}, {2, false}, {9, false}, {5, false}, {10, false},
    {6, false}, {1, true}, {8, true},  {4, true},  {2, true},  {9, true},  {5, true},  {10, true}, {6, true},
};

Motion motion(int action) { return action >= 0 && action < 18 ? kMotions[action] : Motion{0, false}; }

}  // namespace

void Game::check() const {
    if (players < 1 || players > kMaxPlayers) throw std::invalid_argument("a game has 1 to 4 players");
    for (const auto* outputs : {&rewards, &lives})
        for (int variable : *outputs)
            if (variable < 0 || variable >= variables) throw std::invalid_argument("a game's variable does not exist");
    for (int variable : {terminal, mode_variable})
        if (variable < 0 || variable >= variables) throw std::invalid_argument("a game's variable does not exist");
    if (initial.size() > static_cast<size_t>(variables) || kept.size() != initial.size())
        throw std::invalid_argument("a game's start values do not fit its variables");
    if (console.first_line < 0 || console.height < 1 || console.height > kFrameRows ||
        console.first_line > kFrameRows - console.height)
        throw std::invalid_argument("the framebuffer must lie within 300 lines");
    if (paddle_min < 0 || paddle_max > 1 << 24 || paddle_min > paddle_max)
        throw std::invalid_argument("the range of paddles must lie within 0..16777216");
    for (int action : starting_actions)
        if ((action < 0 || action > 17) && action != kReset)
            throw std::invalid_argument("a starting action does not exist");
}

std::unique_ptr<Console> make_console(const Game& game, bool plain) {
    if (plain) return std::make_unique<Console>(game.cartridge, game.console);
    return std::make_unique<FastConsole>(game.cartridge, game.console);
}

Environment::Environment(std::shared_ptr<const Game> game, const Settings& settings, uint32_t seed_value,
                         const Environment* twin)
    : game_(std::move(game)), settings_(settings), console_(make_console(*game_, settings.plain)),
      mode_(game_->default_mode), loaded_(twin ? twin->loaded_ : nullptr),
      reset_trace_(twin ? twin->reset_trace_ : nullptr) {
    seed(seed_value);
}

// Loads the ROM. The result depends on the seed only if the selection of a mode draws random words or acts. Otherwise
// the loaded state is kept, and a later load copies it. (tests/cores/test_native.py compares both)
void Environment::seed(uint32_t value) {
    const WriteState before_load = state_.writes;
    if (!loaded_) {
        boot(value);
        state_ = EnvironmentState{};
        std::copy(game_->initial.begin(), game_->initial.end(), state_.variables);
        state_.mode = game_->default_mode;
        state_.random.seed(value);
        const MersenneTwister before = state_.random;
        begin_episode();
        if (std::memcmp(&before, &state_.random, sizeof before) == 0) {
            loaded_ = std::make_shared<EnvironmentSnapshot>(snapshot());
            record_reset_trace();
            restore(*loaded_);
        }
    } else {
        restore(*loaded_);
        state_.random.seed(value);
    }
    state_.mode = mode_;
    state_.difficulty = difficulty_;
    state_.writes = before_load;
    state_.writes.seed(value);
    begin_writes();
}

void Environment::boot(uint32_t seed) {
    console_->set_config(game_->console);
    console_->construct(settings_.one_generator ? seed : MachineRandom::kSeed);
    console_->inputs().switches = game_->power_on_switches;
    if (game_->detect_format) {
        // Games keep what the detection frames leave in RAM. These frames therefore run by NTSC rules even if the
        // format is known.
        ConsoleConfig watching = game_->console;
        watching.pal = false;
        if (watching.pal != game_->console.pal && watching.height == 250) watching.height = 210;
        console_->set_config(watching);
        console_->reset();
        for (int i = 0; i < kFormatFrames; ++i) console_->run_frame();
        console_->set_config(game_->console);
    }
    console_->reset();
}

void Environment::reset() {
    begin_episode();
    begin_writes();
}

void Environment::begin_episode() {
    active_writes_ = nullptr;
    select_budget_ = kSelectFrames;
    state_.episode_frame = 0;
    restart();
    begin_game();
    state_.variables[game_->terminal] = 0;
    clear_rewards();
    for (size_t i = 0; i < game_->initial.size(); ++i)
        if (!game_->kept[i]) state_.variables[i] = game_->initial[i];
    state_.variables[game_->mode_variable] = state_.mode;
    run(game_->select_mode);
    soft_reset();
    for (int action : game_->starting_actions) emulate(action, 1.0f, 1);
    if (settings_.second_player_starts) start_second_player();
}

// Applies the writes of a reset; rewards of a reset are discarded, also theirs.
void Environment::begin_writes() {
    state_.first_frame = state_.episode_frame;
    active_writes_ = writes_.empty() ? nullptr : &writes_;
    if (active_writes_ && writes_.apply_at_reset(*console_, state_.writes)) discard_reward();
}

// Evaluates the rules on what was written, so that the next frame does not reward it.
void Environment::discard_reward() {
    evaluate_step();
    clear_rewards();
    leave_ram_on_bus();
}

void Environment::clear_rewards() {
    for (int variable : game_->rewards) state_.variables[variable] = 0;
}

// The number of the next frame of the episode; the first has 1. Unsigned, so that it wraps.
int32_t Environment::next_frame() const {
    return static_cast<int32_t>(static_cast<uint32_t>(state_.episode_frame) + 1 -
                                static_cast<uint32_t>(state_.first_frame));
}

bool Environment::add_write(std::shared_ptr<const Write> write, bool now) {
    const bool paid = write->paid;
    const int slot = writes_.add(std::move(write), state_.writes);
    active_writes_ = writes_.empty() ? nullptr : &writes_;
    if (slot < 0) return false;
    const bool changed = now && writes_.apply_now(slot, *console_, state_.writes, next_frame() - 1);
    if (changed && !paid) discard_reward();
    return true;
}

int Environment::remove_write(const Write* write) {
    const int slot = writes_.remove(write);
    if (writes_.empty()) active_writes_ = nullptr;
    return slot;
}

void Environment::set_writes(Writes::Slots slots) {
    writes_.set(std::move(slots));
    active_writes_ = writes_.empty() ? nullptr : &writes_;
}

void Environment::redraw(uint8_t* out) {
    const EnvironmentSnapshot before = snapshot();
    console_->run_frame();
    screen_rgb(out);
    restore(before);
}

Environment::Generators Environment::generators() const {
    return {state_.random, {state_.writes.random[0], state_.writes.random[1]}};
}

void Environment::set_generators(const Generators& generators) {
    state_.random = generators.random;
    std::copy_n(generators.writes, 2, state_.writes.random);
}

void Environment::restart() {
    const int paddles = settings_.second_player_starts ? kMaxPlayers : 2;
    std::fill_n(state_.paddle, paddles, (game_->paddle_min + game_->paddle_max) / 2);
    console_->reset();
    if (settings_.one_generator) console_->set_timer(state_.random.next());
}

void Environment::start_second_player() {
    emulate(0, 1.0f, 1);
    for (int action : game_->starting_actions) {
        if (action == kReset) continue;
        const int32_t actions[kMaxPlayers] = {0, action};
        emulate_players(actions);
        leave_ram_on_bus();
    }
    emulate(0, 1.0f, 1);
}

// If the machine is in the state of a checkpoint of the reset trace, its further frames equal those of the trace.
// (tests/cores/test_native.py compares with the reference core, which has no trace, after resets of every game)
void Environment::begin_game() {
    int frame = 0;
    for (; reset_trace_ && frame < ResetTrace::kCheckpoints; ++frame) {
        emulate_frame(0, 1.0f);
        if (resume(*reset_trace_, frame)) return;
    }
    emulate(0, 1.0f, kNoopFrames - frame);
    soft_reset();
}

namespace {

// Returns the part of the state that the frames of a reset trace depend on: without the number of random words drawn,
// the sound generator, which of the two framebuffers is the current one, and the data bus (`record_reset_trace`).
Machine essence(Machine machine) {
    machine.random_words = 0;
    machine.bus = 0;
    machine.sound.keep_generator_of(Sound{});
    machine.tia.current = 0;
    return machine;
}

}  // namespace

std::vector<uint8_t> Environment::both_framebuffers() {
    const size_t size = console_->config().framebuffer_bytes();
    std::vector<uint8_t> framebuffers(console_->framebuffer(), console_->framebuffer() + size);
    framebuffers.insert(framebuffers.end(), console_->previous_framebuffer(), console_->previous_framebuffer() + size);
    return framebuffers;
}

// Frames draw no random words, so they depend only on the state that `resume` compares. A frame that begins with a
// fetch from TIA space also depends on the byte that the rules left on the data bus. That byte may depend on the rules'
// variables, so a program with such a frame has no trace.
void Environment::record_reset_trace() {
    if (settings_.plain || console_->cartridge_ram_size() > 0) return;
    const auto trace = std::make_shared<ResetTrace>();
    restart();
    for (int frame = 0; frame < ResetTrace::kFrames; ++frame) {
        emulate_frame(frame < kNoopFrames ? 0 : kReset, 1.0f);
        if (!(console_->machine().cpu.pc & 0x1080)) return;
        std::copy_n(console_->ram(), 128, trace->ram[frame]);
        if (frame < ResetTrace::kCheckpoints) {
            console_->settle_latches();
            trace->checkpoints[frame] = {console_->machine(), both_framebuffers()};
        }
    }
    leave_ram_on_bus();
    trace->end = console_->snapshot();
    if (static_cast<const FastConsoleSnapshot&>(*trace->end).replaces_framebuffers())
        for (ResetTrace::Checkpoint& checkpoint : trace->checkpoints) checkpoint.framebuffers = {};
    reset_trace_ = trace;
}

// If the machine is in the state of the checkpoint after `frame`, continues as the trace did to its end and returns
// true. Otherwise changes nothing and returns false. The rules are evaluated on the trace's RAM.
bool Environment::resume(const ResetTrace& trace, int frame) {
    const ResetTrace::Checkpoint& then = trace.checkpoints[frame];
    console_->settle_latches();
    const Machine a = essence(console_->machine()), b = essence(then.machine);
    if (std::memcmp(&a, &b, sizeof a) != 0) return false;
    if (!then.framebuffers.empty() && then.framebuffers != both_framebuffers()) return false;
    const bool swapped = console_->machine().tia.current != then.machine.tia.current;
    while (++frame < ResetTrace::kFrames) {
        console_->set_ram(trace.ram[frame]);
        evaluate_step();
    }
    static_cast<FastConsole&>(*console_).resume(*trace.end, swapped);
    return true;
}

int Environment::act(int action, float strength) {
    int64_t total = 0;
    for (int i = 0; i < settings_.frame_skip; ++i) {
        // ALE draws two words a frame, one for each player, also where it needs neither.
        const double draw = state_.random.next() / 4294967296.0;
        state_.random.next();
        if (draw >= settings_.repeat_action_probability) {
            state_.held_action[0] = action;
            state_.held_strength = strength;
        }
        if (game_over() || truncated()) continue;
        const int held = state_.held_action[0];
        const bool legal = held < 18 && (game_->legal_actions >> held & 1);
        emulate(legal ? held : 0, state_.held_strength, 1);
        count_frame();
        total += state_.variables[game_->rewards[0]];
    }
    if (settings_.sound) console_->make_samples(state_.audio);
    return static_cast<int>(std::clamp<int64_t>(total, INT32_MIN, INT32_MAX));
}

void Environment::act(const int* actions, int players, int* rewards) {
    int64_t total[kMaxPlayers] = {};
    for (int i = 0; i < settings_.frame_skip; ++i) {
        // One word a player and frame, also after the end.
        for (int player = 0; player < kMaxPlayers; ++player) {
            int32_t& held = state_.held_action[player];
            if (player >= players) held = 0;
            else if (state_.random.next() / 4294967296.0 >= settings_.probability(player)) held = actions[player];
        }
        if (game_over() || truncated()) continue;
        int32_t pressed[kMaxPlayers];
        for (int player = 0; player < kMaxPlayers; ++player) {
            const int held = state_.held_action[player];
            pressed[player] = held < 18 && (game_->legal_actions >> held & 1) ? held : 0;
        }
        emulate_players(pressed);
        leave_ram_on_bus();
        count_frame();
        for (int player = 0; player < std::min(players, game_->players); ++player)
            total[player] += state_.variables[game_->rewards[static_cast<size_t>(player)]];
    }
    if (settings_.sound) console_->make_samples(state_.audio);
    for (int player = 0; player < players; ++player)
        rewards[player] = static_cast<int>(std::clamp<int64_t>(total[player], INT32_MIN, INT32_MAX));
}

// Runs frames with an action held. ALE reads all of RAM after the last of them.
void Environment::emulate(int action, float strength, int frames) {
    for (int i = 0; i < frames; ++i) emulate_frame(action, strength);
    leave_ram_on_bus();
}

// Runs a frame with an action of player 1 held.
void Environment::emulate_frame(int action, float strength) {
    press(action, strength);
    play_frame();
}

// Runs a frame with an action of each player held.
void Environment::emulate_players(const int32_t* actions) {
    release_all();
    for (int player = 0; player < kMaxPlayers; ++player) hold(player, actions[player], 1.0f);
    connect_paddles();
    play_frame();
}

// Runs a frame and evaluates the rules.
void Environment::play_frame() {
    if (active_writes_) return play_frame_with_writes();
    console_->run_frame();
    evaluate_step();
}

// The rules read RAM after the writes. If some writes are not to be rewarded, the rules also read it before these, which
// gives the reward; all else is as the rules find it after all writes.
void Environment::play_frame_with_writes() {
    const int32_t frame = next_frame();
    writes_.begin_frame(*console_, state_.writes);
    console_->run_frame();
    writes_.apply(*console_, state_.writes, frame, true);
    int32_t before[kMaxVariables];
    std::copy_n(state_.variables, kMaxVariables, before);
    evaluate_step();
    if (!writes_.apply(*console_, state_.writes, frame, false)) return;
    int32_t rewards[kMaxPlayers];
    for (size_t player = 0; player < kMaxPlayers; ++player) rewards[player] = state_.variables[game_->rewards[player]];
    std::copy_n(before, kMaxVariables, state_.variables);
    evaluate_step();
    for (size_t player = 0; player < kMaxPlayers; ++player) state_.variables[game_->rewards[player]] = rewards[player];
}

void Environment::release_all() {
    Inputs& inputs = console_->inputs();
    inputs.stick[0] = inputs.stick[1] = 0;
    inputs.fire[0] = inputs.fire[1] = false;
    std::fill_n(inputs.paddle_fire, kMaxPlayers, false);
    // The colour switch is on, RESET and SELECT are up, and the difficulty switches are as set.
    inputs.switches = static_cast<uint8_t>(0x3f | (state_.difficulty & 3) << 6);
}

void Environment::press(int action, float strength) {
    release_all();
    Inputs& inputs = console_->inputs();
    if (action == kReset) inputs.switches &= 0xfe;
    hold(0, action, strength);
    connect_paddles();
}

// Holds the action of a player at the console's inputs. There are two joysticks.
void Environment::hold(int player, int action, float strength) {
    Inputs& inputs = console_->inputs();
    if (game_->paddles()) {
        move_paddle(player, action, strength);
        inputs.paddle_fire[player] = motion(action).fire;
    } else if (player < 2) {
        inputs.stick[player] = motion(action).stick;
        inputs.fire[player] = motion(action).fire;
    }
}

void Environment::connect_paddles() {
    if (game_->paddles()) std::copy_n(state_.paddle, kMaxPlayers, console_->inputs().resistance);
}

void Environment::move_paddle(int player, int action, float strength) {
    const int delta = static_cast<int>(23000.0 * std::abs(static_cast<double>(strength)));
    const uint8_t stick = motion(action).stick;
    const int direction = stick & 8 ? -1 : stick & 4 ? 1 : 0;
    state_.paddle[player] = std::clamp(state_.paddle[player] + direction * delta, game_->paddle_min, game_->paddle_max);
}

void Environment::soft_reset() {
    emulate(kReset, 1.0f, kResetFrames);
    std::fill_n(state_.held_action, kMaxPlayers, 0);
}

// Holds SELECT for `frames` frames, in which the rules are not evaluated, then releases it for one frame.
void Environment::press_select(int frames) {
    release_all();
    console_->inputs().switches &= 0xfd;
    for (int i = 0; i < frames; ++i) console_->run_frame();
    emulate(0, 1.0f, 1);
    count_frame();
}

// Unsigned, so that the counters wrap after 2^31 frames instead of overflowing.
void Environment::count_frame() {
    for (int32_t* counter : {&state_.frame, &state_.episode_frame})
        *counter = static_cast<int32_t>(static_cast<uint32_t>(*counter) + 1);
}

// Takes frames from the budget of a mode selection, because a ROM may never reach the mode under the rules of another
// game. Throws std::runtime_error when the budget is used up.
void Environment::spend(int frames) {
    if (frames < 0 || frames > select_budget_)
        throw std::runtime_error("the mode cannot be selected: the game never reaches it (is this ROM of this game?)");
    select_budget_ -= frames;
}

// What a rule program reads and does.
struct Environment::RuleHost {
    Environment& environment;
    int32_t* variables = environment.state_.variables;

    int64_t byte(int64_t address) { return environment.console_->read_ram(static_cast<uint8_t>(address)); }
    int64_t xbyte(int64_t address) {
        const Console& console = *environment.console_;
        return console.cartridge_ram_size() >= 128 ? console.cartridge_ram()[address & 0x7f] : 0;
    }
    uint32_t random() { return environment.state_.random.next(); }
    void spend(int frames) { environment.spend(frames); }
    void press_select(int64_t frames) {
        const int count = static_cast<int>(std::clamp<int64_t>(frames, 0, kSelectFrames));
        spend(count + 1);
        environment.press_select(count);
    }
    void soft_reset() {
        spend(kResetFrames);
        environment.soft_reset();
    }
    void act(int action) {
        spend(environment.settings_.frame_skip);
        if (environment.game_->players == 1) {
            environment.act(action, 1.0f);
        } else {
            const int actions[] = {action, 0};
            int rewards[2];
            environment.act(actions, 2, rewards);
        }
    }
};

void Environment::run(const Program& program) { evaluate(program, RuleHost{*this}); }

const std::vector<uint8_t>& Environment::blended() {
    averaged_.resize(static_cast<size_t>(height()) * kScreenWidth);
    average_framebuffers(console_->framebuffer(), console_->previous_framebuffer(), averaged_.size(), *game_->palette,
                         averaged_.data());
    return averaged_;
}

void Environment::screen(uint8_t* out) {
    const uint8_t* pixels = settings_.colour_averaging ? blended().data() : console_->framebuffer();
    std::memcpy(out, pixels, static_cast<size_t>(height()) * kScreenWidth);
}

void Environment::screen_rgb(uint8_t* out) {
    const uint8_t* pixels = settings_.colour_averaging ? blended().data() : console_->framebuffer();
    to_rgb(pixels, height(), *game_->palette, out);
}

void Environment::screen_gray(uint8_t* out) {
    const uint8_t* pixels = settings_.colour_averaging ? blended().data() : console_->framebuffer();
    to_gray(pixels, height(), *game_->palette, out);
}

void Environment::save(uint8_t* out) {
    std::memcpy(out, &state_, sizeof state_);
    console_->save(out + sizeof state_);
}

bool Environment::load(const uint8_t* in) {
    EnvironmentState state;
    std::memcpy(&state, in, sizeof state);
    bool good = state.random.position <= 624 && std::abs(state.held_strength) <= 1000.0f;
    for (int32_t action : state.held_action) good &= action >= 0 && action <= kReset;
    for (int32_t position : state.paddle) good &= position >= 0 && position <= 1 << 24;
    if (!good || !console_->load(in + sizeof state)) return false;
    state_ = state;
    return true;
}

EnvironmentSnapshot Environment::snapshot() const { return {state_, settings_.plain, console_->snapshot()}; }

std::vector<uint8_t> EnvironmentSnapshot::bytes(const Game& game) const {
    const auto restored = make_console(game, plain);
    restored->restore(*console);
    std::vector<uint8_t> bytes(sizeof state + restored->state_size());
    std::memcpy(bytes.data(), &state, sizeof state);
    restored->save(bytes.data() + sizeof state);
    return bytes;
}

bool Environment::restore(const EnvironmentSnapshot& snapshot) {
    if (snapshot.plain != settings_.plain) return false;
    state_ = snapshot.state;
    console_->restore(*snapshot.console);
    return true;
}

}  // namespace atari
