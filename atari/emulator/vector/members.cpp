#include "members.hpp"

#include <algorithm>
#include <map>
#include <stdexcept>
#include <utility>

namespace atari {
namespace {

void check(const EpisodeSettings& episode, const ObservationSettings& observation) {
    const auto [low, high] = episode.frame_skip;
    if (observation.stack < 1 || observation.stack > 10'000 || low < 1 || high <= low || high > kMaxFrameSkip + 1 ||
        episode.noops.first < 0 || episode.noops.second < episode.noops.first || episode.noops.second > 1'000'000)
        throw std::invalid_argument("stack, frame_skip or noops is out of range");
    if (episode.players < 1 || episode.players > kMaxPlayers ||
        (episode.players > 1) != (episode.kind == EpisodeKind::kMultiplayer))
        throw std::invalid_argument("players are 2 to 4 for MULTIPLAYER, otherwise 1");
}

void check(const MemberSpec& spec, const ObservationSettings& observation, int players) {
    if (!spec.game) throw std::invalid_argument("each environment needs a game");
    if (spec.game->players < players) throw std::invalid_argument("a game has rules for fewer players");
    for (int action : spec.actions)
        if (action < 0 || action > 17) throw std::invalid_argument("an ALE action number is within 0..17");
    if (observation.pixels == PixelFormat::kGrayOfRgb && !spec.gray_of_pairs)
        throw std::invalid_argument("gray of RGB needs the gray values of pairs of colours");
}

template <typename... Arguments>
std::unique_ptr<Episode> make_episode(EpisodeKind kind, Arguments&&... arguments) {
    switch (kind) {
        case EpisodeKind::kFrames: return std::make_unique<FrameEpisode>(std::forward<Arguments>(arguments)...);
        case EpisodeKind::kBaselines: return std::make_unique<BaselinesEpisode>(std::forward<Arguments>(arguments)...);
        case EpisodeKind::kMultiplayer:
            return std::make_unique<MultiplayerEpisode>(std::forward<Arguments>(arguments)...);
        case EpisodeKind::kAle: break;
    }
    return std::make_unique<AleEpisode>(std::forward<Arguments>(arguments)...);
}

StartActions start_actions(const std::vector<int>& actions, const std::vector<int>& action_set) {
    const auto has = [&](int action) {
        return std::find(action_set.begin(), action_set.end(), action) != action_set.end();
    };
    return {has(0), has(1), action_set.size() > 2 ? action_set[2] : 0, actions.empty() ? 0 : actions[0]};
}

}  // namespace

Seed seed_of(const SeedWords& words) {
    Seed seed{words[0], {}};
    std::copy(words.begin() + 1, words.end(), seed.own);
    return seed;
}

std::vector<VectorEngine::Member> make_members(const std::vector<MemberSpec>& specs, const EpisodeSettings& episode,
                                               const ObservationSettings& observation) {
    check(episode, observation);
    std::vector<VectorEngine::Member> members;
    std::map<int, std::shared_ptr<const Resizer>> resizers;  // by height of the screen
    std::map<const Game*, const Environment*> twins;         // the first environment of each game
    for (const MemberSpec& spec : specs) {
        check(spec, observation, episode.players);
        const Environment*& twin = twins[spec.game.get()];
        const Seed seed = seed_of(spec.seed);
        auto environment = std::make_unique<Environment>(spec.game, episode.emulator(), seed.emulator, twin);
        if (!twin) twin = environment.get();
        if (spec.mode) environment->set_mode(*spec.mode);
        if (spec.difficulty) environment->set_difficulty(*spec.difficulty);
        auto& resizer = resizers[environment->height()];
        if (!resizer && observation.pixels != PixelFormat::kNone)
            resizer = std::make_shared<const Resizer>(environment->height(), observation.height, observation.width);
        auto stack = std::make_unique<ObservationStack>(*environment, observation, resizer, spec.gray_of_pairs);
        members.push_back({make_episode(episode.kind, std::move(environment), std::move(stack), episode,
                                        start_actions(spec.actions, spec.action_set), seed),
                           spec.actions});
    }
    return members;
}

}  // namespace atari
