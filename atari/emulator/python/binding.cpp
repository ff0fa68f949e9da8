// The extension module atari._emulator: thin bindings of `Environment`. Python validates the options
// (atari/cores/native.py). This file also validates arguments that could cause undefined behaviour.
//
// No Python object is released without the GIL. A thread with the GIL waits for no lock and joins no thread.
// threads.hpp has the whole rule, and the classes that keep it.

#include <algorithm>
#include <exception>
#include <memory>
#include <stdexcept>

#include "ale/environment.hpp"
#include "bound_emulator.hpp"
#include "fast/jit/switch.hpp"
#include "fast/simd.hpp"
#include "threads.hpp"

namespace atari {
namespace {

// A method of `Environment`, bound as one of `Emulator`.
template <typename... Arguments>
auto call(void (Environment::*method)(Arguments...)) {
    return [method](Emulator& emulator, Arguments... arguments) {
        emulator.locked([&](Environment& e) { (e.*method)(arguments...); });
    };
}

nb::object colours_of(const std::string& format) {
    const Palette& palette = palette_of(format);
    const size_t shape[] = {256, 3};
    std::unique_ptr<uint8_t[]> colours(new uint8_t[256 * 3]);
    for (size_t i = 0; i < 256; ++i)
        for (size_t channel = 0; channel < 3; ++channel)
            colours[3 * i + channel] = static_cast<uint8_t>(palette.rgb[i] >> (16 - 8 * channel));
    return array_of(std::move(colours), shape, 2);
}

Shared<Game> bound_game(nb::bytes image, const std::string& cartridge, const std::string& format, bool detect_format,
                        int first_line, int height, bool hmove_blanks, std::pair<bool, bool> paddles, bool swap_ports,
                        bool swap_paddles, std::pair<int, int> paddle_range, int power_on_switches,
                        const std::vector<int>& legal_actions, const std::vector<int>& starting_actions,
                        int default_mode, int variables, const std::vector<int32_t>& initial,
                        const std::vector<bool>& kept, const std::vector<int>& outputs,
                        const std::vector<int32_t>& step, const std::vector<int32_t>& select_mode) {
    GameDefinition game;
    const auto* bytes = static_cast<const uint8_t*>(image.data());
    game.image.assign(bytes, bytes + image.size());
    game.cartridge = cartridge;
    game.format = format;
    game.detect_format = detect_format;
    game.first_line = first_line;
    game.height = height;
    game.hmove_blanks = hmove_blanks;
    game.paddles[0] = paddles.first;
    game.paddles[1] = paddles.second;
    game.swap_ports = swap_ports;
    game.swap_paddles = swap_paddles;
    game.power_on_switches = static_cast<uint8_t>(power_on_switches);
    game.paddle_min = paddle_range.first;
    game.paddle_max = paddle_range.second;
    game.set_legal_actions(legal_actions);
    game.starting_actions = starting_actions;
    game.default_mode = default_mode;
    game.variables = variables;
    game.initial = initial;
    game.kept.assign(kept.begin(), kept.end());
    game.set_outputs(outputs);
    game.step = step;
    game.select_mode = select_mode;
    return {make_game(game)};
}

}  // namespace

void register_state(nb::module_& m);         // state.cpp
void register_episode(nb::module_& m);       // binding_episode.cpp
void register_observations(nb::module_& m);  // binding_observations.cpp
void register_image(nb::module_& m);         // binding_image.cpp
void register_vector(nb::module_& m);        // binding_vector.cpp
void register_memory(nb::module_& m);        // binding_memory.cpp
void register_causes(nb::module_& m);        // binding_causes.cpp
void register_labels(nb::module_& m);        // binding_labels.cpp
void register_reward(nb::module_& m);        // binding_reward.cpp
void register_writes(nb::module_& m);        // binding_writes.cpp
void register_xla(nb::module_& m);           // binding_xla.cpp

}  // namespace atari

#define RETURNS_ARRAY(name) "def " name "(self, out: " NDARRAY("uint8") " | None = None) -> " NDARRAY("uint8")

