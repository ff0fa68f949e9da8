// `Environment::Parts`: the parts of an environment, for the implementation and for the folders above `ale`.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "controllers.hpp"
#include "environment_state.hpp"
#include "game.hpp"
#include "machine/console.hpp"
#include "reset_trace.hpp"
#include "ale/programs/writes.hpp"

namespace atari {

// Owns the console, the rules' variables and the random generator.
struct Environment::Parts {
    std::shared_ptr<const Game> game;
    Settings settings;
    std::unique_ptr<Console> console;  // a FastConsole, unless `settings.plain`
    EnvironmentState state{};
    std::shared_ptr<const EnvironmentSnapshot> loaded{};  // the state after a load; null if it depends on the seed
    std::shared_ptr<const ResetTrace> reset_trace{};      // may be null
    // The writes that every further frame applies. They are options of an environment: a snapshot has their state, but
    // not the writes.
    Writes writes{};
    Writes* active_writes = nullptr;  // `writes` while there are any and an episode is played
    int select_budget = 0;            // frames left for the selection of a mode
    std::vector<uint8_t> averaged{};

    bool game_over() const { return state.variables[game->terminal] != 0; }
    bool truncated() const {
        return settings.max_frames_per_episode > 0 && state.episode_frame >= settings.max_frames_per_episode;
    }
    EnvironmentSnapshot snapshot() const { return {state, settings.plain, console->snapshot()}; }
    bool restore(const EnvironmentSnapshot& snapshot);
    // The last frame as palette indices; with colour averaging, mixed with the frame before.
    const uint8_t* framebuffer();

    // resets.cpp: loads, and the starts of episodes
    void load(uint32_t seed);
    void begin_episode();  // a reset without the writes
    void boot(uint32_t seed);
    void restart();
    void begin_game();
    void record_reset_trace();
    bool resume(const ResetTrace& trace, int frame);
    void start_second_player();
    void soft_reset();
    void press_select(int64_t frames);
    void spend(int frames);

    // frame_skip_and_sticky_actions.cpp
    OfPlayers<int> act(const OfPlayers<int>& actions, int players, float strength);
    void draw_sticky_actions(const OfPlayers<int>& actions, int players, float strength);

    // frames.cpp: a frame holds actions, applies writes and evaluates the rules
    void hold(int action, int frames);
    void hold_frame(int action);
    void play_actions(const int32_t* actions, int players, float strength);
    void play_frame();
    void play_frame_with_writes();
    void evaluate_step() { run(game->step); }
    struct RuleHost;
    void run(const Program& program);
    void count_frame();
    int32_t next_frame() const;
    void begin_writes();  // after `begin_episode`
    void discard_reward();
    void clear_rewards();
    Controllers controllers() { return {*game, state, console->inputs()}; }
    void leave_ram_on_bus() { console->read_ram(0xff); }  // the last byte of a read of all of RAM

    // With `now`, the write is also applied at once. Returns false if there are kMaxWrites already.
    bool add_write(std::shared_ptr<const Write> write, bool now);
    int remove_write(const Write* write);  // returns the slot that it had, or -1
    void set_writes(Writes::Slots slots);
};

}  // namespace atari
