// `CoreGame`: the game of an episode that is played on a core of Python's, with a function that is called after each
// frame.
//
// A native core is played without the GIL and with its lock held. Where Python is called, the lock is released first,
// and then the GIL is taken: the function may read the core. Another core is played by its methods, with the GIL.
#pragma once

#include <cstdint>
#include <exception>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core_frames.hpp"
#include "vector/played_game.hpp"

namespace atari {

// Returns the integer that Python code has returned. Throws a TypeError that says for what, if it is none.
int integer_of(nb::handle value, const std::string& what);

class CoreGame final : public PlayedGame {
  public:
    CoreGame(int players, CoreFrames frames) : players_(players), frames_(std::move(frames)) {}

    // The Python objects of a call.
    struct Call {
        nb::object core;
        nb::object begin;     // for a reset: begins a game, and returns the core that is played from there on
        nb::object on_frame;  // called after each frame with the action and the reward, or None
    };

    // Calls `work`, which plays on the core of a call. The caller has the GIL; `work` may run without it. Then throws
    // the first error of `on_frame`. After such an error `on_frame` is not called again. A step is played to its end, so
    // that the next step is right. A reset, which may have thousands of frames, ends before its next frame.
    template <typename Work>
    void play(Call call, Work&& work) {
        call_ = std::move(call);
        error_ = nullptr;
        struct Leave {
            CoreGame& game;
            ~Leave() {
                game.leave();
                game.call_ = {};
            }
        };
        {
            const Leave leave{*this};
            enter();
            work();
        }
        if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
    }

    // Calls `work` with the GIL and without the core's lock.
    template <typename Work>
    void with_python(Work&& work) {
        if (!emulator_) return work();
        std::exception_ptr error;
        lock_.unlock();
        released_->with_gil([&] {
            try {
                work();
            } catch (...) {
                error = std::current_exception();
            }
        });
        lock();
        if (error) std::rethrow_exception(error);
    }

    void begin(const uint32_t* seed) override;
    OfPlayers<int> act(const OfPlayers<int>& actions, int players, float strength) override;
    int lives(int player) const override { return emulator_ ? environment_->lives(player) : seen().lives[at(player)]; }
    bool game_over() const override { return emulator_ ? environment_->game_over() : seen().game_over; }
    bool truncated() const override { return emulator_ ? environment_->truncated() : seen().truncated; }
    int frame_number() const override { return emulator_ ? environment_->frame_number() : seen().frame; }
    int episode_frame_number() const override {
        return emulator_ ? environment_->episode_frame_number() : seen().episode_frame;
    }
    const uint8_t* ram() const override;
    void show(ObservationStack& stack) override;

  private:
    // The values that the methods of another core have returned since its last frame.
    struct Seen {
        OfPlayers<int> lives;
        int frame, episode_frame;
        bool game_over, truncated;
    };

    static size_t at(int player) { return static_cast<size_t>(player); }
    void enter();
    void lock() {
        lock_ = emulator_->hold();
        environment_ = &emulator_->environment();
    }
    void leave() {
        if (lock_.owns_lock()) lock_.unlock();
        released_.reset();
        emulator_ = nullptr;
    }
    Emulator* emulator_of(nb::handle core);
    OfPlayers<int> act_by_methods(const OfPlayers<int>& actions, float strength) const;
    OfPlayers<int> numbers_of(nb::handle values, const std::string& what) const;
    nb::object shown(const OfPlayers<int>& values) const;
    const Seen& seen() const;

    const int players_;
    CoreFrames frames_;
    Call call_;
    std::exception_ptr error_;
    nb::object native_type_;  // a type whose frames the emulator plays, from the last call
    Emulator* emulator_ = nullptr;
    Environment* environment_ = nullptr;  // the emulator's, while the lock is held
    std::optional<GilRelease> released_;
    std::unique_lock<Lock> lock_;
    mutable std::optional<Seen> seen_;
    mutable std::vector<uint8_t> ram_;
    std::vector<uint8_t> frame_;  // of another core, while the stack reads it
};

}  // namespace atari
