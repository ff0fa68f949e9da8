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

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

#include "ale/labels.hpp"
#include "state.hpp"
#include "threads.hpp"
#include "vector_lock.hpp"
#include "vector/members.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace atari {
namespace {

template <typename T>
using Rows = nb::ndarray<T, nb::c_contig, nb::device::cpu>;
template <typename T>
using List = nb::ndarray<const T, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
template <typename T>
using Table = nb::ndarray<T, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Rams = Table<uint8_t>;
using Seeds = nb::ndarray<const uint32_t, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

SeedWords words_of(const Seeds& seeds, size_t i) {
    SeedWords words;
    for (size_t word = 0; word < words.size(); ++word) words[word] = seeds(i, word);
    return words;
}

// Arrays for the results of a batch, with the pointers to their parts.
struct BoundBatch {
    Batch batch;
    std::vector<nb::object> shown;   // arrays of observations, and weak references to them, see `prevent_resize`
    std::vector<nb::object> arrays;  // the other arrays
    size_t rows = 0, pixels = 0;     // bytes of pixels in an observation
    size_t players = 1;
};

// A member's state in memory. After unpickling it consists of bytes, and `snapshot` is null.
struct BoundSnapshot {
    VectorEngine::Snapshot snapshot;
    std::vector<uint8_t> bytes;
    uint64_t image;

    // Returns the snapshot for one environment; null if it does not fit.
    VectorEngine::Snapshot within(VectorEngine& engine, int environment) const {
        if (snapshot) return engine.fits(environment, *snapshot) ? snapshot : nullptr;
        const bool same =
            bytes.size() == engine.state_size(environment) && image == image_digest(engine.game(environment));
        return same ? engine.parse(environment, bytes.data()) : nullptr;
    }
};

// The engine as Python threads share it. The GIL is released while environments are played or waited for.
class BoundEngine : Exclusive {
  public:
    explicit BoundEngine(std::unique_ptr<VectorEngine> engine) : engine_(std::move(engine)) {}

    // Joins the threads, which may still write to `current_`.
    ~BoundEngine() {
        const GilRelease release;
        engine_.reset();
    }

    void start(List<int64_t> actions, std::optional<List<float>> strengths, nb::object batch,
               std::optional<List<int64_t>> environments) {
        const std::vector<int64_t> indices(actions.data(), actions.data() + actions.size());
        std::vector<int64_t> numbers;
        if (environments) numbers.assign(environments->data(), environments->data() + environments->size());
        std::vector<float> factors(indices.size(), 1.0f);
        if (strengths && strengths->size() != factors.size())
            throw nb::value_error("there must be a strength for each action");
        if (strengths) std::copy_n(strengths->data(), factors.size(), factors.begin());
        const Batch* const target = checked(batch);
        locked([&] {
            check_process(process_);
            if (sent_) throw std::runtime_error("a step has been started; receive it first");
            std::vector<int> some;
            if (environments) some = chosen(numbers);
            const std::vector<int>& rows = environments ? some : engine_->recent();
            check_actions(rows, indices, factors);
            std::swap(current_, batch);
            target_ = target;
            sent_ = true;
            engine_->step(rows, indices.data(), factors.data(), target);
        });
    }

    void reset(List<bool> mask, List<bool> seeded, Seeds seeds, nb::object batch, bool new_games) {
        const auto size = static_cast<size_t>(engine_->size());
        if (mask.shape(0) != size || seeded.shape(0) != size || seeds.shape(0) != size ||
            seeds.shape(1) != SeedWords{}.size())
            throw nb::value_error("there must be an entry for each environment");
        std::vector<Seed> values(size);
        std::vector<const Seed*> given(size);
        std::vector<bool> which(size);
        for (size_t i = 0; i < size; ++i) {
            values[i] = seed_of(words_of(seeds, i));
            given[i] = seeded(i) ? &values[i] : nullptr;
            which[i] = mask(i);
        }
        const Batch* const target = checked(batch);
        locked([&] {
            check_process(process_);
            engine_->drain();
            std::swap(current_, batch);
            target_ = target;
            sent_ = true;
            engine_->reset(which, given, target, new_games);
        });
    }

