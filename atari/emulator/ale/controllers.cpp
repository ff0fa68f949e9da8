#include "controllers.hpp"

#include <algorithm>
#include <cmath>

namespace atari {
namespace {

constexpr double kPaddleStep = 23000.0;  // ohms a frame
enum Stick : uint8_t { kUp = 1, kDown = 2, kLeft = 4, kRight = 8 };

// The actions in ALE's order: nothing, FIRE, eight directions, and the same directions with FIRE.
constexpr uint8_t kSticks[] = {
    0, 0, kUp, kRight, kLeft, kDown, kUp | kRight, kUp | kLeft, kDown | kRight, kDown | kLeft};
constexpr int kDirections = 8, kFirstWithFire = 10;
static_assert(kFirstWithFire + kDirections == kActions);

uint8_t stick_of(int action) {
    if (action < 0 || action >= kActions) return 0;
    return kSticks[action < kFirstWithFire ? action : action - kDirections];
}

bool fires(int action) { return action == 1 || (action >= kFirstWithFire && action < kActions); }

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
        inputs.paddle_fire[player] = fires(action);
    } else if (player < 2) {
        inputs.stick[player] = stick_of(action);
        inputs.fire[player] = fires(action);
    }
}

void Controllers::move_paddle(int player, int action, float strength) const {
    const int delta = static_cast<int>(kPaddleStep * std::abs(static_cast<double>(strength)));
    const uint8_t stick = stick_of(action);
    const int direction = stick & kRight ? -1 : stick & kLeft ? 1 : 0;
    state.paddle[player] = std::clamp(state.paddle[player] + direction * delta, game.paddle_min, game.paddle_max);
}

void Controllers::connect_paddles() const {
    if (game.paddles()) std::copy_n(state.paddle, kMaxPlayers, inputs.resistance);
}

}  // namespace atari
