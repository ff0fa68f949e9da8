// `make_lanes`: makes the environments of a vector engine from their declarations in Python.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "engine.hpp"

namespace atari {

using SeedWords = std::array<uint32_t, 9>;  // the emulator's, then those of `Seed::own`
Seed seed_of(const SeedWords& words);

// `begin_actions` are the actions that the game uses, `actions` ALE's numbers of the user's action indices.
StartActions start_actions(const std::vector<int>& begin_actions, const std::vector<int>& actions);

// The differences between the environments of a vector.
struct LaneSpec {
    std::shared_ptr<const Game> game;
    std::vector<int> actions;     // ALE's number of each action index that the user gives
    std::vector<int> action_set;  // the actions that the game uses
    std::optional<int> mode, difficulty;
    SeedWords seed{};
    std::shared_ptr<const RewardFormula> reward;  // null pays the game's own
};

// Throws std::invalid_argument if a setting is out of range or a size cannot be made.
std::vector<std::unique_ptr<Lane>> make_lanes(const std::vector<LaneSpec>& specs, const EpisodeSettings& episode,
                                              const ObservationSettings& observation);

}  // namespace atari
