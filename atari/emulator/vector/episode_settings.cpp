#include "episode_settings.hpp"

#include <stdexcept>
#include <string>

namespace atari {

namespace {

void check_range(const std::string& name, EpisodeSettings::Range range, int most) {
    if (range.first < 0 || range.second < range.first || range.second > most)
        throw std::invalid_argument(name + " must be within 0.." + std::to_string(most) +
                                    ", the first not above the second");
}

}  // namespace

void EpisodeSettings::check() const {
    const auto [low, high] = frameskip;
    if (low < 1 || high <= low || high > kMaxFrameSkip + 1)
        throw std::invalid_argument("frameskip must be within 1..10000, the first below the second");
#define SETTING(...)
#define RANGE(name, first, second, most) check_range(#name, name, most);
#include "episode_settings.def"
    for (const auto& limit : {max_frames, max_episode_steps, max_num_frames_per_episode})
        if (limit && *limit < 1) throw std::invalid_argument("a limit is 1 or more; leave it out for none");
    if (fire_unit == Unit::kSkip && fire == FirePress::kBeforeNoops)
        throw std::invalid_argument("whole skips of FIRE follow the no-ops");
    if (seamless_lives && (fire_unit == Unit::kSkip || lives_unit == Unit::kSkip))
        throw std::invalid_argument("seamless lives are those of single frames");
    if (players < 1 || players > kMaxPlayers) throw std::invalid_argument("there are 1 to 4 players");
    if (players > 1 && (fire != FirePress::kNever || fire_counts || episodic_life || life_loss_info))
        throw std::invalid_argument("FIRE and lost lives are settings of one player");
}

Settings EpisodeSettings::emulator() const {
    Settings settings{repeat_action_probability, 1, max_num_frames_per_episode.value_or(0)};
    settings.one_generator = settings.second_player_starts = players > 1;
    return settings;
}

}  // namespace atari
