// ALE's layer on the console: a game with its rules, actions, reward, lives, sticky actions and counters.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "machine/console.hpp"
#include "fast/fast_console.hpp"
#include "palettes.hpp"
#include "program.hpp"
#include "machine/random.hpp"
#include "writes.hpp"

namespace atari {

inline constexpr int kMaxPlayers = 4;

// A compiled game definition. Immutable and shared by all environments of the game.
struct Game {
    std::shared_ptr<const FastCartridge> cartridge;
    ConsoleConfig console;
    const Palette* palette = &NTSC;
    bool detect_format = true;         // run 60 frames before the first reset, as when the format is unknown
    uint8_t power_on_switches = 0x3f;  // SWCHB during those frames
    int32_t paddle_min = 27450, paddle_max = 790196;
    uint32_t legal_actions = 0x3ffff;  // bit a: action a is allowed
    std::vector<int> starting_actions;
    int default_mode = 0;

    // Rules. Variables are numbered. The variables of the definition's `state` have a start value and keep their value
    // between frames.
    int variables = 3;
    std::vector<int32_t> initial;  // start values of variables 0 .. initial.size()-1
    std::vector<uint8_t> kept;     // 1 for each of those that a reset does not change
    int players = 1;               // that have a reward and lives
    std::array<int, kMaxPlayers> rewards{0}, lives{2};
    int terminal = 1;
    int mode_variable = 0;  // variable that holds the selected mode
    Program step, select_mode;

    bool paddles() const { return console.paddles[0] || console.paddles[1]; }

    void check() const;  // throws std::invalid_argument if a number is out of the range that `Environment` accepts
};

inline constexpr int kMaxFrameSkip = 10'000;  // of the settings below and of a vector's: a call ends in seconds

struct Settings {
    double repeat_action_probability = 0.25;
    int frame_skip = 1;
    int32_t max_frames_per_episode = 0;
    bool sound = false;
    bool colour_averaging = false;
    bool plain = false;  // use the reference core, the oracle of the fast one

    // Multi-Agent-ALE has one generator for the machine and for sticky actions. ale-py has two.
    bool one_generator = false;
    // Multi-Agent-ALE's reset centres four paddles, and player 2 makes the starting actions, too.
    bool second_player_starts = false;

    // Of sticky actions of each player, where they differ.
    std::vector<double> player_probabilities{};

    double probability(int player) const {
        const auto index = static_cast<size_t>(player);
        return index < player_probabilities.size() ? player_probabilities[index] : repeat_action_probability;
    }
};

// The version of the layout of `EnvironmentState` and `Machine` in memory, which is the layout of saved states.
inline constexpr int kStateVersion = 3;

struct EnvironmentState {
    MersenneTwister random;
    int32_t paddle[kMaxPlayers];
    int32_t held_action[kMaxPlayers];
    float held_strength;
    int32_t frame, episode_frame;
    int32_t mode, difficulty;
    int32_t variables[kMaxVariables];
    WriteState writes;
    int32_t first_frame;  // the episode frame number after the reset
    uint8_t audio[kAudioSamples];
};

// A snapshot of an environment in memory.
struct EnvironmentSnapshot {
    EnvironmentState state;
    bool plain = false;  // whether the reference core made it
    std::unique_ptr<const ConsoleSnapshot> console;

    std::vector<uint8_t> bytes(const Game& game) const;  // as Environment::save writes them
};

// Frames after a reset of the console: first frames without input, then frames in which RESET is held.
inline constexpr int kNoopFrames = 60, kResetFrames = 4;

// The frames between a console's reset and the selection of a mode, stored once for a game and its settings. Most games
// clear their RAM first, so these frames hardly depend on the state before the reset. If the machine is in the state of
// a checkpoint, the reset resumes from the trace and skips the remaining frames.
struct ResetTrace {
    static constexpr int kFrames = kNoopFrames + kResetFrames, kCheckpoints = 4;

    // The state after each of the first frames. `framebuffers` is empty if the end of the trace replaces all of both.
    struct Checkpoint {
        Machine machine;
        std::vector<uint8_t> framebuffers;
    };
    Checkpoint checkpoints[kCheckpoints];
    uint8_t ram[kFrames][128];                   // after every frame
    std::unique_ptr<const ConsoleSnapshot> end;  // the state after the last frame
};

// Returns the reference core if `plain`, otherwise a `FastConsole`.
std::unique_ptr<Console> make_console(const Game& game, bool plain);

// One emulated game under ALE's rules. It owns the console, the rules' variables and the random generator.
class Environment {
  public:
    // If there is a `twin` of the same game and settings, the constructor copies its loaded state and its reset trace.
    Environment(std::shared_ptr<const Game> game, const Settings& settings, uint32_t seed,
                const Environment* twin = nullptr);

