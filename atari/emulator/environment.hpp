// ALE's layer on the console: a game with its rules, actions, reward, lives, sticky actions and counters.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "console.hpp"
#include "palettes.hpp"
#include "program.hpp"
#include "random.hpp"

namespace atari {

// What a game file says, compiled. Immutable and shared by all environments of the game.
struct Game {
    std::shared_ptr<const Cartridge> cartridge;
    ConsoleConfig console;
    const Palette* palette = &NTSC;
    bool detect_format = true;        // run 60 frames before the first reset, as when the format is unknown
    uint8_t power_on_switches = 0x3f; // SWCHB during those frames
    int32_t paddle_min = 27450, paddle_max = 790196;
    uint32_t legal_actions = 0x3ffff; // bit a: action a is allowed
    std::vector<int> starting_actions;
    int default_mode = 0;

    // Rules. Variables are numbered; those of `state` have a start value and persist.
    int variables = 3;
    std::vector<int32_t> initial;     // start values of variables 0 .. initial.size()-1
    std::vector<uint8_t> kept;        // which of those a reset leaves alone
    int reward = 0, terminal = 1, lives = 2;
    int mode_variable = 0;            // where the programs find the selected mode
    Program step, select_mode;

    void check() const;  // throws std::invalid_argument if a number is out of the range that an environment relies on
};

struct Settings {
    double repeat_action_probability = 0.25;
    int frame_skip = 1;
    int32_t max_frames_per_episode = 0;
    bool sound = false;
    bool colour_averaging = false;
    bool plain = false;  // by the plain interpreter and TIA, the oracle of the fast ones
};

struct EnvironmentState {
    MersenneTwister random;
    int32_t paddle[2];
    int32_t held_action;
    float held_strength;
    int32_t frame, episode_frame;
    int32_t mode, difficulty;
    int32_t variables[kMaxVariables];
    uint8_t audio[kAudioSamples];
};

// An environment's whole state, copied in memory.
struct EnvironmentCopy {
    EnvironmentState state;
    ConsoleCopy console;
};

// How a game begins: what becomes of the frames between a console's reset and the selection of a mode. In most games that
// hardly depends on what was before, as they clear their RAM first.
struct Beginning {
    static constexpr int kFrames = 60 + 4, kMeetings = 4;  // RESET is held in the last four

    // What was there behind each of the first frames. Pictures only if something of them may be left at the end.
    struct Meeting {
        Machine machine;
        std::vector<uint8_t> pictures;
    };
    Meeting meetings[kMeetings];
    uint8_t ram[kFrames][128];  // behind every frame
    ConsoleCopy end;
};

class Environment {
  public:
    // A `twin` of the same game and settings has done the loading already.
    Environment(std::shared_ptr<const Game> game, const Settings& settings, uint32_t seed, const Environment* twin = nullptr);

    void seed(uint32_t seed);  // as a fresh load with this seed; mode and difficulty stay
    void reset();              // throws std::runtime_error if the mode cannot be selected
    int act(int action, float strength);
    int mode() const { return mode_; }
    int difficulty() const { return difficulty_; }
    void set_mode(int mode) { mode_ = mode; state_.mode = mode; }
    void set_difficulty(int difficulty) { difficulty_ = difficulty; state_.difficulty = difficulty; }

    int lives() const { return state_.variables[game_->lives]; }
    bool game_over() const { return state_.variables[game_->terminal] != 0; }
    bool truncated() const {
        return settings_.max_frames_per_episode > 0 && state_.episode_frame >= settings_.max_frames_per_episode;
    }
    int frame_number() const { return state_.frame; }
    int episode_frame_number() const { return state_.episode_frame; }
    int height() const { return std::max(game_->console.height, 200); }

    void screen(uint8_t* out);       // palette indices, height() x 160
    void screen_rgb(uint8_t* out);   // height() x 160 x 3
    void screen_gray(uint8_t* out);  // height() x 160
    const uint8_t* audio() const { return state_.audio; }
    const uint8_t* ram() const { return console_.ram(); }
    void set_ram(int index, int value) { console_.poke_ram(static_cast<uint8_t>(0x80 + index), static_cast<uint8_t>(value)); }
    const MersenneTwister& generator() const { return state_.random; }
    void set_generator(const MersenneTwister& generator) { state_.random = generator; }
    Console& console() { return console_; }
    const std::shared_ptr<const Game>& game() const { return game_; }

    size_t state_size() const { return sizeof(EnvironmentState) + console_.state_size(); }
    void save(uint8_t* out);
    bool load(const uint8_t* in);  // false, and nothing changed, if no environment could have saved it

    // The same in memory, in less than a microsecond. `copy_from` takes the copy of any environment of the same game
    // and core; false, and nothing changed, if it is of the other core.
    void copy_to(EnvironmentCopy& copy) const;
    bool copy_from(const EnvironmentCopy& copy);

  private:
    void boot();
    void restart();
    void begin_game();
    void watch_beginning();
    bool join(const Beginning& beginning, int frame);
    std::vector<uint8_t> both_pictures();
    void emulate(int action, float strength, int frames);
    void press(int action, float strength);
    void move_paddle(int player, int action, float strength);
    void release_all();
    void soft_reset();
    void press_select(int frames);
    void count_frame();
    void evaluate_step() { run(game_->step); }
    void run(const Program& program);
    void spend(int frames);
    const std::vector<uint8_t>& blended();

    std::shared_ptr<const Game> game_;
    Settings settings_;
    Console console_;
    EnvironmentState state_{};
    int mode_, difficulty_ = 0;
    std::shared_ptr<const EnvironmentCopy> loaded_;  // the state after a load, where it does not depend on the seed
    std::shared_ptr<const Beginning> beginning_;     // may be null
    int select_budget_ = 0;           // frames the selection of a mode may still take
    std::vector<uint8_t> averaged_;
};

}  // namespace atari
