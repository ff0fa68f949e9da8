// `_emulator.State`: the result of `Emulator.clone_state`.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "ale/environment_parts.hpp"

namespace atari {

// A digest of a game's image (FNV-1a): a pickled state fits environments of games with the same digest.
uint64_t image_digest(const Game& game);

// The bytes of Environment::save.
inline std::vector<uint8_t> saved(Environment& environment) {
    std::vector<uint8_t> bytes(environment.state_size());
    environment.save(bytes.data());
    return bytes;
}

// A state of an emulator in memory. A state that was unpickled consists of bytes, and its `game` is null.
struct State {
    std::shared_ptr<const Game> game;
    bool include_rng;
    EnvironmentSnapshot snapshot;
    std::vector<uint8_t> bytes;
    uint64_t image;

    // Returns false, and changes nothing, if the state is of another game or of another kind of core.
    bool restore(Environment& environment) const;
    EnvironmentState numbers() const;
    // A header, and the bytes of Environment::save. The generator is zero unless `include_rng`.
    std::vector<uint8_t> serialize() const;
};

}  // namespace atari
