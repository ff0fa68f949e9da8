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

// A setting is one line of episode_settings.def; the members and the binding follow from it.
struct EpisodeSettings {
    using Range = std::pair<int, int>;
    using Limit = std::optional<int>;

#define SETTING(type, name, ...) type name = __VA_ARGS__;
#include "episode_settings.def"

    // Throws std::invalid_argument if a setting is out of range, or has no effect beside another.
    void check() const;
    Settings emulator() const;
};

}  // namespace atari
