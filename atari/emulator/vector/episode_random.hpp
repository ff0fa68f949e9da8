// `EpisodeRandom`: the generator of an episode, from which no-ops and frame skips are drawn.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>
#include <variant>

#include "episode_settings.hpp"
#include "machine/random.hpp"
#include "pcg64.hpp"

namespace atari {

struct Seed {
    uint32_t emulator;  // of the emulator's generator: sticky actions
    uint32_t own[8];    // of the episode's generator: the state of NumPy's PCG64; for ALE one word, a seed
};

// Draws as NumPy's generator does, or as ale-py's vector environment does.
class EpisodeRandom {
  public:
    EpisodeRandom(Seeding seeding, const Seed& seed) {
        if (seeding == Seeding::kAle) generator_ = MersenneTwister{};
        this->seed(seed);
    }

    void seed(const Seed& seed) {
        if (auto* twister = std::get_if<MersenneTwister>(&generator_)) twister->seed(seed.own[0]);
        else std::get<Pcg64>(generator_).set(seed.own);
    }

    // From first .. second. ALE draws a word also if only one number is possible.
    int noops(std::pair<int, int> range) { return draw(range.first, range.second); }
    // From first .. second-1; draws nothing if only one number is possible.
    int frames(std::pair<int, int> range) {
        const auto [low, high] = range;
        return high == low + 1 ? low : draw(low, high - 1);
    }

    size_t state_size() const {
        return std::visit([](const auto& generator) { return sizeof generator; }, generator_);
    }
    void save(uint8_t* out) const {
        std::visit([&](const auto& generator) { std::memcpy(out, &generator, sizeof generator); }, generator_);
    }
    void load(const uint8_t* in) {
        std::visit(
            [&](auto& generator) {
                std::memcpy(&generator, in, sizeof generator);
                make_usable(generator);
            },
            generator_);
    }

  private:
    int draw(int low, int high) {
        if (auto* twister = std::get_if<MersenneTwister>(&generator_))
            return low + static_cast<int>(twister->below(static_cast<uint32_t>(high - low) + 1));
        return std::get<Pcg64>(generator_).integers(low, high + 1);
    }

    // A damaged state neither indexes other memory nor gives the same word for ever, which would be drawn again for ever.
    static void make_usable(Pcg64& generator) { generator.increment_low |= 1; }
    static void make_usable(MersenneTwister& generator) {
        generator.position = std::min(generator.position, 624u);
        if (std::all_of(generator.words + 1, generator.words + 624, [](uint32_t word) { return word == 0; }))
            generator.words[0] |= 0x80000000u;
    }

    std::variant<Pcg64, MersenneTwister> generator_;
};

}  // namespace atari
