// `_emulator.VectorEngine` and `_emulator.Batch`: the vector environment, bound for atari/vector, which validates
// options. threads.hpp has the rule for locks and the GIL.

#include <initializer_list>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "bound_emulator.hpp"
#include "bound_engine.hpp"
#include "call_lock.hpp"
#include "state.hpp"
#include "threads.hpp"

namespace atari {
namespace {

uint8_t* observations_of(BoundBatch& batch, nb::object array, size_t size, const char* what) {
    if (array.is_none()) return nullptr;
    uint8_t* const values = values_of<uint8_t>(array, size, what);
    batch.observations.push_back(array);
    batch.observations.push_back(prevent_resize(array));
    return values;
}

void set_observations(BoundBatch& batch, nb::object pixels, nb::object ram) {
    batch.batch.pixels = observations_of(batch, pixels, batch.shape.rows * batch.shape.pixels, "pixels");
    batch.batch.ram = observations_of(batch, ram, batch.shape.rows * batch.shape.ram, "ram");
}

void make_batch(BoundBatch* self, BoundEngine& engine, nb::object pixels, nb::object ram, size_t steps) {
    BoundBatch bound{{}, engine.shape(!pixels.is_none(), !ram.is_none()), {}, std::make_shared<BatchMemory>()};
    if (steps < 1 || steps > BoundEngine::kMostSteps) throw std::invalid_argument("steps is out of range");
    bound.shape.rows *= steps;
    set_observations(bound, pixels, ram);
    bound.memory->complete(bound.batch, bound.shape);
    new (self) BoundBatch(std::move(bound));
}

// Returns a batch with these arrays of observations. It shares all other arrays with `batch`.
BoundBatch aimed_at(const BoundBatch& batch, nb::object pixels, nb::object ram) {
    BoundBatch bound{batch.batch, batch.shape, {}, batch.memory};
    set_observations(bound, pixels, ram);
    return bound;
}

// Returns the batch's own arrays by name.
nb::dict arrays_of(const BoundBatch& bound) {
    nb::dict arrays;
    Batch::for_each(bound.shape, [&](const char* name, auto member, size_t width) {
        if constexpr (std::is_same_v<decltype(member), uint8_t* Batch::*>)
            if (member == &Batch::pixels || member == &Batch::ram) return;
        using Owner = std::shared_ptr<BatchMemory>;
        const nb::capsule owner(new Owner(bound.memory), [](void* kept) noexcept { delete static_cast<Owner*>(kept); });
        const size_t sizes[] = {bound.shape.rows, width};
        arrays[name] = array_over(bound.batch.*member, sizes, width == 1 ? 1 : 2, owner);
    });
    return arrays;
}

// Returns an array over a part of a sequence.
template <typename T>
nb::object array_over_part(const BoundSequence& bound, std::vector<T>& part, std::initializer_list<size_t> shape) {
    using Owner = std::shared_ptr<Sequence>;
    const nb::capsule owner(new Owner(bound.sequence), [](void* kept) noexcept { delete static_cast<Owner*>(kept); });
    return array_over(part.data(), shape.begin(), shape.size(), owner);
}

// Returns the discounted sums of the rewards, the numbers of steps played, and the RAMs.
nb::tuple results_of(const BoundSequence& bound) {
    Sequence& sequence = *bound.sequence;
    const auto [_, lanes, players] = bound;
    return nb::make_tuple(players == 1 ? array_over_part(bound, sequence.rewards, {lanes})
                                       : array_over_part(bound, sequence.rewards, {lanes, players}),
                          array_over_part(bound, sequence.played, {lanes}),
                          sequence.every
                              ? array_over_part(bound, sequence.rams, {lanes, sequence.steps, size_t{kRamSize}})
                              : array_over_part(bound, sequence.rams, {lanes, size_t{kRamSize}}));
}

uint64_t digest_of(Emulator& core) {
    return core.locked([](Environment& e) { return image_digest(*e.parts().game); });
}

struct LentArray {
    Values<uint8_t> rows;
    nb::object fixed;  // see `prevent_resize`
};

// A share in the memory of an array. It exports that memory by the buffer protocol, so a NumPy array made from it owns
// the share, and so do the array's views and tensors. This is faster than nb::ndarray with a capsule as its owner,
// which matters in steps of one environment.
struct Loan {
    std::shared_ptr<LentArray> array;
};

int export_loan(PyObject* object, Py_buffer* view, int flags) {
    if (!nb::inst_ready(object)) {  // made by `Loan.__new__`
        view->obj = nullptr;
        PyErr_SetString(PyExc_BufferError, "this loan is of no array; ArrayLender.lend makes one");
        return -1;
    }
    const Values<uint8_t>& rows = nb::inst_ptr<Loan>(object)->array->rows;
    return PyBuffer_FillInfo(view, object, rows.data(), static_cast<Py_ssize_t>(rows.size()), 0, flags);
}

PyType_Slot kLoanSlots[] = {{Py_bf_getbuffer, reinterpret_cast<void*>(export_loan)}, {0, nullptr}};

// Lends the memory of an array without a copy. After all loans have ended, the memory may be written again. A loan
// keeps the memory alive after the lender is destroyed. Loans end with the GIL held.
class ArrayLender {
  public:
    explicit ArrayLender(nb::object array) : array_(std::make_shared<LentArray>()) {
        if (!nb::try_cast(array, array_->rows, false)) refuse_type("a writable C-contiguous uint8 array is needed");
        array_->fixed = prevent_resize(array);
    }
    Loan lend() const { return {array_}; }
    bool lent() const { return array_.use_count() > 1; }