    void seed(uint32_t seed);  // acts as a fresh load with this seed; mode and difficulty stay
    void reset();              // throws std::runtime_error if the mode cannot be selected
    int act(int action, float strength);
    // The same for the first `players` players, of whom each has an action. Writes a reward for each.
    void act(const int* actions, int players, int* rewards);
    int mode() const { return mode_; }
    int difficulty() const { return difficulty_; }
    void set_mode(int mode) {
        mode_ = mode;
        state_.mode = mode;
    }
    void set_difficulty(int difficulty) {
        difficulty_ = difficulty;
        state_.difficulty = difficulty;
    }

    int lives(int player = 0) const { return state_.variables[game_->lives[static_cast<size_t>(player)]]; }
    bool game_over() const { return state_.variables[game_->terminal] != 0; }
    bool truncated() const {
        return settings_.max_frames_per_episode > 0 && state_.episode_frame >= settings_.max_frames_per_episode;
    }
    int frame_number() const { return state_.frame; }
    int episode_frame_number() const { return state_.episode_frame; }
    int height() const { return std::max(game_->console.height, 200); }
    bool averages_colours() const { return settings_.colour_averaging; }

    void screen(uint8_t* out);       // palette indices, height() x 160
    void screen_rgb(uint8_t* out);   // height() x 160 x 3
    void screen_gray(uint8_t* out);  // height() x 160
    const uint8_t* audio() const { return state_.audio; }
    const uint8_t* ram() const { return console_->ram(); }
    void set_ram(int index, int value) {
        console_->poke_ram(static_cast<uint8_t>(0x80 + index), static_cast<uint8_t>(value));
    }

    // Writes that every further frame applies, and with `now` also this call. They are options of an environment: a snapshot
    // has their state, but not which there are. False if there are kMaxWrites already.
    bool add_write(std::shared_ptr<const Write> write, bool now);
    int remove_write(const Write* write);
    const Writes& writes() const { return writes_; }
    void set_writes(Writes::Slots slots);
    // Draws the present RAM, as screen_rgb does, by emulating a frame. The state stays what it is.
    void redraw(uint8_t* out);

    struct Generators {
        MersenneTwister random;
        uint32_t writes[2];
    };
    Generators generators() const;
    void set_generators(const Generators& generators);
    const int32_t* variables() const { return state_.variables; }  // of the rules: kMaxVariables
    Console& console() { return *console_; }
    const std::shared_ptr<const Game>& game() const { return game_; }

    size_t state_size() const { return sizeof(EnvironmentState) + console_->state_size(); }
    void save(uint8_t* out);
    bool load(const uint8_t* in);  // returns false and changes nothing if the state is invalid

    // The state in memory, which is faster than `save`. `restore` accepts a snapshot of any environment of the same
    // game and the same kind of console. If the kind differs, it returns false and changes nothing.
    EnvironmentSnapshot snapshot() const;
    bool restore(const EnvironmentSnapshot& snapshot);

  private:
    void boot(uint32_t seed);
    void restart();
    void start_second_player();
    void begin_game();
    void record_reset_trace();
    bool resume(const ResetTrace& trace, int frame);  // from the checkpoint after `frame`
    std::vector<uint8_t> both_framebuffers();
    void emulate(int action, float strength, int frames);
    void emulate_frame(int action, float strength);
    void emulate_players(const int32_t* actions);
    void play_frame();
    void play_frame_with_writes();
    void begin_writes();
    void discard_reward();
    void clear_rewards();
    int32_t next_frame() const;
    void begin_episode();                                  // a reset without the writes
    void leave_ram_on_bus() { console_->read_ram(0xff); }  // the last byte of a read of all of RAM
    void press(int action, float strength);
    void hold(int player, int action, float strength);
    void connect_paddles();
    void move_paddle(int player, int action, float strength);
    void release_all();
    void soft_reset();
    void press_select(int frames);
    void count_frame();
    void evaluate_step() { run(game_->step); }
    struct RuleHost;
    void run(const Program& program);
    void spend(int frames);
    const std::vector<uint8_t>& blended();

    std::shared_ptr<const Game> game_;
    Settings settings_;
    std::unique_ptr<Console> console_;  // a FastConsole, unless `settings_.plain`
    EnvironmentState state_{};
    int mode_, difficulty_ = 0;
    std::shared_ptr<const EnvironmentSnapshot> loaded_;  // the state after a load; null if it depends on the seed
    std::shared_ptr<const ResetTrace> reset_trace_;      // may be null
    Writes writes_;
    Writes* active_writes_ = nullptr;  // `writes_` while there are any and an episode is played
    int select_budget_ = 0;            // frames left for the selection of a mode
    std::vector<uint8_t> averaged_;
};

}  // namespace atari
