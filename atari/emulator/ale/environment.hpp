// `Environment`: one emulated game under ALE's rules. A program that plays games needs this header alone: it includes
// no other file of the emulator. The emulator's other folders reach the parts of an environment through
// `environment_parts.hpp`.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace atari {

inline constexpr int kMaxPlayers = 4;
inline constexpr int kMaxFrameSkip = 10'000;  // also in a vector: a call must end within seconds

template <typename T>
using OfPlayers = std::array<T, kMaxPlayers>;  // zero for players that do not play

// How ALE's layer plays a game, in a game definition and in the compiled game.
struct GameRules {
    bool detect_format = true;         // run 60 frames before the first reset, as when the format is unknown
    uint8_t power_on_switches = 0x3f;  // SWCHB during those frames
    int32_t paddle_min = 27450, paddle_max = 790196;
    uint32_t legal_actions = 0x3ffff;  // bit a: action a is allowed
    std::vector<int> starting_actions;
    int default_mode = 0;

    // Variables are numbered. The variables of the definition's `state` have a start value and keep their value
    // between frames.
    int variables = 3;
    std::vector<int32_t> initial;  // start values of variables 0 .. initial.size()-1
    std::vector<uint8_t> kept;     // 1 for each of these that a reset keeps
    int players = 1;               // players with a reward and lives
    OfPlayers<int> rewards{0}, lives{2};
    int terminal = 1;
    int mode_variable = 0;  // variable that holds the selected mode

    void set_legal_actions(const std::vector<int32_t>& actions);  // others than ALE's 18 are left out
    // `outputs` are the variables terminal and mode, then reward and lives of each player. Throws std::invalid_argument
    // for another number of them.
    void set_outputs(const std::vector<int32_t>& outputs);
};

// A game definition, as atari/games/compiler.py compiles it, with the image of the game's ROM.
struct GameDefinition : GameRules {
    std::vector<uint8_t> image;
    std::string cartridge;        // the bank switching, for example "F8"; empty to recognise it from the image
    std::string format = "NTSC";  // or "PAL", "SECAM"
    int first_line = 34, height = 210;
    bool hmove_blanks = true;
    bool paddles[2] = {false, false};  // left and right jack; otherwise a joystick
    bool swap_ports = false, swap_paddles = false;
    std::vector<int32_t> step, select_mode;  // words of programs (programs/program.hpp)
};

struct Game;  // a compiled game definition: immutable, shared by all environments of the game

// Throws std::invalid_argument if the image is of no supported type, or a number or a program is out of range.
std::shared_ptr<const Game> make_game(const GameDefinition& definition);

struct Settings {
    double repeat_action_probability = 0.25;
    int frame_skip = 1;
    int32_t max_frames_per_episode = 0;
    bool sound = false;
    bool color_averaging = false;
    bool plain = false;  // use the reference core, the oracle of the fast one

    // Multi-Agent-ALE has one generator for the machine and for sticky actions. ale-py has two.
    bool one_generator = false;
    // Multi-Agent-ALE's reset centres four paddles, and player 2 makes the starting actions, too.
    bool second_player_starts = false;

    // Each player's probability of sticky actions, if they differ.
    std::vector<double> player_probabilities{};

    double probability(int player) const {
        const auto index = static_cast<size_t>(player);
        return index < player_probabilities.size() ? player_probabilities[index] : repeat_action_probability;
    }
};

struct EnvironmentSnapshot;  // environment_state.hpp

class Environment {
  public:
    static constexpr int kWidth = 160;  // pixels of a row of a screen

    // If there is a `twin` of the same game and settings, the constructor copies its loaded state and its reset trace.
    Environment(std::shared_ptr<const Game> game, const Settings& settings, uint32_t seed,
                const Environment* twin = nullptr);
    ~Environment();

    void seed(uint32_t seed);  // acts as a fresh load with this seed; mode and difficulty stay
    void reset();              // throws std::runtime_error if the mode cannot be selected
    // Plays `frame_skip` frames with the actions of the first `players` players, ALE numbers 0..17. Returns each
    // player's reward. If there is one player, `strength` is a factor for the distance that the paddle moves.
    OfPlayers<int> act(const OfPlayers<int>& actions, int players = 1, float strength = 1.0f);

    int mode() const;
    void set_mode(int mode);  // from the next reset on
    int difficulty() const;
    void set_difficulty(int difficulty);

    int lives(int player = 0) const;
    bool game_over() const;
    bool truncated() const;
    int frame_number() const;
    int episode_frame_number() const;

    int height() const;              // rows of a screen, at least 200
    void screen(uint8_t* out);       // palette indices, height() x kWidth
    void screen_rgb(uint8_t* out);   // height() x kWidth x 3
    void screen_gray(uint8_t* out);  // height() x kWidth
    void redraw(uint8_t* out);       // the present RAM as RGB, from a frame that leaves no trace
    const uint8_t* audio() const;    // 512 samples of the last act at 31400 Hz, unsigned around 128
    const uint8_t* ram() const;      // 128 bytes
    void set_ram(int index, int value);

    // The state as bytes, for this release and machine. `load` returns false and changes nothing if it is invalid.
    size_t state_size() const;
    void save(uint8_t* out);
    bool load(const uint8_t* in);
    // The state in memory, which is faster than `save`. `restore` accepts a snapshot of any environment of the same
    // game and the same kind of console. If the kind differs, it returns false and changes nothing.
    EnvironmentSnapshot snapshot() const;
    bool restore(const EnvironmentSnapshot& snapshot);

    struct Parts;  // environment_parts.hpp
    Parts& parts() { return *parts_; }
    const Parts& parts() const { return *parts_; }

  private:
    std::unique_ptr<Parts> parts_;
};

}  // namespace atari