  private:
    std::shared_ptr<LentArray> array_;
};

void make_engine(BoundEngine* self, const std::vector<const LaneSpec*>& lanes, EpisodeSettings episode,
                 ObservationSettings observation, VectorSettings settings) {
    std::vector<LaneSpec> specs;
    for (const LaneSpec* lane : lanes) specs.push_back(lane ? *lane : LaneSpec{});
    if (settings.batch_size < 1 || static_cast<size_t>(settings.batch_size) > specs.size() || settings.threads < 1)
        throw std::invalid_argument("batch_size or threads is out of range");
    auto engine = [&] {
        const GilRelease release;
        return std::make_unique<VectorEngine>(make_lanes(specs, episode, observation), settings);
    }();
    new (self) BoundEngine(std::move(engine));
}

}  // namespace

void register_settings(nb::module_& m);         // binding_settings.cpp
void register_vector_ram(EngineClass& engine);  // binding_vector_ram.cpp

// A method of `Environment`, bound as one of `VectorEngine` with the number of the environment.
template <auto method, typename... Arguments>
auto call(BoundEngine& engine, int environment, Arguments... arguments) {
    return engine.get(environment, [&](Environment& e) { return (e.*method)(arguments...); });
}

void register_vector(nb::module_& m) {
    register_settings(m);
    nb::enum_<VectorEngine::RamOf>(
        m, "RamOf",
        "The present RAM, the RAM of the last result, or the RAM of the result before a reset in the\n"
        "last step.")
        .value("NOW", VectorEngine::RamOf::kNow)
        .value("RESULT", VectorEngine::RamOf::kResult)
        .value("FINAL", VectorEngine::RamOf::kFinal);
    nb::class_<BoundBatch> batch(m, "Batch",
                                 "Arrays for the results of a batch. Threads write to them between start and receive.");
    batch.def("__init__", &make_batch, "engine"_a, "pixels"_a.none(), "ram"_a.none(), "steps"_a = 1,
              nb::sig("def __init__(self, engine: VectorEngine, pixels: " NDARRAY("uint8") " | None, ram: " NDARRAY(
                  "uint8") " | None, steps: int = 1) -> None"),
              "`pixels` and `ram` are the arrays for observations; None if observations have no such part. There is a\n"
              "row for each of `steps` of each environment of a batch.");
    batch.def_prop_ro("arrays", &arrays_of, nb::sig("def arrays(self) -> dict[str, numpy.typing.NDArray[typing.Any]]"),
                      "The other arrays by their names (vector/batch.def): (rows,), or (rows, players) if each\n"
                      "player has a value. Final pixels and RAM are (rows, bytes).");
    batch.def(
        "aimed_at", &aimed_at, "pixels"_a.none(), "ram"_a.none(),
        nb::sig("def aimed_at(self, pixels: " NDARRAY("uint8") " | None, ram: " NDARRAY("uint8") " | None) -> Batch"),
        "A batch with other arrays of observations, which shares the other arrays.");
    nb::class_<BoundSequence>(m, "StepSequence", "Several steps of each environment, which `VectorEngine.play` begins.")
        .def_prop_ro(
            "results", &results_of,
            nb::sig("def results(self) -> tuple[" NDARRAY("float64") ", " NDARRAY("int32") ", " NDARRAY("uint8") "]"),
            "After `receive`, for all environments: the discounted sums of the rewards, (environments,) or\n"
            "(environments, players), the numbers of steps played, (environments,), and the RAMs after the\n"
            "last step, (environments, 128), or after every step, (environments, steps, 128).");
    nb::class_<BoundSnapshot>(m, "MemberSnapshot", "The state of a lane in memory. It can be pickled.")
        .def_static(
            "of_bytes",
            [](Emulator& core, nb::bytes state) {
                const auto* const data = static_cast<const uint8_t*>(state.data());
                return BoundSnapshot{nullptr, {data, data + state.size()}, digest_of(core)};
            },
            "core"_a, "state"_a, "The snapshot of these bytes of `content`, of the game of a core.")
        .def(
            "content",
            [](const BoundSnapshot& state, Emulator& core) {
                if (digest_of(core) != (state.snapshot ? image_digest(*state.snapshot->game) : state.image))
                    throw std::invalid_argument("the snapshot was taken with another ROM image of the game");
                return bytes_of(state.snapshot ? state.snapshot->bytes() : state.bytes);
            },
            "core"_a, "The state as bytes. Raises ValueError if a core of its game has another ROM image.")
        .def("__getstate__",
             [](const BoundSnapshot& state) {
                 if (!state.snapshot) return std::tuple(bytes_of(state.bytes), state.image);
                 const std::vector<uint8_t> bytes = state.snapshot->bytes();
                 return std::tuple(bytes_of(bytes), image_digest(*state.snapshot->game));
             })
        .def("__setstate__", [](BoundSnapshot& state, const std::tuple<nb::bytes, uint64_t>& pickled) {
            const auto& [bytes, image] = pickled;
            const auto* data = reinterpret_cast<const uint8_t*>(bytes.c_str());
            new (&state) BoundSnapshot{nullptr, {data, data + bytes.size()}, image};
        });
    nb::class_<Loan>(m, "Loan", nb::type_slots(kLoanSlots),
                     "A share in an array's memory, for `numpy.ndarray(buffer=)`.");
    nb::class_<ArrayLender>(m, "ArrayLender", "Lends the memory of a uint8 array, without a copy.")
        .def(nb::init<nb::object>(), "array"_a, nb::sig("def __init__(self, array: " NDARRAY("uint8") ") -> None"))
        .def("lend", &ArrayLender::lend)
        .def_prop_ro("lent", &ArrayLender::lent,
                     "Whether a loan exists: an array made from it, or a view or a tensor of such an array.");
    nb::class_<CallLock>(
        m, "CallLock",
        "The lock of an object in Python, for `with`. Its thread may enter again. RuntimeError in a forked\n"
        "process.")
        .def(nb::init<std::string>(), "object"_a)
        .def("__enter__", &CallLock::enter)
        .def(
            "__exit__", [](CallLock& lock, nb::handle, nb::handle, nb::handle) { lock.exit(); }, "type"_a.none(),
            "value"_a.none(), "traceback"_a.none());
    EngineClass engine(m, "VectorEngine",
                       "Environments played by a pool of threads. Use it through atari.AtariVectorEnv.");
    engine.def("__init__", &make_engine, "lanes"_a, "episode"_a, "observation"_a, "settings"_a)
        .def("start", &BoundEngine::start, "actions"_a, "strengths"_a.none(), "batch"_a.none(),
             "environments"_a = nb::none(),
             nb::sig("def start(self, actions: " NDARRAY("int64") ", strengths: " NDARRAY(
                 "float32") " | None, batch: Batch | None, environments: " NDARRAY("int64") " | None = None) -> None"),
             "Begin a step of the environments of the last batch. If `batch` has rows for all environments, the\n"
             "results go there. `environments` are stepped, in the order of the actions. They may be some of all;\n"
             "then the rows of the others show their last results again.")
        .def(
            "play", &BoundEngine::play, "actions"_a, "strengths"_a.none(), "batch"_a, "environments"_a.none(),
            "steps"_a, "discount"_a, "stops"_a, "every"_a,
            nb::sig("def play(self, actions: " NDARRAY("int64") ", strengths: " NDARRAY(
                "float32") " | None, batch: Batch, environments: " NDARRAY("int64") " | None, steps: int, discount: "
                                                                                    "float, stops: bool, every: bool) -> StepSequence"),
            "Begin `steps` steps of each environment; the first environment has the first `steps` actions. With\n"
            "`stops`, an environment stops when its episode ends. With `every`, the batch needs a row for each step of\n"
            "each environment, otherwise it gets the results of the last step.")
        .def("reset", &BoundEngine::reset, "mask"_a, "seeded"_a, "seeds"_a, "batch"_a.none(), "new_games"_a = false,
             nb::sig("def reset(self, mask: " NDARRAY("bool") ", seeded: " NDARRAY("bool") ", seeds: " NDARRAY(
                 "uint32") ", batch: Batch | None, new_games: bool = False) -> None"),
             "Begin a reset of the environments in `mask`; `seeds` has nine words for each, as in `LaneSpec`. With\n"
             "`new_games`, no environment continues its game after a lost life.")
        .def("receive", &BoundEngine::receive, "batch"_a,
             "Wait for a batch of results; returns whether an episode or a game ended in it.")
        .def_prop_ro("sent", &BoundEngine::sent, "Whether a batch has been sent and not received.")
        .def("snapshot", &BoundEngine::snapshot, "environments"_a)
        .def("restore", &BoundEngine::restore, "environments"_a, "states"_a, "own_generators"_a = false)
        .def("save", &BoundEngine::save, "environment"_a, "The state of one environment as bytes.")
        .def(
            "save_emulator",
            [](BoundEngine& x, int environment) {
                const auto state = x.get_slowly(environment, [](Environment& e) { return saved(e); });
                return bytes_of(state);
            },
            "environment"_a, "The state of one environment's emulator as bytes, for Emulator.load.")
        .def("load", &BoundEngine::load, "environment"_a, "state"_a);
    register_vector_ram(engine);
    engine
        .def(
            "numbers",
            [](BoundEngine& x, int i) {
                return x.get(i, [players = static_cast<int>(x.players())](Environment& e) {
                    std::vector<int> numbers{e.frame_number(), e.episode_frame_number()};
                    for (int player = 0; player < players; ++player) numbers.push_back(e.lives(player));
                    return numbers;
                });
            },
            "environment"_a, "Frame number, episode frame number, and the lives of each player.")
        .def("ended", &BoundEngine::ended, "environment"_a,
             "Whether the next step of an environment resets it, or without autoreset plays nothing.")
        .def("record_moves", &BoundEngine::record_moves, "environment"_a,
             "Record the ALE action and its strength in each frame that is played, until `take_moves`.")
        .def("take_moves", &BoundEngine::take_moves, "environment"_a,
             "The recorded actions and strengths, by frame; ends the recording.")
        .def("mode", &call<&Environment::mode>, "environment"_a)
        .def("difficulty", &call<&Environment::difficulty>, "environment"_a)
        .def("set_mode", &call<&Environment::set_mode, int>, "environment"_a, "mode"_a)
        .def("set_difficulty", &call<&Environment::set_difficulty, int>, "environment"_a, "difficulty"_a);
}

}  // namespace atari
