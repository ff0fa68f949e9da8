// `EpisodeRandom`: the generator of an episode, from which no-ops and frame skips are drawn.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <type_traits>
#include <utility>
#include <variant>

#include "episode_settings.hpp"
#include "machine/random.hpp"
#include "pcg64.hpp"

namespace atari {

struct Seed {
    uint32_t emulator;  // for the emulator's generator: sticky actions
    uint32_t own[8];    // for the episode's generator: the state of NumPy's PCG64; for ALE one word, a seed
};

// Draws the numbers that NumPy's generator draws, or ale-py's vector environment, or a function.
class EpisodeRandom {
  public:
    // Returns a number within low .. high. The function's owner seeds and saves its generator.
    using Draw = std::function<int(int low, int high)>;

    explicit EpisodeRandom(Draw draw) : generator_(std::move(draw)) {}
    EpisodeRandom(Seeding seeding, const Seed& seed) {
        if (seeding == Seeding::kAle) generator_ = MersenneTwister{};
        this->seed(seed);
    }

    void seed(const Seed& seed) {
        if (auto* twister = std::get_if<MersenneTwister>(&generator_)) twister->seed(seed.own[0]);
        else if (auto* pcg = std::get_if<Pcg64>(&generator_)) pcg->set(seed.own);
    }

    // Draws from first .. second. ALE draws a word even if only one number is possible.
    int noops(std::pair<int, int> range) { return draw(range.first, range.second); }
    // Draws from first .. second-1. If only one number is possible, no word is drawn.
    int frames(std::pair<int, int> range) {
        const auto [low, high] = range;
        return high == low + 1 ? low : draw(low, high - 1);
    }

    size_t state_size() const {
        return std::visit(
            [](const auto& generator) { return kHasState<decltype(generator)> ? sizeof generator : size_t{0}; },
            generator_);
    }
    void save(uint8_t* out) const {
        std::visit(
            [&](const auto& generator) {
                if constexpr (kHasState<decltype(generator)>) std::memcpy(out, &generator, sizeof generator);
            },
            generator_);
    }
    void load(const uint8_t* in) {
        std::visit(
            [&](auto& generator) {
                if constexpr (kHasState<decltype(generator)>) {
                    std::memcpy(&generator, in, sizeof generator);
                    make_usable(generator);
                }
            },
            generator_);
    }

  private:
    template <typename Generator>
    static constexpr bool kHasState = !std::is_same_v<std::remove_cvref_t<Generator>, Draw>;

    int draw(int low, int high) {
        if (const auto* function = std::get_if<Draw>(&generator_)) return (*function)(low, high);
        if (auto* twister = std::get_if<MersenneTwister>(&generator_))
            return low + static_cast<int>(twister->below(static_cast<uint32_t>(high - low) + 1));
        return std::get<Pcg64>(generator_).integers(low, high + 1);
    }

    // Repairs a damaged state. An index stays within its array. A generator that repeats one word for ever could make
    // `below` loop for ever.
    static void make_usable(Pcg64& generator) { generator.increment_low |= 1; }
    static void make_usable(MersenneTwister& generator) {
        generator.position = std::min(generator.position, 624u);
        if (std::all_of(generator.words + 1, generator.words + 624, [](uint32_t word) { return word == 0; }))
            generator.words[0] |= 0x80000000u;
    }

    std::variant<Pcg64, MersenneTwister, Draw> generator_;
};

}  // namespace atari
