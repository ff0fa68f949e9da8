// `Controllers`: the joysticks or paddles that players hold, and the switches of the console.
#pragma once

#include <cstdint>

#include "environment_state.hpp"
#include "game.hpp"
#include "machine/state.hpp"

namespace atari {

inline constexpr int kActions = 18;                 // a player's actions: ALE numbers 0..17
inline constexpr int kReset = 40;                   // ALE's action that holds the console's switch RESET
inline constexpr int32_t kMaxResistance = 1 << 24;  // a paddle's, in ohms

// Sets the inputs of a console, before it plays a frame, by the actions of the players.
struct Controllers {
    const Game& game;
    EnvironmentState& state;  // positions of paddles, and the difficulty
    Inputs& inputs;

    void release_all() const;
    void hold_reset() const { inputs.switches &= 0xfe; }
    void hold_select() const { inputs.switches &= 0xfd; }
    // Holds the action of a player, and moves a paddle by `strength` times the distance of a frame. There are two
    // joysticks.
    void hold(int player, int action, float strength) const;
    void connect_paddles() const;  // after all paddles have moved

  private:
    void move_paddle(int player, int action, float strength) const;
};

}  // namespace atari
