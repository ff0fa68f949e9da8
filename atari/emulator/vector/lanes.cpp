#include "lanes.hpp"

#include <algorithm>
#include <map>
#include <stdexcept>
#include <utility>

namespace atari {
namespace {

void check(const LaneSpec& spec, int players, bool own_reward) {
    if (!spec.game) throw std::invalid_argument("each environment needs a game");
    if (spec.game->players < players) throw std::invalid_argument("a game has rules for fewer players");
    for (int action : spec.actions)
        if (action < 0 || action > 17) throw std::invalid_argument("an ALE action number is within 0..17");
    if ((spec.reward != nullptr) != own_reward || (own_reward && players > 1))
        throw std::invalid_argument("all environments, of one player, have a reward of their own, or none has");
}

}  // namespace

StartActions start_actions(const std::vector<int>& begin_actions, const std::vector<int>& actions) {
    const auto has = [&](int action) {
        return std::find(begin_actions.begin(), begin_actions.end(), action) != begin_actions.end();
    };
    StartActions start{has(0), has(1), begin_actions.size() > 2 ? begin_actions[2] : 0, {}};
    if (!actions.empty()) start.idle.fill(actions[0]);
    return start;
}

Seed seed_of(const SeedWords& words) {
    Seed seed{words[0], {}};
    std::copy(words.begin() + 1, words.end(), seed.own);
    return seed;
}

std::vector<std::unique_ptr<Lane>> make_lanes(const std::vector<LaneSpec>& specs, const EpisodeSettings& episode,
                                              const ObservationSettings& observation) {
    episode.check();
    if (observation.stack_num < 1 || observation.stack_num > 10'000)
        throw std::invalid_argument("stack_num must be within 1..10000");
    std::vector<std::unique_ptr<Lane>> lanes;
    std::map<int, std::shared_ptr<const Resizer>> resizers;  // by height of the screen
    std::map<const Game*, const Environment*> twins;         // the first environment of each game
    for (const LaneSpec& spec : specs) {
        check(spec, episode.players, specs[0].reward != nullptr);
        const Environment*& twin = twins[spec.game.get()];
        const Seed seed = seed_of(spec.seed);
        auto environment = std::make_unique<Environment>(spec.game, episode.emulator(), seed.emulator, twin);
        if (!twin) twin = environment.get();
        if (spec.mode) environment->set_mode(*spec.mode);
        if (spec.difficulty) environment->set_difficulty(*spec.difficulty);
        auto& resizer = resizers[environment->height()];
        if (!resizer && observation.pixels != PixelFormat::kNone && observation.pixels != PixelFormat::kRam)
            resizer =
                std::make_shared<const Resizer>(environment->height(), observation.img_height, observation.img_width);
        auto stack = std::make_unique<ObservationStack>(FrameSource(*environment), observation, resizer);
        lanes.push_back(std::make_unique<Lane>(std::move(environment), std::move(stack), episode,
                                               start_actions(spec.action_set, spec.actions), seed, spec.reward,
                                               spec.actions));
    }
    return lanes;
}

}  // namespace atari