    bool receive(const BoundBatch& batch) {
        check_size(batch);
        return locked([&] {
            check_process(process_);
            if (!sent_) throw std::runtime_error("no step has been started");
            if (target_ && target_ != &batch.batch) throw nb::value_error("the step was started with another batch");
            sent_ = false;
            return engine_->receive(batch.batch);
        });
    }

    std::vector<BoundSnapshot> snapshot(const std::vector<int>& environments) {
        return locked([&] {
            check_idle(environments);
            std::vector<BoundSnapshot> states;
            for (int environment : environments) states.push_back({engine_->snapshot(environment), {}, 0});
            return states;
        });
    }

    void restore(const std::vector<int>& environments, const std::vector<const BoundSnapshot*>& states) {
        if (environments.size() != states.size())
            throw nb::value_error("there must be a snapshot for each environment");
        std::vector<BoundSnapshot> copies;  // Another thread may drop the list.
        for (const BoundSnapshot* state : states) copies.push_back(state ? *state : BoundSnapshot{});
        locked([&] {
            check_idle(environments);
            std::vector<VectorEngine::Snapshot> snapshots;
            for (size_t i = 0; i < copies.size(); ++i) {
                snapshots.push_back(copies[i].within(*engine_, environments[i]));
                if (!snapshots[i])
                    throw nb::value_error(("snapshot " + std::to_string(i) + " is of another game than environment " +
                                           std::to_string(environments[i]) +
                                           ", or was taken with other options").c_str());
            }
            for (size_t i = 0; i < copies.size(); ++i) engine_->restore(environments[i], std::move(snapshots[i]));
        });
    }

    void fork(int source, const std::vector<int>& targets) {
        const BoundSnapshot state = snapshot({source})[0];
        restore(targets, std::vector<const BoundSnapshot*>(targets.size(), &state));
    }

    nb::bytes save(int environment) {
        const auto state = locked([&] {
            check_idle({environment});
            std::vector<uint8_t> bytes(engine_->state_size(environment));
            engine_->save(environment, bytes.data());
            return bytes;
        });
        return nb::bytes(state.data(), state.size());
    }

    nb::bytes save_emulator(int environment) {
        const auto state = locked([&] {
            check_idle({environment});
            std::vector<uint8_t> bytes(engine_->emulator_state_size(environment));
            engine_->save_emulator(environment, bytes.data());
            return bytes;
        });
        return nb::bytes(state.data(), state.size());
    }

    void load(int environment, nb::bytes state) {
        const auto* const bytes = static_cast<const uint8_t*>(state.data());
        const size_t size = state.size();
        const bool good = locked([&] {
            check_idle({environment});
            return size == engine_->state_size(environment) && engine_->load(environment, bytes);
        });
        if (!good) throw nb::value_error("the state is damaged, or of another game or version");
    }

    // Calls `get(environment)` while no environment is being played.
    template <typename Get>
    auto get(int environment, Get&& get) {
        if (briefly([&] { return engine_->pending() > 0; })) return get_slowly(environment, get);
        return briefly([&] {
            check_received({environment});
            return get(engine_->episode(environment).environment());
        });
    }

    // As `get`, without the GIL.
    template <typename Get>
    auto get_slowly(int environment, Get&& get) {
        return locked([&] {
            check_idle({environment});
            return get(engine_->episode(environment).environment());
        });
    }

