// Binding of `Causes`: `_emulator.Causes`. Python collects the states and interprets the counts (atari/lab/causal/).
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "lab/causes.hpp"
#include "state.hpp"
#include "threads.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace atari {
namespace {

template <typename Item>
nb::object as_array(std::vector<Item>&& items, const std::vector<size_t>& shape) {
    auto* const owned = new std::vector<Item>(std::move(items));
    nb::capsule owner(owned, [](void* memory) noexcept { delete static_cast<std::vector<Item>*>(memory); });
    return nb::cast(nb::ndarray<nb::numpy, Item, nb::c_contig>(owned->data(), shape.size(), shape.data(), owner));
}

class CausesBinding : Exclusive {
  public:
    CausesBinding(const Shared<Game>& game, int values, int frames, int threads, uint64_t seed) : game_(game.value) {
        if (threads < 1 || threads > 256) throw std::invalid_argument("threads must be within 1..256");
        const GilRelease release;
        causes_ = std::make_unique<Causes>(game_, values, frames, threads, seed);
    }

    void explore(nb::list states, nb::ndarray<const uint8_t, nb::ndim<2>, nb::c_contig, nb::device::cpu> actions,
                 int first) {
        std::vector<nb::object> kept;  // the states stay alive without the list
        std::vector<const EnvironmentSnapshot*> snapshots;
        for (nb::handle item : states) {
            kept.push_back(nb::borrow(item));
            const State& state = nb::cast<const State&>(item);
            if (!state.game || image_digest(*state.game) != image_digest(*game_))
                throw nb::value_error(
                    "a state is not one that clone_state returned in this process, or of another game");
            snapshots.push_back(&state.snapshot);
        }
        if (actions.shape(0) != kept.size() || actions.shape(1) != static_cast<size_t>(causes_->frames()) || first < 0)
            throw nb::value_error("actions must be of shape (states, frames), and first at least 0");
        const std::vector<uint8_t> copy(actions.data(), actions.data() + actions.size());
        for (const uint8_t action : copy)
            if (action > 17) throw nb::value_error("an ALE action number is within 0..17");
        const bool good = locked([&] { return causes_->explore(snapshots, copy.data(), first); });
        if (!good) throw nb::value_error("a state is of another kind of core");
    }

    nb::object counts() {
        std::vector<uint32_t> numbers(sizeof(ByteCauses) / sizeof(uint32_t) * kRamBytes);
        locked([&] {
            const auto* const from = reinterpret_cast<const uint32_t*>(causes_->bytes().data());
            std::copy_n(from, numbers.size(), numbers.begin());
            return 0;
        });
        return as_array(std::move(numbers), {kRamBytes, sizeof(ByteCauses) / sizeof(uint32_t)});
    }

    nb::object effects() {
        std::vector<int32_t> numbers;
        locked([&] {
            const auto* const from = reinterpret_cast<const int32_t*>(causes_->effects().data());
            numbers.assign(from, from + causes_->effects().size() * kForkEffectNumbers);
            return 0;
        });
        const size_t rows = numbers.size() / kForkEffectNumbers;
        return as_array(std::move(numbers), {rows, static_cast<size_t>(kForkEffectNumbers)});
    }

    nb::object pixels() {
        auto numbers = locked([&] { return causes_->pixels(); });
        return as_array(std::move(numbers), {kRamBytes, static_cast<size_t>(causes_->height()), kScreenWidth});
    }

    uint64_t frames_played() {
        return locked([&] { return causes_->frames_played(); });
    }

  private:
    std::shared_ptr<const Game> game_;
    std::unique_ptr<Causes> causes_;
};

}  // namespace

void register_causes(nb::module_& m) {
    nb::class_<CausesBinding>(m, "Causes", "The effects of each byte of RAM; see emulator/lab/causes.hpp.")
        .def(nb::init<const Shared<Game>&, int, int, int, uint64_t>(), nb::kw_only(), "game"_a, "values"_a, "frames"_a,
             "threads"_a, "seed"_a)
        .def(
            "explore", &CausesBinding::explore, "states"_a, "actions"_a, "first"_a,
            nb::sig("def explore(self, states: list[State], actions: numpy.typing.NDArray[numpy.uint8], first: int) -> "
                    "None"),
            "Count the effects of changes of each byte from these states, with the actions of each state's frames.")
        .def("counts", &CausesBinding::counts, nb::sig("def counts(self) -> numpy.typing.NDArray[numpy.uint32]"),
             "The fields of `ByteCauses`, a row for each byte.")
        .def("effects", &CausesBinding::effects, nb::sig("def effects(self) -> numpy.typing.NDArray[numpy.int32]"),
             "The fields of `ForkEffect`, a row for each fork with an effect.")
        .def("pixels", &CausesBinding::pixels, nb::sig("def pixels(self) -> numpy.typing.NDArray[numpy.uint16]"),
             "(128, height, 160): the number of forks of a byte that changed a pixel.")
        .def_prop_ro("frames_played", &CausesBinding::frames_played);
}

}  // namespace atari
