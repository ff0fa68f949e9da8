// `_emulator.VectorEngine` and `_emulator.Batch`: the vector environment, bound for atari/vector, which validates
// options. threads.hpp has the rule for locks and the GIL.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "bound_engine.hpp"
#include "state.hpp"
#include "threads.hpp"
#include "vector_lock.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace atari {
namespace {

template <typename T>
T* rows_of(BoundBatch& batch, nb::object array, size_t size, const char* what) {
    if (array.is_none()) return nullptr;
    Rows<T> rows;
    if (!nb::try_cast(array, rows, false) || rows.size() != size)
        throw nb::value_error(
            (std::string(what) + " must be a writable C-contiguous array of " + std::to_string(size) + " values")
                .c_str());
    batch.arrays.push_back(array);
    batch.arrays.push_back(prevent_resize(array));
    return rows.data();
}

void make_batch(BoundBatch* self, BoundEngine& engine, nb::object pixels, nb::object ram, nb::object final_pixels,
                nb::object final_ram, nb::object numbers, nb::object games, nb::object flags) {
    auto bound = BoundBatch{};
    const size_t rows = bound.rows = engine.rows();
    bound.pixels = engine.pixels();
    const size_t columns = (bound.players = engine.players()) * rows;  // of what players have
    Batch& batch = bound.batch;
    const size_t size = rows * bound.pixels;
    batch.observation = {rows_of<uint8_t>(bound, pixels, size, "pixels"),
                         rows_of<uint8_t>(bound, ram, 128 * rows, "ram")};
    bound.shown.swap(bound.arrays);
    batch.final_observation = {rows_of<uint8_t>(bound, final_pixels, size, "final_pixels"),
                               rows_of<uint8_t>(bound, final_ram, 128 * rows, "final_ram")};
    int32_t* const number = rows_of<int32_t>(bound, numbers, 6 * rows + 4 * columns, "numbers");
    double* const game = rows_of<double>(bound, games, 2 * rows + columns, "games");
    uint8_t* const flag = reinterpret_cast<uint8_t*>(rows_of<bool>(bound, flags, 3 * rows + 2 * columns, "flags"));
    if (!number || !game || !flag) throw nb::value_error("numbers, games and flags are needed");
    batch.reward = number;
    batch.game_reward = number + columns;
    batch.numbers.lives = number + 2 * columns;
    batch.final_numbers.lives = number + 3 * columns;
    int32_t* const one = number + 4 * columns;
    batch.environment = one;
    batch.numbers.frame = one + rows;
    batch.numbers.episode_frame = one + 2 * rows;
    batch.game_steps = one + 3 * rows;
    batch.final_numbers.frame = one + 4 * rows;
    batch.final_numbers.episode_frame = one + 5 * rows;
    batch.ended_games = {game, game + columns, game + columns + rows};
    batch.terminated = flag;
    batch.truncated = flag + columns;
    uint8_t* const game_flag = flag + 2 * columns;
    batch.game_over = game_flag;
    batch.ended = game_flag + rows;
    batch.game_ended = game_flag + 2 * rows;
    new (self) BoundBatch(std::move(bound));
}

// A batch with other arrays of observations; it shares the other arrays.
BoundBatch aimed_at(const BoundBatch& batch, nb::object pixels, nb::object ram) {
    BoundBatch bound{{}, {}, {}, batch.rows, batch.pixels, batch.players};
    const Batch::Observation observation = {rows_of<uint8_t>(bound, pixels, batch.rows * batch.pixels, "pixels"),
                                            rows_of<uint8_t>(bound, ram, 128 * batch.rows, "ram")};
    bound.shown.swap(bound.arrays);
    bound.arrays = batch.arrays;
    bound.batch = batch.batch;
    bound.batch.observation = observation;
    return bound;
}

struct LentArray {
    Rows<uint8_t> rows;
    nb::object fixed;  // see `prevent_resize`
};

// A share in the memory of an array. It exports that memory by the buffer protocol, so a NumPy array made of it owns
// the share, and so do the array's views and tensors. Making an array this way takes about half the time of nb::ndarray
// with a capsule as its owner, which matters in steps of one environment.
struct Loan {
    std::shared_ptr<LentArray> array;
};

int export_loan(PyObject* object, Py_buffer* view, int flags) {
    if (!nb::inst_ready(object)) {  // of `Loan.__new__`
        view->obj = nullptr;
        PyErr_SetString(PyExc_BufferError, "this loan is of no array; ArrayLender.lend makes one");
        return -1;
    }
    const Rows<uint8_t>& rows = nb::inst_ptr<Loan>(object)->array->rows;
    return PyBuffer_FillInfo(view, object, rows.data(), static_cast<Py_ssize_t>(rows.size()), 0, flags);
}

PyType_Slot kLoanSlots[] = {{Py_bf_getbuffer, reinterpret_cast<void*>(export_loan)}, {0, nullptr}};

// Lends the memory of an array without a copy. After all loans have ended, the memory may be written again. A loan
// keeps the memory alive after the lender is destroyed. Loans end with the GIL held.
class ArrayLender {
  public:
    explicit ArrayLender(nb::object array) : array_(std::make_shared<LentArray>()) {
        if (!nb::try_cast(array, array_->rows, false))
            throw nb::type_error("a writable C-contiguous uint8 array is needed");
        array_->fixed = prevent_resize(array);
    }
    Loan lend() const { return {array_}; }
    bool lent() const { return array_.use_count() > 1; }

