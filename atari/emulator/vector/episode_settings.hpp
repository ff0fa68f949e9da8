// `EpisodeSettings`: how episodes begin, are played, and end. The names are those of the options in Python.
#pragma once

#include <optional>
#include <utility>

#include "ale/environment.hpp"

namespace atari {

enum class FirePress { kNever, kBeforeNoops, kAfterNoops };
enum class Unit { kFrame, kSkip };                  // single frames inside of the frame skip, or whole skips
enum class OnReset { kNoop, kContinue, kNewGame };  // the effect of a reset after a lost life
enum class Seeding { kGymnasium, kAle };            // the seeds of AtariEnv.reset, or of ale-py's vector environment

// The defaults are those of ale-py's vector environment.
struct EpisodeSettings {
    int players = 1;
    double repeat_action_probability = 0.0;
    Seeding seeding = Seeding::kAle;
    std::pair<int, int> frameskip{4, 5};  // each step draws from first .. second-1
    // If true, the rest of a skip is acted out after the end of an episode, as by AtariEnv without wrappers. No frame
    // is played then, but sticky actions draw.
    bool acts_after_end = false;

    // How an episode begins.
    std::pair<int, int> noops{0, 29};          // the number of no-ops is drawn from first .. second
    FirePress fire = FirePress::kBeforeNoops;  // in games that have FIRE
    bool fire_counts = true;                   // whether FIRE is one of the no-ops
    bool third_action = false;                 // whether the action with index 2 follows FIRE
    Unit fire_unit = Unit::kFrame;             // the duration of FIRE, and of the third action
    bool fire_again = false;                   // whether both follow a game that ended in the no-ops, too

    // The effects of a lost life.
    bool episodic_life = false;
    Unit lives_unit = Unit::kFrame;  // lives are compared after each of these
    OnReset on_reset = OnReset::kNewGame;
    bool last_life = false;       // whether losing the last life counts if the game continues
    bool seamless_lives = false;  // a lost life neither cuts a skip nor clears the stack
    bool life_loss_info = false;  // a lost life is reported, and ends nothing

    // The limits at which an episode is truncated.
    std::optional<int> max_frames = 108000;  // a game's, without the frames that begin it inside of the skip
    std::optional<int> max_episode_steps;
    std::optional<int> max_num_frames_per_episode;  // the emulator's: all frames of a game count

    bool reward_clipping = true;

    // Throws std::invalid_argument if a setting is out of range, or has no effect beside another.
    void check() const;
    Settings emulator() const;
};

}  // namespace atari
