// `_emulator.Episode`: the rules, counters and frames of the episodes that are played on cores of Python's.

#include <algorithm>
#include <array>
#include <atomic>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core_game.hpp"
#include "vector/episode.hpp"
#include "vector/lanes.hpp"

namespace atari {
namespace {

struct Keys : InfoKeys {
    const nb::object reward = key("reward"), steps = key("elapsed_step"), terminated = key("terminated"),
                     out = key("out"), episode = key("episode"), image = key("image"), ram = key("ram");
};

class BoundEpisode {
  public:
    BoundEpisode(const EpisodeSettings& settings, const ObservationSettings& observation, int rows,
                 const std::string& format, bool stacked, bool ram, const std::vector<int>& begin_actions,
                 const std::vector<int>& idle, std::optional<Shared<RewardFormula>> reward, nb::object draw,
                 const std::optional<SeedWords>& words)
        : stacked_(stacked), ram_(ram), draw_(std::move(draw)) {
        settings.check();
        if (static_cast<int>(idle.size()) != settings.players)
            throw std::invalid_argument("there is an idle action of each player");
        for (const auto* actions : {&begin_actions, &idle})
            for (int action : *actions)
                if (action < 0 || action > 17) throw std::invalid_argument("an ALE action number is within 0..17");
        if (reward && settings.players > 1) throw std::invalid_argument("a reward of their own is for one player");
        StartActions start = start_actions(begin_actions, {});
        std::copy(idle.begin(), idle.end(), start.idle.begin());
        auto stack = make_stack(observation, rows, format);
        game_ = std::make_unique<CoreGame>(settings.players, CoreFrames(*stack, format));
        EpisodeRandom random = draw_.is_none() ? EpisodeRandom(settings.seeding, words ? seed_of(*words) : Seed{})
                                               : EpisodeRandom([this](int low, int high) { return drawn(low, high); });
        episode_ = std::make_unique<Episode>(*game_, std::move(stack), settings, start, std::move(random),
                                             reward ? reward->value : nullptr);
    }

    nb::tuple reset(nb::object core, nb::object begin, const std::optional<SeedWords>& words, bool new_game,
                    std::optional<int> noops, bool fire, nb::object on_frame) {
        if (noops && (*noops < 0 || *noops > 1'000'000)) throw std::invalid_argument("noops must be within 0..1000000");
        const std::optional<Seed> seed = words ? std::optional(seed_of(*words)) : std::nullopt;
        const Playing playing(*this);
        Outcome outcome;
        play({std::move(core), std::move(begin), std::move(on_frame)}, [&] {
            episode_->reset(seed ? &*seed : nullptr, new_game, noops, fire);
            outcome.game_steps = episode_->game_steps();
            outcome.game_over = game_->game_over();
            return outcome;
        });
        return nb::make_tuple(observation(), info(outcome));
    }

    nb::tuple step(nb::object core, nb::handle actions, nb::handle strength, nb::object on_frame) {
        const OfPlayers<int> numbers = numbers_of(actions);
        const auto factor = static_cast<float>(strength_factor(strength));
        const Playing playing(*this);
        Outcome outcome;
        play({std::move(core), {}, std::move(on_frame)},
             [&] { return outcome = episode_->step(numbers.data(), factor); });
        return nb::make_tuple(observation(), reward(outcome), outcome.terminated, outcome.limited, info(outcome));
    }

    void go_on(nb::object core, int64_t score, int steps, int first_frame) {
        if (episode_->players() > 1) throw std::invalid_argument("a game of several players cannot be continued");
        const Playing playing(*this);
        play({std::move(core), {}, nb::none()}, [&] {
            episode_->go_on(score, steps, first_frame);
            Outcome outcome;
            outcome.terminated = outcome.game_over = game_->game_over();
            outcome.truncated = game_->truncated();
            outcome.ended = outcome.terminated || outcome.truncated;
            return outcome;
        });
    }

