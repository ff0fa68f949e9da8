#include "core_game.hpp"

#include <cstdint>

#include <stdexcept>
#include <string>

namespace atari {

int integer_of(nb::handle value, const std::string& what) {
    const Py_ssize_t number = PyNumber_AsSsize_t(value.ptr(), nullptr);
    if ((number == -1 && PyErr_Occurred()) || number < INT32_MIN || number > INT32_MAX) {
        PyErr_Clear();
        refuse_type(what + " must be an integer of 32 bits, got " + shown(value));
    }
    return static_cast<int>(number);
}

// Plays by the core of the call, which must not change what a frame is without being asked: a subclass with methods of
// its own is played by them.
void CoreGame::enter() {
    seen_.reset();
    emulator_ = emulator_of(call_.core);
    if (!emulator_) return;
    released_.emplace();
    lock();
    if (environment_->parts().game->players < players_)
        throw std::invalid_argument("the rules of this core's game are not for " + std::to_string(players_) +
                                    " players");
}

// Returns null for a core that Python plays.
Emulator* CoreGame::emulator_of(nb::handle core) {
    Emulator* emulator = nullptr;
    if (!nb::try_cast(core, emulator, false) || !emulator) return nullptr;
    const nb::handle type = core.type();
    if (type.is(native_type_)) return emulator;
    const nb::handle own = nb::type<Emulator>();
    for (const char* name :
         {players_ > 1 ? "act_players" : "act", "lives", "game_over", "truncated", "screen", "ram"}) {
        nb::object method = type.attr(name);
        // `MultiplayerCore` checks the number of actions first.
        if (players_ > 1 && nb::hasattr(method, "__wrapped__")) method = method.attr("__wrapped__");
        if (!method.is(own.attr(name))) return nullptr;
    }
    native_type_ = nb::borrow(type);
    return emulator;
}

void CoreGame::begin(const uint32_t*) {
    leave();
    call_.core = call_.begin();
    enter();
}

OfPlayers<int> CoreGame::act(const OfPlayers<int>& actions, int players, float strength) {
    if (error_ && call_.begin) std::rethrow_exception(std::exchange(error_, nullptr));
    const bool reports = !call_.on_frame.is_none() && !error_;
    const int before = reports ? frame_number() : 0;
    OfPlayers<int> rewards{};
    if (emulator_) rewards = environment_->act(actions, players, strength);
    else rewards = act_by_methods(actions, strength);
    if (!reports || frame_number() == before) return rewards;  // After the end of a game no frame is played.
    with_python([&] {
        try {
            call_.on_frame(shown(actions), shown(rewards));
        } catch (...) {
            error_ = std::current_exception();
        }
    });
    return rewards;
}

OfPlayers<int> CoreGame::act_by_methods(const OfPlayers<int>& actions, float strength) const {
    seen_.reset();
    OfPlayers<int> rewards{};
    if (players_ == 1) {
        rewards[0] = integer_of(call_.core.attr("act")(actions[0], strength), "the reward of the core's act");
        return rewards;
    }
    return numbers_of(call_.core.attr("act_players")(shown(actions)), "the core's act_players");
}

// Returns a number of each player, from a sequence that may have more.
OfPlayers<int> CoreGame::numbers_of(nb::handle values, const std::string& what) const {
    nb::sequence sequence;
    if (!nb::try_cast(values, sequence, false) || nb::len(sequence) < at(players_))
        refuse_type(what + " must have a number of each player, got " + atari::shown(values));
    OfPlayers<int> numbers{};
    for (int player = 0; player < players_; ++player)
        numbers[at(player)] = integer_of(sequence[at(player)], "a number of " + what);
    return numbers;
}

// Returns a number, or the numbers of several players as a tuple.
nb::object CoreGame::shown(const OfPlayers<int>& values) const {
    if (players_ == 1) return nb::int_(values[0]);
    nb::list numbers;
    for (int player = 0; player < players_; ++player) numbers.append(values[at(player)]);
    return nb::tuple(numbers);
}

const CoreGame::Seen& CoreGame::seen() const {
    if (seen_) return *seen_;
    const nb::object& core = call_.core;
    const auto number = [&](const char* name) {
        return integer_of(core.attr(name), std::string("the core's ") + name);
    };
    const auto flag = [&](const char* name) { return nb::cast<bool>(nb::bool_(core.attr(name))); };
    Seen now{{}, number("frame_number"), number("episode_frame_number"), flag("game_over"), flag("truncated")};
    if (players_ == 1) now.lives[0] = number("lives");
    else now.lives = numbers_of(core.attr("player_lives"), "the core's player_lives");
    return seen_.emplace(now);
}

const uint8_t* CoreGame::ram() const {
    if (emulator_) return environment_->ram();
    ram_ = CoreFrames::ram_of(call_.core.attr("ram")());
    return ram_.data();
}

void CoreGame::show(ObservationStack& stack) {
    if (!stack.size()) return;
    if (emulator_) return frames_.read(*environment_, emulator_->number);
    frame_ = frames_.bytes_of(call_.core);
    frames_.read(frame_);
}

}  // namespace atari
