// The state of an environment: ALE's layer, the rules and the console.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "environment.hpp"
#include "machine/console.hpp"
#include "machine/random.hpp"
#include "ale/programs/program.hpp"
#include "ale/programs/writes.hpp"

namespace atari {

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

    std::vector<uint8_t> bytes(const Game& game) const;  // the bytes that Environment::save writes
};

}  // namespace atari