    nb::object& draw() { return draw_; }
    bool ended() const { return now_.outcome.ended; }
    int first_frame() const { return now_.first_frame; }
    size_t generator_offset() const { return 1 + episode_->generator_offset(); }
    nb::object score() const {
        return of_players(now_.score, [](int64_t score) { return nb::int_(score); });
    }
    nb::object present() {
        const Playing playing(*this);
        return observation();
    }
    int steps() const { return now_.steps; }
    nb::tuple out() const {
        nb::list out;
        for (int player = 0; player < episode_->players(); ++player)
            out.append(static_cast<bool>(now_.out >> player & 1));
        return nb::tuple(out);
    }
    nb::bytes save() {
        const Playing playing(*this);
        std::vector<uint8_t> state(1 + episode_->state_size());
        state[0] = now_.outcome.saved();
        episode_->save(state.data() + 1);
        return bytes_of(state);
    }
    void load(nb::bytes state) {
        const Playing playing(*this);
        const uint8_t* const bytes = state_bytes(state, 1 + episode_->state_size(), "episode");
        episode_->load(bytes + 1);
        read_counters(now_);
        now_.outcome = Outcome::of_saved(bytes[0], episode_->players());
    }

  private:
    // Refuses a second call while one is played, of another thread or of a function that the first one calls.
    class Playing {
      public:
        explicit Playing(BoundEpisode& episode) : flag_(episode.playing_) {
            if (flag_.exchange(true)) throw std::runtime_error("this episode is being played; wait for that call");
        }
        Playing(const Playing&) = delete;
        Playing& operator=(const Playing&) = delete;
        ~Playing() { flag_ = false; }

      private:
        std::atomic<bool>& flag_;
    };

    // The values after the last call: a copy, because another thread may read it while an episode is played.
    struct Now {
        OfPlayers<int> lives;
        int frame, episode_frame, steps, first_frame;
        OfPlayers<int64_t> score;
        uint8_t out;
        Outcome outcome;
        std::array<uint8_t, kRamSize> ram;
    };

    // Calls `work`, which plays and returns the outcome.
    template <typename Work>
    void play(CoreGame::Call call, Work&& work) {
        Now now = now_;
        const auto played = [&] {
            now.outcome = work();
            read_counters(now);
            for (int player = 0; player < episode_->players(); ++player)
                now.lives[static_cast<size_t>(player)] = game_->lives(player);
            now.frame = game_->frame_number();
            now.episode_frame = game_->episode_frame_number();
            if (ram_) std::copy_n(episode_->ram(), kRamSize, now.ram.begin());
        };
        try {
            game_->play(std::move(call), played);
        } catch (...) {  // An error of `on_frame` follows the last frame of a step.
            now_ = now;
            throw;
        }
        now_ = now;
    }

    void read_counters(Now& now) const {
        now.steps = episode_->game_steps();
        now.first_frame = episode_->first_frame();
        now.score = episode_->score();
        now.out = episode_->out();
    }

    int drawn(int low, int high) {
        int number = 0;
        game_->with_python([&] { number = integer_of(draw_(low, high + 1), "the number that draw returns"); });
        if (number < low || number > high)
            throw std::invalid_argument("draw must return a number within " + std::to_string(low) + ".." +
                                        std::to_string(high) + ", got " + std::to_string(number));
        return number;
    }

    OfPlayers<int> numbers_of(nb::handle actions) const {
        OfPlayers<int> numbers{};
        if (episode_->players() == 1) {
            numbers[0] = action_number(actions);
            return numbers;
        }
        const auto wrong = [&] {
            return "a step takes a sequence of an action of each of " + std::to_string(episode_->players()) +
                   " players, got " + shown(actions);
        };
        if (!nb::isinstance<nb::sequence>(actions)) refuse_type(wrong());
        const auto given = nb::borrow<nb::sequence>(actions);
        const auto players = static_cast<size_t>(episode_->players());
        if (nb::len(given) != players) throw std::invalid_argument(wrong());
        for (size_t player = 0; player < players; ++player) numbers[player] = action_number(given[player]);
        return numbers;
    }

