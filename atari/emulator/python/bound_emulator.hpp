// `Emulator`: the class of `_emulator` that plays a game, with the checks of its arguments.
#pragma once

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "ale/environment_parts.hpp"
#include "ale/programs/labels.hpp"
#include "observations/observation_stack.hpp"
#include "arrays.hpp"
#include "state.hpp"
#include "threads.hpp"

namespace atari {

// Returns an integer of Python's, limited to the numbers of Py_ssize_t. Throws a TypeError that begins with `needs`.
inline Py_ssize_t integer_in(nb::handle value, const char* needs) {
    const Py_ssize_t number = PyNumber_AsSsize_t(value.ptr(), nullptr);
    if (number != -1 || !PyErr_Occurred()) return number;
    PyErr_Clear();
    refuse_type(std::string(needs) + ", got " + shown(value));
}

inline int action_number(nb::handle action) {
    const Py_ssize_t number = integer_in(action, "an action is an integer 0..17");
    if (number < 0 || number > 17)
        throw std::invalid_argument("an ALE action number is within 0..17, got " + shown(action));
    return static_cast<int>(number);
}

// Returns a number of frames to play. During a call Ctrl-C waits.
inline int frame_count(nb::handle frames) {
    const Py_ssize_t number = integer_in(frames, "frames must be an integer");
    if (number > 1'000'000) throw std::invalid_argument("frames must be at most 1,000,000, got " + shown(frames));
    return static_cast<int>(std::max<Py_ssize_t>(number, 0));
}

inline double strength_factor(nb::handle strength) {
    const double factor = PyFloat_AsDouble(strength.ptr());
    if (factor == -1.0 && PyErr_Occurred()) {
        PyErr_Clear();
        refuse_type("strength must be a number, got " + shown(strength));
    }
    if (!(std::abs(factor) <= 1000.0))  // negated, so that NaN fails too
        throw std::invalid_argument("strength must be finite and at most 1000 in magnitude, got " + shown(strength));
    return factor;
}

// The core of a game. Every method that emulates or copies framebuffers releases the GIL. Threads may share a core.
class Emulator : Exclusive {
  public:
    const uint64_t number = ++made_;  // unique in the process

    Emulator(const Shared<Game>& game, double probability, int frame_skip, int max_frames, bool sound,
             bool color_averaging, uint32_t seed, bool plain, bool one_generator, bool second_player_starts,
             const std::vector<double>& player_probabilities) {
        if (frame_skip < 1 || frame_skip > kMaxFrameSkip)
            throw std::invalid_argument("frame_skip must be within 1..10000");
        const Settings settings{probability,   frame_skip,           max_frames,          sound, color_averaging, plain,
                                one_generator, second_player_starts, player_probabilities};
        environment_ = std::make_unique<Environment>(game.value, settings, seed);
    }

    template <typename Work>
    auto locked(Work&& work) {
        return Exclusive::locked([&] { return work(open()); });
    }

    template <typename Work>
    auto briefly(Work&& work) {
        return Exclusive::briefly([&] { return work(open()); });
    }

    template <typename Work>
    auto natively(Work&& work) {
        return Exclusive::natively([&] { return work(open()); });
    }

    // For threads that do not have the GIL: the environment, to be used while the lock is held.
    std::unique_lock<Lock> hold() { return Exclusive::hold(); }
    Environment& environment() { return open(); }

    void close() {
        Exclusive::locked([&] { environment_.reset(); });
    }

    nb::bytes save() {
        const auto state = locked([](Environment& e) { return saved(e); });
        return bytes_of(state);
    }

    void load(nb::bytes state) {
        const auto* bytes = static_cast<const uint8_t*>(state.data());
        const size_t size = state.size();
        const bool good = locked([&](Environment& e) { return size == e.state_size() && e.load(bytes); });
        if (!good) throw std::invalid_argument("the state is damaged, or of another game or version");
    }

    State clone_state(bool include_rng) {
        return locked([&](Environment& e) { return State{e.parts().game, include_rng, e.snapshot(), {}, 0}; });
    }

    void restore_state(const State& state) {
        const bool good = locked([&](Environment& e) { return state.restore(e); });
        if (!good)
            throw std::invalid_argument("the state is of another game than this core, or of another kind of core");
    }

    void add_write(const Shared<Write>& write, bool now) {
        if (!locked([&](Environment& e) { return e.parts().add_write(write.value, now); }))
            throw std::invalid_argument(kTooManyWrites);
    }

    int remove_write(const Shared<Write>& write) {
        return locked([&](Environment& e) { return e.parts().remove_write(write.value.get()); });
    }

    using Slots = std::vector<std::optional<Shared<Write>>>;

    Slots writes() {
        const Writes::Slots writes = locked([](Environment& e) { return e.parts().writes.slots(); });
        Slots slots;
        for (const auto& write : writes) slots.push_back(write ? std::optional(Shared<Write>{write}) : std::nullopt);
        return slots;
    }

    void set_writes(const Slots& slots) {
        Writes::Slots writes;
        for (const auto& slot : slots) writes.push_back(slot ? slot->value : nullptr);
        while (!writes.empty() && !writes.back()) writes.pop_back();
        if (writes.size() > kMaxWrites) throw std::invalid_argument(kTooManyWrites);
        locked([&](Environment& e) { e.parts().set_writes(std::move(writes)); });
    }