NB_MODULE(_emulator, m) {
    using namespace atari;
    // Types can be registered once in a process. An import after a deletion from `sys.modules` shares the first
    // module's types.
    static nb::object* const first = new nb::object(m);
    if (!first->is(m)) {
        nb::borrow<nb::dict>(m.attr("__dict__")).update(nb::borrow<nb::dict>(first->attr("__dict__")));
        return;
    }
    // Another library or the program itself may hold objects until the interpreter has ended: these are no leak of this
    // package, and its users can do nothing about nanobind's messages. tests/base/test_ends_of_programs.py turns them on.
    nb::set_leak_warnings(false);
    m.def(
        "report_leaks", [] { nb::set_leak_warnings(true); },
        "Print the objects that still exist when the interpreter has ended.");
    count_forks();
    static_cast<void>(std::current_exception());  // allocates this thread's memory for exceptions (thread_pool.cpp)
    m.attr("END") = static_cast<int>(Op::kEnd);
    m.doc() =
        "The binding of the native emulator. Use it through atari.cores.NativeCore, which checks options and\n"
        "finds ROMs.";

    nb::class_<Shared<Game>>(m, "Game", "A game, compiled: cartridge, console, rules. Immutable; emulators share it.")
        .def_prop_ro(
            "cartridge_type", [](const Shared<Game>& game) { return game.value->cartridge->type_name(); },
            "The bank switching, given or recognised, such as \"F8\".");

    m.def(
        "simd_level",
        [] {
            check_simd_level();
            return name_of(simd_level());
        },
        "The level of SIMD instructions that is used. Raises ValueError if the environment variable ATARI_SIMD is wrong.");
    m.def("make_game", &bound_game, nb::kw_only(), "image"_a, "cartridge"_a, "format"_a, "detect_format"_a,
          "first_line"_a, "height"_a, "hmove_blanks"_a, "paddles"_a, "swap_ports"_a, "swap_paddles"_a, "paddle_range"_a,
          "power_on_switches"_a, "legal_actions"_a, "starting_actions"_a, "default_mode"_a, "variables"_a, "initial"_a,
          "kept"_a, "outputs"_a, "step"_a, "select_mode"_a,
          "Check and assemble a game; raises ValueError if the image or a rule program is not sound.");

    register_state(m);
    register_writes(m);

    const auto array = [](auto method, bool colour) {
        return [method, colour](Emulator& emulator, nb::object out) {
            const size_t height = emulator.height();
            const auto shape =
                colour ? std::vector<size_t>{height, kScreenWidth, 3} : std::vector<size_t>{height, kScreenWidth};
            return emulator.filled(shape, out, [method](Environment& e, uint8_t* to) { (e.*method)(to); });
        };
    };
    const auto number = [](auto getter) {
        return [getter](Emulator& emulator) {
            return emulator.briefly([getter](Environment& e) { return (e.*getter)(); });
        };
    };

    nb::class_<Emulator>(m, "Emulator", "A running game. It releases Python's interpreter lock while it emulates.")
        .def(nb::init<const Shared<Game>&, double, int, int, bool, bool, uint32_t, bool, bool, bool,
                      const std::vector<double>&>(),
             nb::kw_only(), "game"_a, "repeat_action_probability"_a, "frame_skip"_a, "max_num_frames_per_episode"_a,
             "sound"_a, "color_averaging"_a, "seed"_a, "plain"_a = false, "one_generator"_a = false,
             "second_player_starts"_a = false, "player_probabilities"_a = std::vector<double>{},
             "`plain`: the plain interpreter and TIA play, which are slower and give the same results.")
        .def("seed", call(&Environment::seed), "seed"_a)
        .def("reset", call(&Environment::reset))
        .def("act", &Emulator::act, "action"_a.none(), "strength"_a.none() = 1.0,
             nb::sig("def act(self, action: int, strength: float = 1.0) -> int"))
        .def("act_until", &Emulator::act_until, "action"_a.none(), "frames"_a.none(), "strength"_a.none() = 1.0,
             nb::sig("def act_until(self, action: int, frames: int, strength: float = 1.0) -> tuple[int, int]"),
             "Play until the game is over or truncated or the number of lives changes, but at most `frames` frames;\n"
             "1,000,000 is the most. Returns the sum of the rewards and the number of frames played.")
        .def("step", &Emulator::step, "action"_a.none(), "frames"_a.none(), "strength"_a.none(), "pixels"_a,
             nb::sig("def step(self, action: int, frames: int, strength: float, pixels: PixelFormat) -> "
                     "tuple[numpy.typing.NDArray[numpy.uint8], float, bool, bool, dict[str, int]]"),
             "Play frames; returns the screen (RGB, GRAY) or the RAM, the reward, game_over, truncated and info.")
        .def("act_players", &Emulator::act_players, "actions"_a,
             nb::sig("def act_players(self, actions: collections.abc.Sequence[int]) -> list[int]"),
             "Hold an action for each of the first players; returns a reward for each.")
        .def_prop_ro("player_lives", &Emulator::player_lives, "The lives of each player that the rules know.")
        .def_prop_ro("mode", number(&Environment::mode))
        .def_prop_ro("difficulty", number(&Environment::difficulty))
        .def("set_mode", call(&Environment::set_mode), "mode"_a)
        .def("set_difficulty", call(&Environment::set_difficulty), "difficulty"_a)
        .def_prop_ro("lives", [](Emulator& x) { return x.briefly([](Environment& e) { return e.lives(); }); })
        .def_prop_ro("game_over", number(&Environment::game_over))
        .def_prop_ro("truncated", number(&Environment::truncated))
        .def_prop_ro("frame_number", number(&Environment::frame_number))
        .def_prop_ro("episode_frame_number", number(&Environment::episode_frame_number))
        .def(
            "ram",
            [](Emulator& x, nb::object out) {
                return x.filled({128}, out, [](Environment& e, uint8_t* to) { std::copy_n(e.ram(), 128, to); });
            },
            "out"_a = nb::none(), nb::sig(RETURNS_ARRAY("ram")))
        .def(
            "audio",
            [](Emulator& x, nb::object out) {
                return x.filled({kAudioSamples}, out,
                                [](Environment& e, uint8_t* to) { std::copy_n(e.audio(), kAudioSamples, to); });
            },
            "out"_a = nb::none(), nb::sig(RETURNS_ARRAY("audio")))
        .def("screen", array(&Environment::screen, false), "out"_a = nb::none(), nb::sig(RETURNS_ARRAY("screen")))
        .def("screen_rgb", array(&Environment::screen_rgb, true), "out"_a = nb::none(),
             nb::sig(RETURNS_ARRAY("screen_rgb")))
        .def("screen_grayscale", array(&Environment::screen_gray, false), "out"_a = nb::none(),
             nb::sig(RETURNS_ARRAY("screen_grayscale")))
        .def(
            "set_ram",
            [](Emulator& x, int index, int value) {
                if (index < 0 || index > 127) throw std::invalid_argument("index must be within 0..127");
                if (value < 0 || value > 255) throw std::invalid_argument("value must be within 0..255");
                x.locked([&](Environment& e) { e.set_ram(index, value); });
            },
            "index"_a, "value"_a)
        .def("redraw", array(&Environment::redraw, true), "out"_a = nb::none(), nb::sig(RETURNS_ARRAY("redraw")))
        .def("add_write", &Emulator::add_write, "write"_a, "now"_a = false,
             "Apply a write at each later frame, and with `now` at once; ValueError if there are MOST_WRITES.")
        .def("remove_write", &Emulator::remove_write, "write"_a, "End a write; returns its slot, or -1.")
        .def_prop_rw("writes", &Emulator::writes, &Emulator::set_writes,
                     "The writes by slot; None for a slot whose write has ended. They are applied in this order.")
        .def("save", &Emulator::save, "The whole state as bytes, in the layout of this build.")
        .def("load", &Emulator::load, "state"_a, "Continue from `save`; ValueError if the bytes cannot be a state.")
        .def("clone_state", &Emulator::clone_state, "include_rng"_a = false,
             "The whole state in memory; `include_rng` says whether the state includes the generator.")
        .def("restore_state", &Emulator::restore_state, "state"_a,
             "Continue from a state of `clone_state`; ValueError if the state belongs to another game or core.")
        .def("close", &Emulator::close);

    m.def("palette", &colours_of, "format"_a, nb::sig("def palette(format: str) -> " NDARRAY("uint8")),
          "Red, green and blue of the 256 palette indices of a TV format, (256, 3).");
    m.def("translator", &translator, nb::sig("def translator() -> str | None"),
          "The processor for which cartridges are translated, \"x86-64\" or \"arm64\"; None if handlers run all code.\n"
          "Raises ValueError if the environment variable ATARI_JIT is wrong.");

    register_reward(m);
    register_vector(m);
    register_image(m);
    register_observations(m);
    register_episode(m);
    register_xla(m);
    register_memory(m);
    register_causes(m);
    register_labels(m);
}