    // Returns the value of one player, or a tuple of all players' values.
    template <typename T, typename Convert>
    nb::object of_players(const OfPlayers<T>& values, Convert&& convert) const {
        if (episode_->players() == 1) return convert(values[0]);
        nb::list all;
        for (size_t player = 0; player < static_cast<size_t>(episode_->players()); ++player)
            all.append(convert(values[player]));
        return nb::tuple(all);
    }

    nb::object reward(const Outcome& outcome) const {
        if (episode_->has_own_reward()) return nb::float_(outcome.own_reward);
        return of_players(outcome.reward, [](int reward) { return nb::float_(static_cast<double>(reward)); });
    }

    nb::object observation() const {
        const ObservationStack& stack = episode_->observation();
        if (!stack.size()) return ram();
        const nb::object array = observation_of(stack, stacked_, [&](uint8_t* to) { stack.write(to); });
        if (!ram_) return array;
        nb::dict both;
        both[keys_.image] = array;
        both[keys_.ram] = ram();
        return both;
    }

    nb::object ram() const {
        const size_t shape[] = {kRamSize};
        std::unique_ptr<uint8_t[]> bytes(new uint8_t[kRamSize]);
        std::copy_n(now_.ram.begin(), kRamSize, bytes.get());
        return array_of(std::move(bytes), shape, 1);
    }

    nb::dict info(const Outcome& outcome) {
        const auto number = [](int64_t value) { return nb::int_(value); };
        const auto amount = [](int64_t value) { return nb::float_(static_cast<double>(value)); };
        nb::dict info;
        info[keys_.lives] = of_players(now_.lives, number);
        info[keys_.episode_frame] = now_.episode_frame;
        info[keys_.frame] = now_.frame;
        info[keys_.reward] = of_players(outcome.game_reward, amount);
        info[keys_.steps] = outcome.game_steps;
        info[keys_.terminated] = outcome.game_over;
        if (episode_->players() > 1) info[keys_.out] = out();
        if (const auto ended = episode_->take_ended_game()) {
            nb::dict episode;
            episode["r"] = of_players(ended->score, amount);
            episode["l"] = ended->frames;
            episode["t"] = ended->seconds;
            info[keys_.episode] = episode;
        }
        return info;
    }

