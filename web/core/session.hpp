// `PlaySession`: a game in play on the page, with its writes, its recording and the states to which it can go back.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ale/environment.hpp"
#include "game_text.hpp"
#include "options.hpp"
#include "recorder.hpp"
#include "rewind.hpp"

namespace atari::web {

using Actions = std::array<int, 2>;  // of the players

class PlaySession {
  public:
    // Throws Refused if the options do not fit the game.
    PlaySession(std::shared_ptr<const PageGame> game, Options options);

    const PageGame& game() const { return *game_; }
    Environment& environment() { return environment_; }
    int players() const { return game_->players; }

    void seed(uint32_t seed);
    void reset();  // throws if the mode cannot be selected
    // Plays a frame, and returns whether one was played: none is after the end of the game. Throws Refused for an unknown
    // action, or a strength beyond 1000.
    bool act(const Actions& actions, float strength = 1.0f);
    // Chooses the mode (kMode) or the difficulty (kDifficulty) of a game of one player. Throws Refused if it has no such.
    void choose(EventKind kind, int64_t value);
    void poke(int64_t index, int64_t value);
    // Adds a write of a definition, in JSON, and returns its slot. With `now`, it is also applied at once.
    int add_write(const std::string& definition, bool now);
    void remove_write(uint64_t slot);

    int64_t score(int player = 0) const { return counters_.score[static_cast<size_t>(player)]; }
    int reward(int player = 0) const { return rewards_[static_cast<size_t>(player)]; }
    bool game_over() const { return environment_.game_over(); }
    bool truncated() const { return environment_.truncated(); }

    // The screen as RGBA, height() x 160 pixels.
    void screen_rgba(uint8_t* out);
    // The screen that `frames` more frames with these actions would show. The session does not change.
    void screen_ahead(const Actions& actions, int frames, uint8_t* out);

    Bytes snapshot();  // as `NativeCore.snapshot`
    void restore(View snapshot, bool any_sound = false);

    // The states of the frames that can be taken back, newest last.
    void remember();  // keeps the present state
    bool go_back();   // to the newest kept state, which is dropped; false if there is none
    size_t remembered() const { return states_.size(); }
    void set_budget(size_t bytes) { states_.set_budget(bytes); }

    // Records from now on, in place of an earlier recording. In the middle of a game the recording begins with a snapshot,
    // and the score with 0. `package` is the release for the header.
    void start_recording(std::string_view package);
    Bytes replay();  // the recording so far; throws Refused without one

    // The hashes of replays.
    uint8_t short_hash();
    uint32_t full_hash();
    // Episodes, as replays count them.
    std::string episode_summary();  // JSON; empty if no episode has begun
    void end_episode();
    // States in memory that belong to this session alone, for replays.
    struct Counters {
        std::array<int64_t, kMaxPlayers> score{};
        bool in_episode = false;
    };
    const Counters& counters() const { return counters_; }
    void resume(View state, const Counters& counters, Writes::Slots slots);
    // A state is taken to which `return_to` will go on from; both are events of the recording.
    void record_save();
    void return_to(View state, const Counters& counters, uint64_t number);
    Bytes state();
    Writes::Slots slots();

  private:
    struct Place {
        Counters counters;
        Recorder::Mark mark;
        Writes::Slots slots;
    };

    static uint32_t usable_seed(uint32_t seed, int players);
    std::string facts() { return facts_of(*game_, options_, environment_.mode()); }
    void load(View state);

    std::shared_ptr<const PageGame> game_;
    Options options_;
    Environment environment_;
    Counters counters_;
    bool fresh_ = true;  // nothing has been called since the construction
    OfPlayers<int> rewards_{};
    std::vector<uint8_t> framebuffer_;
    std::array<std::array<uint8_t, 4>, 256> rgba_{};  // by index of the palette
    std::optional<Recorder> recorder_;
    Rewind<Place> states_;
};

}  // namespace atari::web
