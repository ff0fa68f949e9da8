// `Causes` counts the effects of each byte of RAM. In given states of a game, every byte is changed to several values.
// A fork with the changed byte is played for some frames beside an unchanged twin with the same actions and the same
// random words. Differences of screen, RAM, reward, lives and game over are effects of the change.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "ale/environment.hpp"

namespace atari {

inline constexpr int kRamBytes = 128, kMostForkFrames = 60, kMostForkValues = 64;

// Numbers of forks by their outcome. `_COUNTS` in atari/lab/causal/explore.py names the same fields in this order.
struct ByteCauses {
    uint32_t forks = 0;
    uint32_t vanished = 0;   // the byte was rewritten in the first frame, and nothing else ever differed
    uint32_t inert = 0;      // the byte stayed different to the end, and nothing else ever differed
    uint32_t rewritten = 0;  // the byte had the twin's value after the first frame
    uint32_t seen = 0;       // pixels differed
    uint32_t rewarded = 0, lives = 0, over = 0;  // reward, lives or game over differed
    uint32_t seen_at[kMostForkFrames] = {};      // pixels differed first in this frame
    uint32_t writes[kRamBytes] = {};             // the other byte differed after the first frame
    uint32_t later[kRamBytes] = {};              // the other byte differed after any frame
};

// A fork with a visible effect, or an effect on reward or lives. Differences are the fork's value less the twin's.
struct ForkEffect {
    int32_t state, byte, old_value, new_value;
    int32_t old_then, new_then;                // the byte in twin and fork after frame `frame`
    int32_t frame;                             // 1 ..: pixels differed first in this frame; 0: never
    int32_t left, top, right, bottom, pixels;  // the box of these pixels, inclusive, and their number
    // `dx`, `dy`: the shift that maps the twin's pixels to the fork's, or 0. `..._score`: the percentage of pixels that
    // it explains. `unbalanced`: the percentage of pixels whose colour has no counterpart, which is small if something
    // moves.
    int32_t dx, dx_score, dy, dy_score, unbalanced;
    int32_t reward, lives;              // in the first frame
    int32_t reward_later, lives_later;  // over all frames; after the last one
    int32_t over;                       // the fork's game was over, and the twin's was not
};
inline constexpr int kForkEffectNumbers = sizeof(ForkEffect) / sizeof(int32_t);

class Causes {
  public:
    // Each byte of each state gets `values` forks, which last at most `frames` frames and are played by `threads`
    // threads.
    Causes(std::shared_ptr<const Game> game, int values, int frames, int threads, uint64_t seed);
    ~Causes();

    // Explores states `first` .. `first + states.size() - 1`. `actions` has `frames` actions a state. The result does
    // not depend on the number of threads, nor on how the states are divided into calls. Returns false, and counts
    // nothing, if a state is of another kind of console.
    bool explore(const std::vector<const EnvironmentSnapshot*>& states, const uint8_t* actions, int first);

    int height() const { return height_; }
    int frames() const { return frames_; }
    uint64_t frames_played() const;
    const std::vector<ByteCauses>& bytes() const { return bytes_; }
    const std::vector<ForkEffect>& effects() const { return effects_; }
    // The number of forks of each byte that changed a pixel: 128 x height x 160.
    const std::vector<uint16_t>& pixels() const { return pixels_; }

  private:
    class Worker;

    const int values_, frames_, height_;
    const uint64_t seed_;
    std::vector<std::unique_ptr<Worker>> workers_;
    std::vector<ByteCauses> bytes_;
    std::vector<ForkEffect> effects_;
    std::vector<uint16_t> pixels_;
};

}  // namespace atari
