// `ReplayPlayer`: plays a replay on a session, frame by frame, and compares its hashes. It goes to any frame by
// checkpoints, and a new recording can go on from there.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "replay_file.hpp"
#include "session.hpp"

namespace atari::web {

class ReplayPlayer {
  public:
    // Throws Refused if the replay is not of this game and ROM, or cannot be played on the page. `game` must be for the
    // replay's number of players.
    ReplayPlayer(std::shared_ptr<const PageGame> game, std::shared_ptr<const ReplayContent> content);

    PlaySession& session() { return *session_; }
    uint32_t frame() const { return now_.frame; }  // frames played so far
    uint32_t frames() const { return content_->frames(); }

    // Plays until the next frame, or for about `budget` frames' time without one: resets and other events take time, too.
    // Throws Refused if an event is impossible.
    enum class Outcome { kFrame, kBusy, kEnd };
    Outcome advance(int budget = 1);
    // Goes to the state after `frame` frames, for about `budget` frames' time. Returns whether it is there; otherwise the
    // same call again goes on.
    bool seek(uint32_t frame, int budget);

    // The first difference from the hashes of the file; empty if there is none so far. All that is played is compared.
    const std::string& difference() const { return difference_; }
    uint32_t differing_frame() const { return differing_frame_; }

    // The action and the strength of the last frame.
    const Actions& actions() const { return actions_; }

    // Returns a player at the start whose session records. `seek` it to `frame`, then take its session, which can take the
    // last frames back.
    std::unique_ptr<ReplayPlayer> recorded(std::string_view package, uint32_t frame) const;
    std::unique_ptr<PlaySession> take_session() { return std::move(session_); }

  private:
    struct Save {
        Bytes state;
        PlaySession::Counters counters;
    };
    struct Position {
        size_t chunk = 0, event = 0;
        uint64_t done = 0;  // frames of the event
        uint32_t frame = 0;
        uint64_t saved = 0;
        std::map<uint64_t, std::shared_ptr<const Save>> saves;  // by number
        std::map<uint64_t, uint64_t> uses;                      // by number: restores of it that are still to come
    };
    struct Checkpoint {
        Position position;
        Bytes state;
        PlaySession::Counters counters;
        Writes::Slots slots;
        std::vector<std::string> episodes;
    };

    std::unique_ptr<PlaySession> make_session() const;
    bool open_chunk();  // opens the chunk of the present event; false after the last
    bool play_frame(const Event& event);
    int run(const Event& event);  // returns about how many frames' time the event takes
    void save();
    void restore(uint64_t number);
    void compare_frame();
    void compare_end();
    void differ(uint32_t frame, const char* what);
    void keep_checkpoint();
    void resume(const Checkpoint& checkpoint);
    void end_episode();

    std::shared_ptr<const PageGame> game_;
    std::shared_ptr<const ReplayContent> content_;
    Options options_;
    std::unique_ptr<PlaySession> session_;
    uint32_t remember_from_ = UINT32_MAX;  // the frame from which the session remembers its states
    Position now_;
    size_t loaded_chunk_ = SIZE_MAX;
    std::vector<Event> events_;  // of the loaded chunk
    std::vector<Checkpoint> checkpoints_;
    uint32_t spacing_ = 960;  // frames between checkpoints
    std::vector<std::string> episodes_;
    std::string difference_;
    uint32_t differing_frame_ = 0;
    Actions actions_{};
};

}  // namespace atari::web