    const bool stacked_, ram_;
    nb::object draw_;
    const Keys keys_;
    std::unique_ptr<CoreGame> game_;
    std::unique_ptr<Episode> episode_;
    Now now_{};
    std::atomic<bool> playing_ = false;
};

// The garbage collector's view: `draw` may be of an object that has the episode.
int traverse(PyObject* self, visitproc visit, void* arg) {
    Py_VISIT(Py_TYPE(self));
    if (nb::inst_ready(self)) Py_VISIT(nb::inst_ptr<BoundEpisode>(self)->draw().ptr());
    return 0;
}
int clear(PyObject* self) {
    if (nb::inst_ready(self)) nb::inst_ptr<BoundEpisode>(self)->draw() = nb::object();
    return 0;
}
PyType_Slot slots[] = {
    {Py_tp_traverse, reinterpret_cast<void*>(traverse)}, {Py_tp_clear, reinterpret_cast<void*>(clear)}, {0, nullptr}};

}  // namespace

#define INFO "dict[str, typing.Any]"
#define ON_FRAME "on_frame: collections.abc.Callable[[typing.Any, typing.Any], typing.Any] | None = None"

void register_episode(nb::module_& m) {
    nb::class_<BoundEpisode>(
        m, "Episode", nb::type_slots(slots),
        "The rules of episodes, their counters and the agent's stack of frames, as a lane of `VectorEngine` has them.\n"
        "The core that is played is an argument of each call. A core of this package is played in C++, another by its\n"
        "methods.\n\n"
        "`on_frame` is called after each frame with the ALE action and the reward, or tuples of them for several\n"
        "players; it may read the core. After an error in it a step is played to its end without it, and then raises\n"
        "the error; a reset ends. Calls of one episode may not overlap: RuntimeError.")
        .def(nb::init<const EpisodeSettings&, const ObservationSettings&, int, const std::string&, bool, bool,
                      const std::vector<int>&, const std::vector<int>&, std::optional<Shared<RewardFormula>>,
                      nb::object, const std::optional<SeedWords>&>(),
             "settings"_a, "observation"_a, nb::kw_only(), "rows"_a, "format"_a, "stacked"_a = true, "ram"_a = false,
             "begin_actions"_a, "idle"_a, "reward"_a.none() = nb::none(), "draw"_a.none() = nb::none(),
             "seed"_a.none() = nb::none(),
             "`stacked`: observations have an axis for the stack. `ram`: they contain the RAM, alone if there are no\n"
             "pixels, else in a dict of image and ram. `begin_actions` are the actions that begin an episode, `idle`\n"
             "the action of each player who is out. `draw(low, high)` returns a number within low..high-1 in place of\n"
             "the episode's own generator, which `seed`, nine words as in `LaneSpec`, seeds. Raises ValueError if a\n"
             "setting is out of range.")
        .def(
            "reset", &BoundEpisode::reset, "core"_a, "begin"_a, nb::kw_only(), "seed"_a.none() = nb::none(),
            "new_game"_a = false, "noops"_a.none() = nb::none(), "fire"_a = true, "on_frame"_a.none() = nb::none(),
            nb::sig("def reset(self, core: object, begin: collections.abc.Callable[[], typing.Any], *, "
                    "seed: collections.abc.Sequence[int] | None = None, new_game: bool = False, "
                    "noops: int | None = None, fire: bool = True, " ON_FRAME ") -> tuple[typing.Any, " INFO "]"),
            "Begin an episode, and return its observation and info. After a lost life this may continue the game, but\n"
            "not with a seed or `new_game`. `begin()` begins a game and returns the core that is played from there\n"
            "on. `seed` is nine words, as in `LaneSpec`; `noops` is the number of no-ops in place of a drawn one.")
        .def(
            "step", &BoundEpisode::step, "core"_a, "actions"_a, "strength"_a = 1.0, "on_frame"_a.none() = nb::none(),
            nb::sig("def step(self, core: object, actions: int | collections.abc.Sequence[int], strength: float = "
                    "1.0, " ON_FRAME ") -> tuple[typing.Any, typing.Any, bool, bool, " INFO "]"),
            "Play an ALE action number, or one of each player. Returns observation, reward, terminated, truncated and\n"
            "info; the rewards of several players are a tuple. A step may both lose a life that is reported and be\n"
            "truncated.")
        .def(
            "go_on", &BoundEpisode::go_on, "core"_a, "score"_a, "steps"_a, "first_frame"_a,
            "Continue a game of one player that a core has played; the stack begins anew. `first_frame` is the core's\n"
            "episode frame number after its reset.")
        .def_prop_ro("observation", &BoundEpisode::present, nb::sig("def observation(self, /) -> typing.Any"),
                     "The present observation; zeros before the first reset.")
        .def_prop_ro("steps", &BoundEpisode::steps, "The steps of the present game.")
        .def_prop_ro("first_frame", &BoundEpisode::first_frame,
                     "The core's episode frame number after the reset that began the present game.")
        .def_prop_ro("generator_offset", &BoundEpisode::generator_offset,
                     "The place in `save` at which the state of a lane has a generator, and is otherwise equal.")
        .def_prop_ro("out", &BoundEpisode::out, nb::sig("def out(self, /) -> tuple[bool, ...]"),
                     "Whether each player is out of the present game.")
        .def_prop_ro("ended", &BoundEpisode::ended,
                     "Whether the last step ended the episode. A lost life that is only reported does not.")
        .def_prop_ro("score", &BoundEpisode::score, nb::sig("def score(self, /) -> typing.Any"),
                     "The sum of the rewards of the present game, no-ops included.")
        .def("save", &BoundEpisode::save, "The state without the core's, as bytes.")
        .def("load", &BoundEpisode::load, "state"_a,
             "Continue from `save` of an episode with the same settings; ValueError if the bytes have another length.");
}

}  // namespace atari