    // Copies the RAM of environments, 128 bytes each. Environments of the last batch are not being played.
    std::vector<uint8_t> rams(const std::vector<int>& environments, VectorEngine::RamOf of) {
        std::vector<uint8_t> rams(kRamSize * environments.size());
        const auto copy = [&] {
            uint8_t* out = rams.data();
            for (int environment : environments) out = std::copy_n(engine_->ram(environment, of), kRamSize, out);
        };
        const std::vector<int>& recent = engine_->recent();
        const bool received = briefly([&] {
            return engine_->pending() == 0 || std::all_of(environments.begin(), environments.end(), [&](int environment) {
                return std::find(recent.begin(), recent.end(), environment) != recent.end();
            });
        });
        if (received) briefly([&] { check_received(environments); copy(); });
        else locked([&] { check_idle(environments); copy(); });
        return rams;
    }

    size_t rows() const { return static_cast<size_t>(engine_->batch_size()); }
    size_t players() const { return static_cast<size_t>(engine_->players()); }
    size_t pixels() const { return engine_->pixels(); }

  private:
    // The batch of an object, which threads write to; null for None, where results wait for `receive`.
    const Batch* checked(nb::handle batch) const {
        if (batch.is_none() && engine_->batch_size() < engine_->size()) return nullptr;
        if (batch.is_none())
            throw nb::value_error("a batch of all environments is written while they are played; give one");
        BoundBatch* bound = nullptr;
        if (!nb::try_cast(batch, bound) || !bound) throw nb::type_error("the batch must be a Batch of this engine");
        check_size(*bound);
        return &bound->batch;
    }

    void check_size(const BoundBatch& batch) const {
        if (batch.rows != rows() || batch.pixels != pixels() || batch.players != players())
            throw nb::value_error("the batch is of an engine with batches, observations or players of another number");
    }

    // The checks below are made with the lock.
    //
    // The environments of a step: some of all, or those of the last batch in any order if a batch has fewer than all.
    std::vector<int> chosen(const std::vector<int64_t>& numbers) const {
        std::vector<bool> available(static_cast<size_t>(engine_->size()));
        for (int environment : engine_->recent()) available[static_cast<size_t>(environment)] = true;
        std::vector<int> environments;
        for (size_t i = 0; i < numbers.size(); ++i) {
            const std::string which = "environment " + std::to_string(numbers[i]) + " in row " + std::to_string(i);
            if (numbers[i] < 0 || numbers[i] >= engine_->size())
                throw nb::index_error((which + " does not exist; env_id is within 0.." +
                                       std::to_string(engine_->size() - 1)).c_str());
            if (!available[static_cast<size_t>(numbers[i])])
                throw nb::value_error((which + " is given twice, or is not of the last batch").c_str());
            available[static_cast<size_t>(numbers[i])] = false;
            environments.push_back(static_cast<int>(numbers[i]));
        }
        if (environments.empty()) throw nb::value_error("env_id must name at least one environment");
        if (engine_->batch_size() < engine_->size() && environments.size() != engine_->recent().size())
            throw nb::value_error(("with batch_size < num_envs, env_id must name all " +
                                   std::to_string(engine_->recent().size()) +
                                   " environments of the last batch").c_str());
        return environments;
    }

    void check_actions(const std::vector<int>& environments, const std::vector<int64_t>& actions,
                       const std::vector<float>& strengths) const {
        const auto players = static_cast<size_t>(engine_->players());
        if (actions.size() != environments.size() * players)
            throw nb::value_error(players == 1 ? "there must be an action for each environment of the batch"
                                               : "there must be an action for each player of each environment");
        for (size_t i = 0; i < actions.size(); ++i) {
            const int most = engine_->actions_of(environments[i / players]) - 1;
            if (actions[i] < 0 || actions[i] > most)
                throw nb::value_error(("action " + std::to_string(actions[i]) + " in row " +
                                       std::to_string(i / players) +
                                       " is not within 0.." + std::to_string(most)).c_str());
            if (!(std::abs(strengths[i]) <= 1000.0f))  // negated, so that NaN fails too
                throw nb::value_error(("the strength in row " + std::to_string(i) +
                                       " must be finite and at most 1000 in magnitude").c_str());
        }
    }

