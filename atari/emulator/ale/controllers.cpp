#include "controllers.hpp"

#include <algorithm>
#include <cmath>

namespace atari {
namespace {

constexpr double kPaddleStep = 23000.0;  // ohms, in a frame
enum Stick : uint8_t { kUp = 1, kDown = 2, kLeft = 4, kRight = 8 };

struct Motion {
    uint8_t stick;
    bool fire;
};

// The actions in ALE's order.
constexpr Motion kMotions[kActions] = {
    {0, false},
    {0, true},
    {kUp, false},
    {kRight, false},
    {kLeft, false},
    {kDown, false},
    {kUp | kRight, false},
    {kUp | kLeft, false},
    {kDown | kRight, false},
    {kDown | kLeft, false},
    {kUp, true},
    {kRight, true},
    {kLeft, true},
    {kDown, true},
    {kUp | kRight, true},
    {kUp | kLeft, true},
    {kDown | kRight, true},
    {kDown | kLeft, true},
};

Motion motion(int action) { return action >= 0 && action < kActions ? kMotions[action] : Motion{0, false}; }

}  // namespace

void Controllers::release_all() const {
    inputs.stick[0] = inputs.stick[1] = 0;
    inputs.fire[0] = inputs.fire[1] = false;
    std::fill_n(inputs.paddle_fire, kMaxPlayers, false);
    // The colour switch is on, RESET and SELECT are up, and the difficulty switches are as set.
    inputs.switches = static_cast<uint8_t>(0x3f | (state.difficulty & 3) << 6);
}

void Controllers::hold(int player, int action, float strength) const {
    if (game.paddles()) {
        move_paddle(player, action, strength);
        inputs.paddle_fire[player] = motion(action).fire;
    } else if (player < 2) {
        inputs.stick[player] = motion(action).stick;
        inputs.fire[player] = motion(action).fire;
    }
}

void Controllers::move_paddle(int player, int action, float strength) const {
    const int delta = static_cast<int>(kPaddleStep * std::abs(static_cast<double>(strength)));
    const uint8_t stick = motion(action).stick;
    const int direction = stick & kRight ? -1 : stick & kLeft ? 1 : 0;
    state.paddle[player] = std::clamp(state.paddle[player] + direction * delta, game.paddle_min, game.paddle_max);
}

void Controllers::connect_paddles() const {
    if (game.paddles()) std::copy_n(state.paddle, kMaxPlayers, inputs.resistance);
}

}  // namespace atari