    // Returns a new array, or `out`, filled by `fill(environment, pointer)`.
    template <typename Fill>
    nb::object filled(const std::vector<size_t>& shape, nb::object out, Fill&& fill) {
        size_t size = 1;
        for (size_t extent : shape) size *= extent;
        if (!out.is_none()) {
            nb::ndarray<uint8_t, nb::c_contig, nb::device::cpu> array;
            bool good = nb::try_cast(out, array, false) && array.ndim() == shape.size();
            for (size_t i = 0; good && i < shape.size(); ++i) good = array.shape(i) == shape[i];
            if (!good) throw std::invalid_argument(expectation(shape));
            const nb::object fixed = prevent_resize(out);
            locked([&](Environment& e) { fill(e, array.data()); });
            return out;
        }
        std::unique_ptr<uint8_t[]> bytes(new uint8_t[size]);
        locked([&](Environment& e) { fill(e, bytes.get()); });
        return array_of(std::move(bytes), shape.data(), shape.size());
    }

    static std::string expectation(const std::vector<size_t>& shape) {
        std::string text = "out must be a writable C-contiguous uint8 array of shape (";
        for (size_t i = 0; i < shape.size(); ++i) text += (i ? ", " : "") + std::to_string(shape[i]);
        return text + (shape.size() == 1 ? ",)" : ")");
    }

    size_t height() {
        return briefly([](Environment& e) { return static_cast<size_t>(e.height()); });
    }

    // Converts the action without nanobind's casters, for less time a frame and for readable errors.
    int act(nb::handle action, nb::handle strength) {
        const int number = action_number(action);
        const double factor = strength_factor(strength);
        return locked([&](Environment& e) { return e.act({number}, 1, static_cast<float>(factor))[0]; });
    }

    // Plays up to `frames` frames. Returns the sum of the rewards, and the number of frames played.
    std::pair<int, int> act_until(nb::handle action, nb::handle frame_limit, nb::handle strength) {
        const int number = action_number(action), frames = frame_count(frame_limit);
        const auto factor = static_cast<float>(strength_factor(strength));
        return locked([&](Environment& e) {
            int reward = 0, played = 0;
            const int lives = e.lives();
            while (played < frames) {
                ++played;
                reward += e.act({number}, 1, factor)[0];
                if (e.game_over() || e.truncated() || e.lives() != lives) break;
            }
            return std::pair(reward, played);
        });
    }

    // Plays `frames` frames, and returns what `AtariEnv.step` returns. After the end of a game no frame is played, but
    // sticky actions draw.
    nb::tuple step(nb::handle action, nb::handle frame_number, nb::handle strength, PixelFormat pixels) {
        const int number = action_number(action), frames = frame_count(frame_number);
        const auto factor = static_cast<float>(strength_factor(strength));
        int64_t reward = 0;
        int lives = 0, frame = 0, episode_frame = 0;
        bool game_over = false, truncated = false;
        size_t shape[] = {0, kScreenWidth, 3};
        std::unique_ptr<uint8_t[]> bytes;
        locked([&](Environment& e) {
            for (int i = 0; i < frames; ++i) reward += e.act({number}, 1, factor)[0];
            shape[0] = pixels == PixelFormat::kRam ? kRamSize : static_cast<size_t>(e.height());
            bytes = seen(e, pixels);
            lives = e.lives(), frame = e.frame_number(), episode_frame = e.episode_frame_number();
            game_over = e.game_over(), truncated = e.truncated();
        });
        nb::dict info;
        info[keys_.lives] = lives;
        info[keys_.episode_frame] = episode_frame;
        info[keys_.frame] = frame;
        const size_t axes = pixels == PixelFormat::kRam ? 1 : pixels == PixelFormat::kRgb ? 3 : 2;
        return nb::make_tuple(array_of(std::move(bytes), shape, axes), static_cast<double>(reward), game_over,
                              truncated, info);
    }

    std::vector<int> act_players(const nb::sequence& actions) {
        std::vector<int> numbers;
        for (nb::handle action : actions) numbers.push_back(action_number(action));
        return locked([&](Environment& e) {
            const int players = static_cast<int>(numbers.size()), most = e.parts().game->players;
            if (players < 1 || players > most)
                throw std::invalid_argument("act_players takes 1 to " + std::to_string(most) +
                                            " actions of this game, got " + std::to_string(players));
            OfPlayers<int> held{};
            std::copy(numbers.begin(), numbers.end(), held.begin());
            const OfPlayers<int> rewards = e.act(held, players);
            return std::vector<int>(rewards.begin(), rewards.begin() + players);
        });
    }

    std::vector<int> player_lives() {
        return briefly([](Environment& e) {
            std::vector<int> lives;
            for (int player = 0; player < e.parts().game->players; ++player) lives.push_back(e.lives(player));
            return lives;
        });
    }

  private:
    static std::unique_ptr<uint8_t[]> seen(Environment& e, PixelFormat pixels) {
        const size_t screen = static_cast<size_t>(e.height()) * kScreenWidth;
        const size_t size = pixels == PixelFormat::kRam ? kRamSize : pixels == PixelFormat::kRgb ? 3 * screen : screen;
        std::unique_ptr<uint8_t[]> bytes(new uint8_t[size]);
        if (pixels == PixelFormat::kRam) std::copy_n(e.ram(), kRamSize, bytes.get());
        else if (pixels == PixelFormat::kRgb) e.screen_rgb(bytes.get());
        else e.screen_gray(bytes.get());
        return bytes;
    }

    Environment& open() {
        if (!environment_) throw std::runtime_error("this core is closed; make a new one, or reset its environment");
        return *environment_;
    }

    inline static std::atomic<uint64_t> made_{0};
    std::unique_ptr<Environment> environment_;
    const InfoKeys keys_;
};

}  // namespace atari
