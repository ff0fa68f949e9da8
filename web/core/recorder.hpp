// `Recorder`: the calls of a play session as the events of a replay. It is kept in memory, so that play that is taken back
// can be removed from it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "replay_file.hpp"

namespace atari::web {

class Recorder {
  public:
    explicit Recorder(std::string header) : header_(std::move(header)) {}

    // Records a frame with `actions`, of one player, or of several as digits in base 18.
    void act(EventKind kind, uint64_t action, float strength, bool played);
    void hash_frame(uint8_t short_hash) { short_hashes_.push_back(short_hash); }
    // To be called after `hash_frame` for each frame of which this is true.
    bool needs_full_hash() const { return short_hashes_.size() % kFramesPerFullHash == 0; }
    void hash_fully(uint32_t hash) { full_hashes_.push_back(hash); }

    void record(EventKind kind, uint64_t first = 0, uint64_t second = 0);
    void load(View snapshot);  // a snapshot is restored, which the file will have
    void add_write(const std::string& definition, bool now);
    void end_episode(std::string summary) { episodes_.push_back(std::move(summary)); }  // JSON

    // A place in the recording, to which `go_back` returns.
    struct Mark {
        size_t events = 0, frames = 0, full = 0, snapshots = 0, writes = 0, episodes = 0;
        uint64_t last_count = 0;  // frames of the last event
    };
    Mark mark() const;
    void go_back(const Mark& mark);

    size_t frames() const { return short_hashes_.size(); }
    // The bytes of the file so far. `last_episode` is the summary of the open episode, or empty.
    Bytes file(const std::string& last_episode, uint32_t check) const;

  private:
    struct Recorded : Event {
        bool played = false;
    };

    std::string header_;
    std::vector<Recorded> events_;
    Bytes short_hashes_;
    std::vector<uint32_t> full_hashes_;
    std::vector<Bytes> snapshots_;
    std::vector<std::string> writes_, episodes_;
};

// The JSON of the end of a replay.
std::string end_of_replay(const std::vector<std::string>& episodes, uint32_t check);

}  // namespace atari::web
