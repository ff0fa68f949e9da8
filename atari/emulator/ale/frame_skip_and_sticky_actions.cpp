// `Environment::act`: frame skip, sticky actions, legal actions and rewards, as in ALE.
#include <algorithm>

#include "environment_parts.hpp"

namespace atari {

OfPlayers<int> Environment::Parts::act(const OfPlayers<int>& actions, int players, float strength) {
    OfPlayers<int64_t> total{};
    for (int i = 0; i < settings.frame_skip; ++i) {
        draw_sticky_actions(actions, players, strength);
        if (game_over() || truncated()) continue;
        int32_t legal[kMaxPlayers];
        for (int player = 0; player < players; ++player) {
            const int held = state.held_action[player];
            legal[player] = held < kActions && (game->legal_actions >> held & 1) ? held : 0;
        }
        play_actions(legal, players, players == 1 ? state.held_strength : 1.0f);
        count_frame();
        for (size_t player = 0; player < static_cast<size_t>(std::min(players, game->players)); ++player)
            total[player] += state.variables[game->rewards[player]];
    }
    if (settings.sound) console->make_samples(state.audio);
    OfPlayers<int> rewards{};
    for (size_t player = 0; player < kMaxPlayers; ++player)
        rewards[player] = static_cast<int>(std::clamp<int64_t>(total[player], INT32_MIN, INT32_MAX));
    return rewards;
}

// ALE draws a word for each player in each frame, also after the end: for two players if there is one.
void Environment::Parts::draw_sticky_actions(const OfPlayers<int>& actions, int players, float strength) {
    for (int player = 0; player < std::max(players, 2); ++player) {
        const double draw = state.random.next() / 4294967296.0;
        if (player >= players || draw < settings.probability(player)) continue;
        state.held_action[player] = actions[static_cast<size_t>(player)];
        if (players == 1) state.held_strength = strength;
    }
}

}  // namespace atari
