// `_emulator.State`, with the methods of ale-py's `ALEState`.
#include "state.hpp"

#include <algorithm>
#include <cstring>
#include <string>

#include "arrays.hpp"
#include "threads.hpp"

namespace atari {
namespace {

struct Header {
    char magic[8];
    uint32_t version;
    uint32_t include_rng;
    uint64_t image;
};

constexpr char kMagic[8] = {'A', 'T', 'A', 'R', 'I', 'S', 'T', 'A'};

bool same_cartridge(const Game& a, const Game& b) {
    if (&a == &b) return true;
    const Cartridge &first = *a.cartridge, &second = *b.cartridge;
    return first.type() == second.type() && first.size() == second.size() &&
           std::equal(first.image(), first.image() + first.size(), second.image());
}

nb::bytes serialized(const State& state) {
    std::vector<uint8_t> bytes;
    {
        const GilRelease release;
        bytes = state.serialize();
    }
    return bytes_of(bytes);
}

// The bytes after the header are validated when they are restored, because only a game knows their size.
void parse(State* self, nb::bytes serialized) {
    Header header;
    const auto* const data = static_cast<const uint8_t*>(serialized.data());
    if (serialized.size() < sizeof header + sizeof(EnvironmentState))
        throw std::invalid_argument("the state is truncated; pass the bytes that serialize() returned");
    std::memcpy(&header, data, sizeof header);
    if (!std::equal(kMagic, kMagic + sizeof kMagic, header.magic))
        throw std::invalid_argument("these bytes are not a state; pass what serialize() returned");
    if (header.version != kStateVersion)
        throw std::invalid_argument("the state has version " + std::to_string(header.version) +
                                    ", this release reads version " + std::to_string(kStateVersion));
    new (self)
        State{nullptr, header.include_rng != 0, {}, {data + sizeof header, data + serialized.size()}, header.image};
}

bool equal(const State& a, const State& b) {
    const GilRelease release;
    return &a == &b || a.serialize() == b.serialize();
}

}  // namespace

uint64_t image_digest(const Game& game) {
    uint64_t digest = 0xcbf29ce484222325ull;
    const uint8_t* const image = game.cartridge->image();
    for (size_t i = 0; i < game.cartridge->size(); ++i) digest = (digest ^ image[i]) * 0x100000001b3ull;
    return digest;
}

bool State::restore(Environment& environment) const {
    Environment::Parts& parts = environment.parts();
    const MersenneTwister random = parts.state.random;
    const WriteState writes = parts.state.writes;
    if (game) {
        if (!same_cartridge(*game, *parts.game) || !environment.restore(snapshot)) return false;
    } else if (image != image_digest(*parts.game) || bytes.size() != environment.state_size() ||
               !environment.load(bytes.data())) {
        return false;
    }
    if (include_rng) return true;
    parts.state.random = random;
    std::copy_n(writes.random, 2, parts.state.writes.random);
    return true;
}

EnvironmentState State::numbers() const {
    if (game) return snapshot.state;
    EnvironmentState state;
    std::memcpy(&state, bytes.data(), sizeof state);
    return state;
}

std::vector<uint8_t> State::serialize() const {
    const std::vector<uint8_t> body = game ? snapshot.bytes(*game) : bytes;
    Header header{{}, kStateVersion, include_rng, game ? image_digest(*game) : image};
    std::copy_n(kMagic, sizeof kMagic, header.magic);
    std::vector<uint8_t> out(sizeof header + body.size());
    std::memcpy(out.data(), &header, sizeof header);
    std::copy(body.begin(), body.end(), out.begin() + sizeof header);
    if (!include_rng) {
        uint8_t* const state = out.data() + sizeof header;
        std::memset(state + offsetof(EnvironmentState, random), 0, sizeof(MersenneTwister));
        std::memset(state + offsetof(EnvironmentState, writes), 0, sizeof(WriteState::random));
    }
    return out;
}

void register_state(nb::module_& m) {
    m.attr("STATE_VERSION") = kStateVersion;
    const auto number = [](int32_t EnvironmentState::* field) {
        return [field](const State& state) { return state.numbers().*field; };
    };
    const auto itself = [](nb::object state, nb::args) { return state; };
    nb::class_<State>(m, "State",
                      "A state in memory: the result of `Emulator.clone_state`, or read from the bytes of\n"
                      "`serialize`. Immutable. Two states are equal if their bytes of `serialize` are equal.")
        .def("__init__", &parse, "serialized"_a)
        .def("serialize", &serialized, "The state as bytes, for this release and machine.")
        .def("equals", &equal, "other"_a)
        .def("__eq__", &equal, "other"_a, nb::is_operator(), nb::sig("def __eq__(self, other: object) -> bool"))
        .def(
            "__ne__", [](const State& a, const State& b) { return !equal(a, b); }, "other"_a, nb::is_operator(),
            nb::sig("def __ne__(self, other: object) -> bool"))
        .def("__hash__", [](const State&) -> int { refuse_type("unhashable type: 'State'"); })
        .def("__copy__", itself, nb::sig("def __copy__(self) -> State"))
        .def("__deepcopy__", itself, nb::sig("def __deepcopy__(self, memo: object) -> State"))
        .def("__getstate__", &serialized)
        .def("__setstate__", &parse)
        .def("getFrameNumber", number(&EnvironmentState::frame))
        .def("getEpisodeFrameNumber", number(&EnvironmentState::episode_frame))
        .def("getCurrentMode", number(&EnvironmentState::mode))
        .def("getDifficulty", number(&EnvironmentState::difficulty));
}

}  // namespace atari
