// `PlayedGame`: what an `Episode` is played on. The rules of an episode need no more of a game than this.
#pragma once

#include <cstdint>

#include "ale/environment_parts.hpp"

namespace atari {

class ObservationStack;

class PlayedGame {
  public:
    virtual ~PlayedGame() = default;
    // Begins a game, after seeding the emulator if `seed` is not null.
    virtual void begin(const uint32_t* seed) = 0;
    virtual OfPlayers<int> act(const OfPlayers<int>& actions, int players, float strength) = 0;
    virtual int lives(int player) const = 0;
    int lives() const { return lives(0); }
    virtual bool game_over() const = 0;
    virtual bool truncated() const = 0;
    virtual int frame_number() const = 0;
    virtual int episode_frame_number() const = 0;
    virtual const uint8_t* ram() const = 0;
    // Called before the stack reads the present frame or RAM: a game whose frames are not an environment's passes them.
    virtual void show(ObservationStack&) {}
};

}  // namespace atari
