// Binding of `Causes`: `_emulator.Causes`. Python collects the states and interprets the counts (atari/lab/causal/).

#include <algorithm>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include "lab/causes.hpp"
#include "state.hpp"
#include "arrays.hpp"
#include "threads.hpp"

namespace atari {
namespace {

class CausesBinding : Exclusive {
  public:
    CausesBinding(const Shared<Game>& game, int values, int frames, int threads, uint64_t seed) : game_(game.value) {
        if (threads < 1 || threads > 256) throw std::invalid_argument("threads must be within 1..256");
        const GilRelease release;
        causes_ = std::make_unique<Causes>(game_, values, frames, threads, seed);
    }

    void explore(nb::list states, Table<const uint8_t> actions, int first) {
        std::vector<nb::object> kept;  // the states stay alive without the list
        std::vector<const EnvironmentSnapshot*> snapshots;
        for (nb::handle item : states) {
            kept.push_back(nb::borrow(item));
            const State& state = nb::cast<const State&>(item);
            if (!state.game || image_digest(*state.game) != image_digest(*game_))
                throw std::invalid_argument(
                    "a state is not one that clone_state returned in this process, or of another game");
            snapshots.push_back(&state.snapshot);
        }
        if (actions.shape(0) != kept.size() || actions.shape(1) != static_cast<size_t>(causes_->frames()) || first < 0)
            throw std::invalid_argument("actions must be of shape (states, frames), and first at least 0");
        const std::vector<uint8_t> copy(actions.data(), actions.data() + actions.size());
        for (const uint8_t action : copy)
            if (action > 17) throw std::invalid_argument("an ALE action number is within 0..17");
        const bool good = locked([&] { return causes_->explore(snapshots, copy.data(), first); });
        if (!good) throw std::invalid_argument("a state is of another kind of core");
    }

    nb::object counts() {
        return numbers<uint32_t>([&]() -> const auto& { return causes_->bytes(); }, {0, sizeof(ByteCauses) / 4});
    }
    nb::object effects() {
        return numbers<int32_t>([&]() -> const auto& { return causes_->effects(); }, {0, sizeof(ForkEffect) / 4});
    }
    nb::object pixels() {
        const auto height = static_cast<size_t>(causes_->height());
        return numbers<uint16_t>([&]() -> const auto& { return causes_->pixels(); }, {0, height, kScreenWidth});
    }

    uint64_t frames_played() {
        return locked([&] { return causes_->frames_played(); });
    }

  private:
    // Returns a copy of the numbers in `all()`, in as many rows as there are.
    template <typename Number, typename All>
    nb::object numbers(All&& all, std::vector<size_t> shape) {
        std::unique_ptr<Number[]> copy;
        locked([&] {
            const auto& items = all();
            const size_t bytes = items.size() * sizeof items[0];
            size_t row = sizeof(Number);
            for (size_t axis = 1; axis < shape.size(); ++axis) row *= shape[axis];
            shape[0] = bytes / row;
            copy.reset(new Number[bytes / sizeof(Number)]);
            if (bytes) std::memcpy(copy.get(), items.data(), bytes);
        });
        return array_of(std::move(copy), shape.data(), shape.size());
    }

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