  private:
    std::shared_ptr<LentArray> array_;
};

void make_engine(BoundEngine* self, const std::vector<const MemberSpec*>& members, EpisodeSettings episode,
                 ObservationSettings observation, VectorSettings settings) {
    std::vector<MemberSpec> specs;
    for (const MemberSpec* member : members) specs.push_back(member ? *member : MemberSpec{});
    if (settings.batch_size < 1 || static_cast<size_t>(settings.batch_size) > specs.size() || settings.threads < 1)
        throw std::invalid_argument("batch_size or threads is out of range");
    auto engine = [&] {
        const GilRelease release;
        return std::make_unique<VectorEngine>(make_members(specs, episode, observation), settings);
    }();
    new (self) BoundEngine(std::move(engine));
}

}  // namespace

void register_settings(nb::module_& m);         // binding_settings.cpp
void register_vector_ram(EngineClass& engine);  // binding_vector_ram.cpp

#define ARRAY(type) "numpy.typing.NDArray[numpy." type "]"

void register_vector(nb::module_& m) {
    register_settings(m);
    nb::enum_<VectorEngine::RamOf>(
        m, "RamOf", "The RAM now, that of the last result, or of that the one before a reset in the last step.")
        .value("NOW", VectorEngine::RamOf::kNow)
        .value("RESULT", VectorEngine::RamOf::kResult)
        .value("FINAL", VectorEngine::RamOf::kFinal);
    nb::class_<BoundBatch> batch(m, "Batch",
                                 "Arrays for the results of a batch. Threads write to them between start and receive.");
    batch.def(
        "__init__", &make_batch, "engine"_a, nb::kw_only(), "pixels"_a.none(), "ram"_a.none(), "final_pixels"_a.none(),
        "final_ram"_a.none(), "numbers"_a, "games"_a, "flags"_a,
        nb::sig("def __init__(self, engine: VectorEngine, *, pixels: " ARRAY("uint8") " | None, ram: " ARRAY("uint8") " | None, final_pixels: " ARRAY(
            "uint8") " | None, final_ram: " ARRAY("uint8") " | None, numbers: " ARRAY("int32") ", games: " ARRAY("float64") ", flags: " ARRAY("bool") ") -> None"),
        "`numbers` is int32: reward, reward before clipping, lives, lives of the final observation, each (rows,\n"
        "players); environment, frame and episode frame number, steps of the game, frame and episode frame number\n"
        "of the final observation, each (rows,). `games` is float64: score (rows, players), frames and seconds\n"
        "(rows,) of the game that ended. `flags` is bool: terminated and truncated (rows, players); game over, has\n"
        "a final observation, a game ended, each (rows,).");
    batch.def("aimed_at", &aimed_at, "pixels"_a.none(), "ram"_a.none(),
              nb::sig("def aimed_at(self, pixels: " ARRAY("uint8") " | None, ram: " ARRAY("uint8") " | None) -> Batch"),
              "A batch with other arrays of observations, which shares the other arrays.");
    nb::class_<BoundSnapshot>(m, "MemberSnapshot",
                              "The state of an environment of a vector, in memory. It can be pickled.")
        .def("__getstate__",
             [](const BoundSnapshot& state) {
                 if (!state.snapshot) return std::tuple(nb::bytes(state.bytes.data(), state.bytes.size()), state.image);
                 const std::vector<uint8_t> bytes = state.snapshot->bytes();
                 return std::tuple(nb::bytes(bytes.data(), bytes.size()), image_digest(*state.snapshot->game));
             })
        .def("__setstate__", [](BoundSnapshot& state, const std::tuple<nb::bytes, uint64_t>& pickled) {
            const auto& [bytes, image] = pickled;
            const auto* data = reinterpret_cast<const uint8_t*>(bytes.c_str());
            new (&state) BoundSnapshot{nullptr, {data, data + bytes.size()}, image};
        });
    nb::class_<Loan>(m, "Loan", nb::type_slots(kLoanSlots),
                     "A share in an array's memory, for `numpy.ndarray(buffer=)`.");
    nb::class_<ArrayLender>(m, "ArrayLender", "Lends the memory of a uint8 array, without a copy.")
        .def(nb::init<nb::object>(), "array"_a, nb::sig("def __init__(self, array: " ARRAY("uint8") ") -> None"))
        .def("lend", &ArrayLender::lend)
        .def_prop_ro("lent", &ArrayLender::lent,
                     "Whether a loan exists: an array made of one, or a view or tensor of that.");
    nb::class_<VectorLock>(m, "VectorLock",
                           "The lock of a vector environment, for `with`. RuntimeError in a forked process.")
        .def(nb::init<>())
        .def("__enter__", &VectorLock::enter)
        .def(
            "__exit__", [](VectorLock& lock, nb::handle, nb::handle, nb::handle) { lock.exit(); }, "type"_a.none(),
            "value"_a.none(), "traceback"_a.none());
    EngineClass engine(m, "VectorEngine",
                       "Environments played by a pool of threads. Use it through atari.AtariVectorEnv.");
    engine.def("__init__", &make_engine, "members"_a, "episode"_a, "observation"_a, "settings"_a)
        .def(
            "start", &BoundEngine::start, "actions"_a, "strengths"_a.none(), "batch"_a.none(),
            "environments"_a = nb::none(),
            nb::sig("def start(self, actions: " ARRAY("int64") ", strengths: " ARRAY(
                "float32") " | None, batch: Batch | None, environments: " ARRAY("int64") " | None = None) -> None"),
            "Begin a step of the environments of the last batch; the batch is where results go if it is of all of "
            "them.\n"
            "`environments` are those to step, in the order of the actions. If a batch has all, they may be some: the\n"
            "rows of the others show the last results again.")
        .def(
            "reset", &BoundEngine::reset, "mask"_a, "seeded"_a, "seeds"_a, "batch"_a.none(), "new_games"_a = false,
            nb::sig("def reset(self, mask: " ARRAY("bool") ", seeded: " ARRAY("bool") ", seeds: " ARRAY(
                "uint32") ", batch: Batch | None, new_games: bool = False) -> None"),
            "Begin a reset of the environments in `mask`; `seeds` as above. With `new_games`, none continues its game\n"
            "after a lost life.")
        .def("receive", &BoundEngine::receive, "batch"_a,
             "Wait for a batch of results; whether an episode or a game ended in it.")
        .def_prop_ro("sent", &BoundEngine::sent, "Whether a batch has been sent and not received.")
        .def("snapshot", &BoundEngine::snapshot, "environments"_a)
        .def("restore", &BoundEngine::restore, "environments"_a, "states"_a)
        .def("fork", &BoundEngine::fork, "source"_a, "targets"_a)
        .def("save", &BoundEngine::save, "environment"_a, "The state of one environment as bytes.")
        .def("save_emulator", &BoundEngine::save_emulator, "environment"_a,
             "The state of one environment's emulator as bytes, for Emulator.load.")
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
        .def(
            "mode", [](BoundEngine& x, int i) { return x.get(i, [](Environment& e) { return e.mode(); }); },
            "environment"_a)
        .def(
            "difficulty", [](BoundEngine& x, int i) { return x.get(i, [](Environment& e) { return e.difficulty(); }); },
            "environment"_a)
        .def(
            "set_mode", [](BoundEngine& x, int i, int mode) { x.get(i, [&](Environment& e) { e.set_mode(mode); }); },
            "environment"_a, "mode"_a)
        .def(
            "set_difficulty",
            [](BoundEngine& x, int i, int value) { x.get(i, [&](Environment& e) { e.set_difficulty(value); }); },
            "environment"_a, "difficulty"_a);
}

}  // namespace atari