    // Throws between `start` and `receive`. In batches of fewer than all, waits for the environments that are not in the last
    // batch, so it is called without the GIL.
    void check_idle(const std::vector<int>& environments) {
        check_received(environments);
        if (engine_->pending()) engine_->settle();
    }

    void check_received(const std::vector<int>& environments) const {
        check_process(process_);
        if (sent_) throw std::runtime_error("environments are being played; call recv() first");
        for (int environment : environments)
            if (environment < 0 || environment >= engine_->size())
                throw nb::index_error(("there is no environment " + std::to_string(environment)).c_str());
    }

    const uint32_t process_ = process_generation;
    nb::object current_;              // owns `target_`
    const Batch* target_ = nullptr;   // what the threads write to: must outlive `engine_`
    bool sent_ = false;               // whether a batch has been sent and not received
    std::unique_ptr<VectorEngine> engine_;
};

template <typename T>
T* rows_of(BoundBatch& batch, nb::object array, size_t size, const char* what) {
    if (array.is_none()) return nullptr;
    Rows<T> rows;
    if (!nb::try_cast(array, rows, false) || rows.size() != size)
        throw nb::value_error((std::string(what) + " must be a writable C-contiguous array of " + std::to_string(size) +
                               " values").c_str());
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

template <auto draw>
nb::object screen_of(BoundEngine& engine, int environment) {
    const auto height = engine.get(environment, [](Environment& e) { return static_cast<size_t>(e.height()); });
    auto* bytes = new uint8_t[height * kScreenWidth * 3];
    nb::capsule owner(bytes, [](void* memory) noexcept { delete[] static_cast<uint8_t*>(memory); });
    engine.get_slowly(environment, [&](Environment& e) { (e.*draw)(bytes); });
    const size_t shape[3] = {height, kScreenWidth, 3};
    return nb::cast(nb::ndarray<nb::numpy, uint8_t, nb::c_contig, nb::device::cpu>(bytes, 3, shape, owner));
}

}  // namespace

void register_settings(nb::module_& m);  // binding_settings.cpp

#define ARRAY(type) "numpy.typing.NDArray[numpy." type "]"

void register_vector(nb::module_& m) {
    register_settings(m);
    nb::enum_<VectorEngine::RamOf>(m, "RamOf",
                                   "The RAM now, that of the last result, or of that the one before a reset in the last step.")
        .value("NOW", VectorEngine::RamOf::kNow)
        .value("RESULT", VectorEngine::RamOf::kResult)
        .value("FINAL", VectorEngine::RamOf::kFinal);
    nb::class_<BoundBatch> batch(m, "Batch",
                           "Arrays for the results of a batch. Threads write to them between start and receive.");
    batch.def("__init__", &make_batch, "engine"_a, nb::kw_only(), "pixels"_a.none(), "ram"_a.none(),
             "final_pixels"_a.none(),
             "final_ram"_a.none(), "numbers"_a, "games"_a, "flags"_a,
             nb::sig("def __init__(self, engine: VectorEngine, *, pixels: " ARRAY("uint8")
                     " | None, ram: " ARRAY("uint8")
                     " | None, final_pixels: " ARRAY("uint8") " | None, final_ram: " ARRAY("uint8")
                     " | None, numbers: " ARRAY("int32") ", games: " ARRAY("float64")
                     ", flags: " ARRAY("bool") ") -> None"),
             "`numbers` is int32: reward, reward before clipping, lives, lives of the final observation, each (rows,\n"
             "players); environment, frame and episode frame number, steps of the game, frame and episode frame number\n"
             "of the final observation, each (rows,). `games` is float64: score (rows, players), frames and seconds\n"
             "(rows,) of the game that ended. `flags` is bool: terminated and truncated (rows, players); game over, has\n"
             "a final observation, a game ended, each (rows,).");
    batch.def("aimed_at", &aimed_at, "pixels"_a.none(), "ram"_a.none(),
              nb::sig("def aimed_at(self, pixels: " ARRAY("uint8") " | None, ram: " ARRAY("uint8")
                      " | None) -> Batch"),
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
        .def(nb::init<nb::object>(), "array"_a,
             nb::sig("def __init__(self, array: " ARRAY("uint8") ") -> None"))
        .def("lend", &ArrayLender::lend)
        .def_prop_ro("lent", &ArrayLender::lent,
                     "Whether a loan exists: an array made of one, or a view or tensor of that.");
    nb::class_<VectorLock>(m, "VectorLock",
                           "The lock of a vector environment, for `with`. RuntimeError in a forked process.")
        .def(nb::init<>())
        .def("__enter__", &VectorLock::enter)
        .def("__exit__", [](VectorLock& lock, nb::handle, nb::handle, nb::handle) { lock.exit(); }, "type"_a.none(),
             "value"_a.none(), "traceback"_a.none());
    nb::class_<BoundEngine>(m, "VectorEngine",
                            "Environments played by a pool of threads. Use it through atari.AtariVectorEnv.")
        .def("__init__", &make_engine, "members"_a, "episode"_a, "observation"_a, "settings"_a)
        .def("start", &BoundEngine::start, "actions"_a, "strengths"_a.none(), "batch"_a.none(),
             "environments"_a = nb::none(),
             nb::sig("def start(self, actions: " ARRAY("int64") ", strengths: " ARRAY("float32")
                     " | None, batch: Batch | None, environments: " ARRAY("int64") " | None = None) -> None"),
             "Begin a step of the environments of the last batch; the batch is where results go if it is of all of "
             "them.\n"
             "`environments` are those to step, in the order of the actions. If a batch has all, they may be some: the\n"
             "rows of the others show the last results again.")
        .def("reset", &BoundEngine::reset, "mask"_a, "seeded"_a, "seeds"_a, "batch"_a.none(),
             "new_games"_a = false,
             nb::sig("def reset(self, mask: " ARRAY("bool") ", seeded: " ARRAY("bool") ", seeds: " ARRAY("uint32")
                     ", batch: Batch | None, new_games: bool = False) -> None"),
             "Begin a reset of the environments in `mask`; `seeds` as above. With `new_games`, none continues its game\n"
             "after a lost life.")
        .def("receive", &BoundEngine::receive, "batch"_a,
             "Wait for a batch of results; whether an episode or a game ended in it.")
        .def("snapshot", &BoundEngine::snapshot, "environments"_a)
        .def("restore", &BoundEngine::restore, "environments"_a, "states"_a)
        .def("fork", &BoundEngine::fork, "source"_a, "targets"_a)
        .def("save", &BoundEngine::save, "environment"_a, "The state of one environment as bytes.")
        .def("save_emulator", &BoundEngine::save_emulator, "environment"_a,
             "The state of one environment's emulator as bytes, for Emulator.load.")
        .def("load", &BoundEngine::load, "environment"_a, "state"_a)
        .def("screen_rgb", &screen_of<&Environment::screen_rgb>, "environment"_a,
             nb::sig("def screen_rgb(self, environment: int) -> " ARRAY("uint8")))
        .def("redraw", &screen_of<&Environment::redraw>, "environment"_a,
             nb::sig("def redraw(self, environment: int) -> " ARRAY("uint8")))
        .def("ram", [](BoundEngine& x, int i) {
                 const auto ram = x.get(i, [](Environment& e) {
                     return std::vector<uint8_t>(e.ram(), e.ram() + 128);
                 });
                 return nb::bytes(ram.data(), ram.size());
             }, "environment"_a)
        .def("copy_rams", [](BoundEngine& x, List<int64_t> environments, Rams out, VectorEngine::RamOf of) {
                 if (out.shape(0) != environments.shape(0) || out.shape(1) != 128)
                     throw nb::value_error("out must be of shape (environments, 128)");
                 std::vector<int> numbers;
                 for (size_t i = 0; i < environments.size(); ++i)
                     numbers.push_back(static_cast<int>(std::clamp<int64_t>(environments(i), -1, INT32_MAX)));
                 const std::vector<uint8_t> rams = x.rams(numbers, of);
                 std::copy(rams.begin(), rams.end(), out.data());
             }, "environments"_a, nb::arg("out").noconvert(), "of"_a,
             nb::sig("def copy_rams(self, environments: " ARRAY("int64") ", out: " ARRAY("uint8")
                     ", of: RamOf) -> None"),
             "Copy the RAM of environments to the rows of `out`.")
        .def("evaluate_labels",
             [](BoundEngine& x, const Shared<Labels>& labels, List<int32_t> environments, Table<int32_t> values,
                Table<bool> visible, VectorEngine::RamOf of) {
                 const size_t count = labels.value->size(), rows = environments.size();
                 if (values.shape(0) != count || values.shape(1) != rows || visible.shape(0) != count ||
                     visible.shape(1) != rows)
                     throw nb::value_error("values and visible must be of shape (labels, environments)");
                 const std::vector<uint8_t> rams = x.rams({environments.data(), environments.data() + rows}, of);
                 labels.value->evaluate(rams.data(), rows, values.data(), reinterpret_cast<uint8_t*>(visible.data()));
             }, "labels"_a, "environments"_a, nb::arg("values").noconvert(), nb::arg("visible").noconvert(), "of"_a,
             nb::sig("def evaluate_labels(self, labels: Labels, environments: " ARRAY("int32") ", values: " ARRAY("int32")
                     ", visible: " ARRAY("bool") ", of: RamOf) -> None"),
             "As `copy_rams`, then `labels.evaluate` with the copies.")
        .def("set_ram", [](BoundEngine& x, int i, int index, int value) {
                 x.get(i, [&](Environment& e) { e.set_ram(index & 127, value & 255); });
             }, "environment"_a, "index"_a, "value"_a)
        .def("add_write",
             [](BoundEngine& x, int i, const Shared<Write>& write, bool now) {
                 if (!x.get(i, [&](Environment& e) { return e.add_write(write.value, now); }))
                     throw nb::value_error(kTooManyWrites);
             }, "environment"_a, "write"_a, "now"_a = false, "As Emulator.add_write.")
        .def("remove_write",
             [](BoundEngine& x, int i, const Shared<Write>& write) {
                 x.get(i, [&](Environment& e) { e.remove_write(write.value.get()); });
             }, "environment"_a, "write"_a)
        .def("numbers", [](BoundEngine& x, int i) {
                 return x.get(i, [players = static_cast<int>(x.players())](Environment& e) {
                     std::vector<int> numbers{e.frame_number(), e.episode_frame_number()};
                     for (int player = 0; player < players; ++player) numbers.push_back(e.lives(player));
                     return numbers;
                 });
             }, "environment"_a, "Frame number, episode frame number, and the lives of each player.")
        .def("mode", [](BoundEngine& x, int i) { return x.get(i, [](Environment& e) { return e.mode(); }); },
             "environment"_a)
        .def("difficulty",
             [](BoundEngine& x, int i) { return x.get(i, [](Environment& e) { return e.difficulty(); }); },
             "environment"_a)
        .def("set_mode",
             [](BoundEngine& x, int i, int mode) { x.get(i, [&](Environment& e) { e.set_mode(mode); }); },
             "environment"_a, "mode"_a)
        .def("set_difficulty",
             [](BoundEngine& x, int i, int value) { x.get(i, [&](Environment& e) { e.set_difficulty(value); }); },
             "environment"_a, "difficulty"_a);
}

}  // namespace atari
