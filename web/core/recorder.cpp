#include "recorder.hpp"

#include <algorithm>

namespace atari::web {
namespace {

// Collects events and hashes, and appends them to a file in chunks.
class ChunkWriter {
  public:
    ChunkWriter(Bytes& file, const Bytes& short_hashes, const std::vector<uint32_t>& full_hashes)
        : file_(file), short_hashes_(short_hashes), full_hashes_(full_hashes) {}

    void add(Event event, bool played) {
        uint64_t left = event.acts() ? event.numbers[1] : 0;
        do {
            if (acts_ == kFramesPerChunk || events_.size() == kActsPerChunk) flush();
            if (event.acts()) {
                event.numbers[1] = std::min<uint64_t>(left, kFramesPerChunk - acts_);
                acts_ += event.numbers[1];
                frames_ += played ? event.numbers[1] : 0;
                left -= event.numbers[1];
            }
            events_.push_back(event);
        } while (left > 0);
    }

    void flush() {
        if (events_.empty()) return;
        PlayChunk play{static_cast<uint32_t>(first_), {}, {}, pack_events(events_)};
        const auto part = [](const auto& all, size_t from, size_t to) {
            return std::vector(all.begin() + static_cast<std::ptrdiff_t>(from),
                               all.begin() + static_cast<std::ptrdiff_t>(to));
        };
        play.short_hashes = part(short_hashes_, first_, first_ + frames_);
        play.full_hashes = part(full_hashes_, first_ / kFramesPerFullHash, (first_ + frames_) / kFramesPerFullHash);
        append_chunk(file_, 'P', play.payload());
        first_ += frames_;
        frames_ = acts_ = 0;
        events_.clear();
    }

  private:
    Bytes& file_;
    const Bytes& short_hashes_;
    const std::vector<uint32_t>& full_hashes_;
    std::vector<Event> events_;
    size_t first_ = 0, frames_ = 0;  // frames before this chunk, and of it
    uint64_t acts_ = 0;
};

}  // namespace

void Recorder::act(EventKind kind, uint64_t action, float strength, bool played) {
    std::vector<float> floats;
    if (strength != 1.0f) floats.push_back(strength);
    if (!events_.empty()) {
        Recorded& last = events_.back();
        if (last.kind == kind && last.numbers[0] == action && last.floats == floats && last.played == played &&
            last.numbers[1] < kFramesPerChunk) {
            ++last.numbers[1];
            return;
        }
    }
    events_.push_back({{kind, {action, 1}, std::move(floats)}, played});
}

void Recorder::record(EventKind kind, uint64_t first, uint64_t second) {
    // Two seeds in a row: the first has no effect.
    if (kind == EventKind::kSeed && !events_.empty() && events_.back().kind == EventKind::kSeed) events_.pop_back();
    events_.push_back({{kind, {first, second}}});
}

void Recorder::load(View snapshot) {
    record(EventKind::kLoad, snapshots_.size());
    snapshots_.emplace_back(snapshot.begin(), snapshot.end());
}

void Recorder::add_write(const std::string& definition, bool now) {
    auto place = std::find(writes_.begin(), writes_.end(), definition);
    if (place == writes_.end()) place = writes_.insert(place, definition);
    record(EventKind::kAddWrite, static_cast<uint64_t>(place - writes_.begin()), now);
}

Recorder::Mark Recorder::mark() const {
    return {events_.size(),
            short_hashes_.size(),
            full_hashes_.size(),
            snapshots_.size(),
            writes_.size(),
            episodes_.size(),
            events_.empty() ? 0 : events_.back().numbers[1]};
}

void Recorder::go_back(const Mark& mark) {
    events_.resize(mark.events, {{EventKind::kStep}});
    if (!events_.empty()) events_.back().numbers[1] = mark.last_count;
    short_hashes_.resize(mark.frames);
    full_hashes_.resize(mark.full);
    snapshots_.resize(mark.snapshots);
    writes_.resize(mark.writes);
    episodes_.resize(mark.episodes);
}

Bytes Recorder::file(const std::string& last_episode, uint32_t check) const {
    Bytes file = begin_replay(header_);
    for (const Bytes& snapshot : snapshots_) append_chunk(file, 'S', snapshot);
    for (const std::string& write : writes_) append_chunk(file, 'W', view_of(write));
    ChunkWriter chunks(file, short_hashes_, full_hashes_);
    for (const Recorded& event : events_) chunks.add(event, event.played);
    chunks.flush();
    std::vector<std::string> episodes = episodes_;
    if (!last_episode.empty()) episodes.push_back(last_episode);
    append_chunk(file, 'E', view_of(end_of_replay(episodes, check)));
    return file;
}

std::string end_of_replay(const std::vector<std::string>& episodes, uint32_t check) {
    std::string joined;
    for (const std::string& episode : episodes) joined += (joined.empty() ? "" : ", ") + episode;
    return "{\"check\": " + std::to_string(check) + ", \"episodes\": [" + joined + "]}";
}

}  // namespace atari::web
