#include "replay_player.hpp"

#include <algorithm>
#include <utility>

namespace atari::web {
namespace {

constexpr uint32_t kMostRemembered = 3600;  // frames: a minute
constexpr size_t kMostSaves = 512, kMostCheckpoints = 256;
constexpr int kFramesOfReset = 70;  // a load and a reset play about as many
constexpr uint64_t kActionCount = 18;

// The options of a session that plays as the core of a header.
Json session_options(const Json& header, int64_t players) {
    const Json* const options = header.find("options");
    if (!options || options->kind != Json::Kind::kObject)
        throw Refused("the replay is damaged: its header has no options");
    Json chosen;
    chosen.kind = Json::Kind::kObject;
    for (const char* const name : {"repeat_action_probability", "mode", "difficulty", "max_num_frames_per_episode"})
        if (const Json* const value = options->find(name)) chosen.items.emplace_back(name, *value);
    if (players == 1) {
        if (const Json* const value = options->find("interventions"))
            chosen.items.emplace_back("interventions", *value);
        return chosen;
    }
    if (const Json* const value = options->find("seed")) chosen.items.emplace_back("seed", *value);
    const std::pair<const char*, const char*> played[] = {{"parameters", "{}"},
                                                          {"corrected_scores", "false"},
                                                          {"mode_numbers", "\"multi_agent_ale\""},
                                                          {"end_of_reset", "\"multi_agent_ale\""},
                                                          {"random_words", "\"multi_agent_ale\""}};
    for (const auto& [name, value] : played)
        if (const Json* const own = options->find(name); !own || own->canonical() != value)
            throw Refused(std::string("the page plays replays of several players with ") + name + " = " + value +
                          " only");
    return chosen;
}

}  // namespace

ReplayPlayer::ReplayPlayer(std::shared_ptr<const PageGame> game, std::shared_ptr<const ReplayContent> content)
    : game_(std::move(game)), content_(std::move(content)) {
    const Json& header = content_->header;
    if (const std::string& id = header.text_of("game", "the header"); id != game_->id)
        throw Refused("the replay is of " + id + ", not of " + game_->id);
    if (const std::string& rom = header.text_of("rom", "the header"); rom != game_->rom_md5)
        throw Refused("the replay was recorded with a ROM of MD5 " + rom + ", but this ROM has " + game_->rom_md5);
    if (content_->players() != game_->players)
        throw Refused("the replay is of " + std::to_string(content_->players()) + " players");
    options_ = read_options(session_options(header, game_->players), *game_);
    for (const PlayChunk& play : content_->plays)
        for (const Event& event : unpack_events(play.events))
            if (event.kind == EventKind::kRestore) ++now_.uses[event.numbers[0]];
    session_ = make_session();
    keep_checkpoint();
}

std::unique_ptr<PlaySession> ReplayPlayer::make_session() const {
    return std::make_unique<PlaySession>(game_, options_);
}

bool ReplayPlayer::open_chunk() {
    for (;;) {
        if (now_.chunk == content_->plays.size()) return false;
        const PlayChunk& play = content_->plays[now_.chunk];
        if (loaded_chunk_ != now_.chunk) {
            events_ = unpack_events(play.events);
            loaded_chunk_ = now_.chunk;
        }
        if (now_.event < events_.size()) return true;
        if (now_.frame < play.first + play.short_hashes.size()) differ(now_.frame, "that the game is over");
        ++now_.chunk;
        now_.event = 0;
        if (now_.frame >= checkpoints_.back().position.frame + spacing_) keep_checkpoint();
    }
}

ReplayPlayer::Outcome ReplayPlayer::advance(int budget) {
    while (open_chunk()) {
        const Event& event = events_[now_.event];
        if (event.acts() && now_.done < event.numbers[1]) {
            ++now_.done;
            if (play_frame(event)) return Outcome::kFrame;
            --budget;
        } else {
            budget -= event.acts() ? 1 : run(event);
            ++now_.event;
            now_.done = 0;
        }
        if (budget <= 0) return Outcome::kBusy;
    }
    compare_end();
    return Outcome::kEnd;
}

bool ReplayPlayer::seek(uint32_t frame, int budget) {
    frame = std::min(frame, frames());
    const auto later = std::find_if(checkpoints_.begin(), checkpoints_.end(),
                                    [&](const Checkpoint& one) { return one.position.frame > frame; });
    const Checkpoint& nearest = *(later - 1);  // the first is of frame 0
    if (frame < now_.frame || nearest.position.frame > now_.frame) resume(nearest);
    while (now_.frame < frame) {
        if (budget <= 0) return false;
        const int frames_before = static_cast<int>(now_.frame);
        if (advance(budget) == Outcome::kEnd) return true;
        budget -= std::max(1, static_cast<int>(now_.frame) - frames_before);
    }
    return true;
}

bool ReplayPlayer::play_frame(const Event& event) {
    const bool several = game_->players > 1;
    if (several != (event.kind == EventKind::kActions)) throw Refused("the action is for another number of players");
    const uint64_t word = event.numbers[0];
    if (several && word >= kActionCount * kActionCount)
        throw Refused("the replay has actions of more than two players");
    if (now_.frame >= remember_from_) session_->remember();
    actions_ = {static_cast<int>(word % kActionCount), static_cast<int>(word / kActionCount)};
    if (!session_->act(actions_, event.floats.empty() ? 1.0f : event.floats.front())) return false;
    ++now_.frame;
    compare_frame();
    return true;
}

int ReplayPlayer::run(const Event& event) {
    const auto [first, second] = event.numbers;
    const auto integer = [](uint64_t number) { return static_cast<int64_t>(number); };
    switch (event.kind) {
        case EventKind::kReset:
            end_episode();
            session_->reset();
            return kFramesOfReset;
        case EventKind::kSeed:
            if (first > UINT32_MAX) throw Refused("the replay has a seed of more than 32 bits");
            end_episode();
            session_->seed(static_cast<uint32_t>(first));
            return kFramesOfReset;
        case EventKind::kPoke: session_->poke(integer(first), integer(second)); break;
        case EventKind::kSave: save(); break;
        case EventKind::kRestore: restore(first); break;
        case EventKind::kLoad:
            if (first >= content_->snapshots.size())
                throw Refused("the replay has no snapshot " + std::to_string(first));
            session_->restore(content_->snapshots[first], true);
            break;
        case EventKind::kMode:
        case EventKind::kDifficulty: session_->choose(event.kind, integer(first)); break;
        case EventKind::kAddWrite:
            if (first >= content_->writes.size()) throw Refused("the replay has no write " + std::to_string(first));
            session_->add_write(content_->writes[first], second != 0);
            break;
        case EventKind::kRemoveWrite: session_->remove_write(first); break;
        case EventKind::kContinuousAction:
            if (game_->players > 1) throw Refused("replays of several players have no such event");
            break;
        default: break;
    }
    return 1;
}

void ReplayPlayer::save() {
    const uint64_t number = now_.saved++;
    session_->record_save();
    if (!now_.uses.contains(number)) return;
    if (now_.saves.size() == kMostSaves) throw Refused("the replay goes back to more states than the page keeps");
    now_.saves[number] = std::make_shared<const Save>(Save{session_->state(), session_->counters()});
}

void ReplayPlayer::restore(uint64_t number) {
    const auto place = now_.saves.find(number);
    if (place == now_.saves.end()) throw Refused("the replay has saved no state " + std::to_string(number));
    session_->return_to(place->second->state, {place->second->counters.score, true}, number);
    if (--now_.uses[number] == 0) now_.saves.erase(place);
}

void ReplayPlayer::compare_frame() {
    const PlayChunk& play = content_->plays[now_.chunk];
    const size_t place = now_.frame - play.first - 1;
    if (place >= play.short_hashes.size()) return differ(now_.frame - 1, "that the game goes on");
    if (session_->short_hash() != play.short_hashes[place]) return differ(now_.frame - 1, "RAM");
    if (now_.frame % kFramesPerFullHash != 0) return;
    const size_t number = now_.frame / kFramesPerFullHash - play.first / kFramesPerFullHash - 1;
    if (session_->full_hash() != play.full_hashes[number]) differ(now_.frame - 1, "RAM, screen, reward, lives or end");
}

void ReplayPlayer::compare_end() {
    if (!content_->end || !difference_.empty()) return;
    std::vector<std::string> episodes = episodes_;
    if (const std::string last = session_->episode_summary(); !last.empty()) episodes.push_back(last);
    if (content_->end->canonical() != end_of_replay(episodes, session_->full_hash()))
        differ(now_.frame ? now_.frame - 1 : 0, "how it ends");
}

void ReplayPlayer::differ(uint32_t frame, const char* what) {
    if (!difference_.empty() && differing_frame_ <= frame) return;
    difference_ = what;
    differing_frame_ = frame;
}

void ReplayPlayer::end_episode() {
    if (const std::string summary = session_->episode_summary(); !summary.empty()) episodes_.push_back(summary);
}

void ReplayPlayer::keep_checkpoint() {
    checkpoints_.push_back({now_, session_->state(), session_->counters(), session_->slots(), episodes_});
    if (checkpoints_.size() < kMostCheckpoints) return;
    // Every second one is enough for a replay this long.
    size_t kept = 0;
    for (size_t i = 0; i < checkpoints_.size(); i += 2) std::swap(checkpoints_[kept++], checkpoints_[i]);
    checkpoints_.resize(kept);
    spacing_ *= 2;
}

void ReplayPlayer::resume(const Checkpoint& checkpoint) {
    session_->resume(checkpoint.state, checkpoint.counters, checkpoint.slots);
    now_ = checkpoint.position;
    episodes_ = checkpoint.episodes;
}

std::unique_ptr<ReplayPlayer> ReplayPlayer::recorded(std::string_view package, uint32_t frame) const {
    auto player = std::make_unique<ReplayPlayer>(game_, content_);
    player->session_->start_recording(package);
    player->remember_from_ = frame - std::min(frame, kMostRemembered);
    return player;
}

}  // namespace atari::web
