// `_emulator.Vector` and `_emulator.Batch`: the vector environment, bound for atari/vector.py, which checks options.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <map>
#include <memory>
#include <mutex>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <string>

#include "vector.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace atari {
namespace {

template <typename T>
using Rows = nb::ndarray<T, nb::c_contig, nb::device::cpu>;
template <typename T>
using List = nb::ndarray<const T, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Seeds = nb::ndarray<const uint32_t, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

template <typename T>
T chosen(const std::map<std::string, T>& choices, const std::string& name) {
    const auto found = choices.find(name);
    if (found == choices.end()) throw nb::value_error(("there is no choice " + name).c_str());
    return found->second;
}

const std::map<std::string, Pixels> kPixels = {
    {"none", Pixels::kNone}, {"gray", Pixels::kGray}, {"rgb", Pixels::kRgb}, {"gray of rgb", Pixels::kGrayOfRgb}};
const std::map<std::string, EndFrames> kEndFrames = {{"last", EndFrames::kLast},
                                                     {"gymnasium", EndFrames::kGymnasium},
                                                     {"baselines", EndFrames::kBaselines},
                                                     {"envpool", EndFrames::kEnvpool}};
const std::map<std::string, Fire> kFires = {
    {"never", Fire::kNever}, {"before", Fire::kBeforeNoops}, {"after", Fire::kAfterNoops}};
const std::map<std::string, OnReset> kOnResets = {
    {"noop", OnReset::kNoop}, {"continue", OnReset::kContinue}, {"new_game", OnReset::kNewGame}};
const std::map<std::string, Autoreset> kAutoresets = {
    {"NextStep", Autoreset::kNextStep}, {"SameStep", Autoreset::kSameStep}, {"Disabled", Autoreset::kDisabled}};

constexpr size_t kSeedWords = 9;

Seed seed_of(const Seeds& seeds, size_t i) {
    Seed seed{seeds(i, 0), {}};
    for (size_t word = 1; word < kSeedWords; ++word) seed.own[word - 1] = seeds(i, word);
    return seed;
}

// Arrays for the results of a batch, with the pointers to their parts.
struct BoundBatch {
    Batch batch;
    std::vector<nb::object> arrays;
    size_t rows = 0;
};

// A digest of a game's image (FNV-1a), by which a state that was pickled knows its game again.
uint64_t image_digest(const Game& game) {
    uint64_t digest = 0xcbf29ce484222325ull;
    const uint8_t* const image = game.cartridge->image();
    for (size_t i = 0; i < game.cartridge->size(); ++i) digest = (digest ^ image[i]) * 0x100000001b3ull;
    return digest;
}

// A member's state in memory, or as it was pickled.
struct MemberState {
    Vector::Snapshot snapshot;
    std::vector<uint8_t> bytes;
    uint64_t image;

    // As a state of this environment; null if it does not fit.
    Vector::Snapshot within(Vector& engine, int environment) const {
        if (snapshot) return engine.fits(environment, *snapshot) ? snapshot : nullptr;
        const bool same = bytes.size() == engine.state_size(environment) && image == image_digest(engine.game(environment));
        return same ? engine.parse(environment, bytes.data()) : nullptr;
    }
};

// The vector with its lock: two threads may share it, one call at a time goes through. The interpreter's lock is released
// while environments are played or waited for.
class BoundVector {
  public:
    BoundVector(std::vector<Vector::Member> members, const VectorSettings& settings)
        : engine_(std::make_unique<Vector>(std::move(members), settings)) {
        recent_.resize(static_cast<size_t>(settings.batch_size));
        std::iota(recent_.begin(), recent_.end(), 0);
    }

    void start(List<int64_t> actions, std::optional<List<float>> strengths, nb::object batch) {
        const auto lock = acquire();
        if (sent_) throw std::runtime_error("a step has been started; receive it first");
        const size_t count = actions.shape(0);
        if (count != recent_.size() || (strengths && strengths->shape(0) != count))
            throw nb::value_error("there must be an action for each environment of the batch");
        for (size_t i = 0; i < count; ++i) {
            const int most = engine_->actions_of(recent_[i]) - 1;
            if (actions(i) < 0 || actions(i) > most)
                throw nb::value_error(("action " + std::to_string(actions(i)) + " in row " + std::to_string(i) +
                                       " is not within 0.." + std::to_string(most)).c_str());
        }
        const Batch* target = hold(batch);
        sent_ = true;
        const nb::gil_scoped_release release;
        engine_->step(recent_.data(), actions.data(), strengths ? strengths->data() : nullptr, static_cast<int>(count),
                      target);
    }

    void reset(List<bool> mask, List<bool> seeded, Seeds seeds, nb::object batch) {
        const auto lock = acquire();
        const auto size = static_cast<size_t>(engine_->size());
        if (mask.shape(0) != size || seeded.shape(0) != size || seeds.shape(0) != size || seeds.shape(1) != kSeedWords)
            throw nb::value_error("there must be an entry for each environment");
        {
            const nb::gil_scoped_release release;
            engine_->drain();
        }
        const Batch* target = hold(batch);
        std::vector<Seed> values(size);
        std::vector<const Seed*> given(size);
        std::vector<bool> which(size);
        for (size_t i = 0; i < size; ++i) {
            values[i] = seed_of(seeds, i);
            given[i] = seeded(i) ? &values[i] : nullptr;
            which[i] = mask(i);
        }
        sent_ = true;
        const nb::gil_scoped_release release;
        engine_->reset(which, given, target);
    }

    void receive(const BoundBatch& batch) {
        const auto lock = acquire();
        if (!sent_) throw std::runtime_error("no step has been started");
        if (batch.rows != recent_.size()) throw nb::value_error("the batch has another number of rows");
        sent_ = false;
        const nb::gil_scoped_release release;
        engine_->receive(batch.batch);
        std::copy_n(batch.batch.environment, recent_.size(), recent_.begin());
    }

    // Calls about single environments, while none is being played.
    template <typename Work>
    auto about(const std::vector<int>& environments, Work&& work) {
        const auto lock = acquire();
        if (sent_ || engine_->pending()) throw std::runtime_error("environments are being played; call recv() first");
        for (int environment : environments)
            if (environment < 0 || environment >= engine_->size())
                throw nb::index_error(("there is no environment " + std::to_string(environment)).c_str());
        return work(*engine_);
    }

    std::vector<MemberState> snapshot(const std::vector<int>& environments) {
        return about(environments, [&](Vector& engine) {
            const nb::gil_scoped_release release;
            std::vector<MemberState> states;
            for (int environment : environments) states.push_back({engine.snapshot(environment), {}, 0});
            return states;
        });
    }

    void restore(const std::vector<int>& environments, const std::vector<const MemberState*>& states) {
        if (environments.size() != states.size()) throw nb::value_error("there must be a snapshot for each environment");
        about(environments, [&](Vector& engine) {
            std::vector<Vector::Snapshot> snapshots;
            for (size_t i = 0; i < states.size(); ++i) {
                snapshots.push_back(states[i] ? states[i]->within(engine, environments[i]) : nullptr);
                if (!snapshots[i])
                    throw nb::value_error(("snapshot " + std::to_string(i) + " is of another game than environment " +
                                           std::to_string(environments[i]) + ", or was taken with other options").c_str());
            }
            for (size_t i = 0; i < states.size(); ++i) engine.restore(environments[i], std::move(snapshots[i]));
            return 0;
        });
    }

    void fork(int source, const std::vector<int>& targets) {
        const MemberState state = snapshot({source})[0];
        restore(targets, std::vector<const MemberState*>(targets.size(), &state));
    }

    nb::bytes save(int environment) {
        const auto state = about({environment}, [&](Vector& engine) {
            std::vector<uint8_t> bytes(engine.state_size(environment));
            engine.save(environment, bytes.data());
            return bytes;
        });
        return nb::bytes(state.data(), state.size());
    }

    void load(int environment, nb::bytes state) {
        const bool good = about({environment}, [&](Vector& engine) {
            return state.size() == engine.state_size(environment) &&
                   engine.load(environment, static_cast<const uint8_t*>(state.data()));
        });
        if (!good) throw nb::value_error("the state is damaged, or of another game or version");
    }

    template <typename Value, typename Get>
    Value ask(int environment, Get&& get) {
        return about({environment}, [&](Vector& engine) { return Value(get(engine.player(environment).environment())); });
    }

    Vector& engine() { return *engine_; }

  private:
    // Whoever waits for this lock has given up the interpreter's.
    std::unique_lock<std::mutex> acquire() {
        if (std::unique_lock lock(mutex_, std::try_to_lock); lock) return lock;
        const nb::gil_scoped_release release;
        return std::unique_lock(mutex_);
    }

    const Batch* hold(nb::object batch) {
        current_ = batch;
        return batch.is_none() ? nullptr : &nb::cast<BoundBatch&>(batch).batch;
    }

    std::mutex mutex_;
    nb::object current_;       // threads may be writing to it, so it goes after them
    std::vector<int> recent_;  // the environments of the last batch, by row
    bool sent_ = false;        // has the batch not been received?
    std::unique_ptr<Vector> engine_;
};

template <typename T>
T* rows_of(BoundBatch& batch, nb::object array, size_t size, const char* what) {
    if (array.is_none()) return nullptr;
    Rows<T> rows;
    if (!nb::try_cast(array, rows, false) || rows.size() != size)
        throw nb::value_error((std::string(what) + " must be a writable C-contiguous array of " + std::to_string(size) +
                               " values").c_str());
    batch.arrays.push_back(array);
    return rows.data();
}

void make_batch(BoundBatch* self, BoundVector& vector, nb::object pixels, nb::object ram, nb::object final_pixels,
                       nb::object final_ram, nb::object numbers, nb::object flags) {
    auto bound = BoundBatch{};
    const auto rows = static_cast<size_t>(vector.engine().batch_size());
    bound.rows = rows;
    Batch& batch = bound.batch;
    const size_t size = rows * vector.engine().pixels();
    batch.observation = {rows_of<uint8_t>(bound, pixels, size, "pixels"), rows_of<uint8_t>(bound, ram, 128 * rows, "ram")};
    batch.final_observation = {rows_of<uint8_t>(bound, final_pixels, size, "final_pixels"),
                               rows_of<uint8_t>(bound, final_ram, 128 * rows, "final_ram")};
    int32_t* const number = rows_of<int32_t>(bound, numbers, 8 * rows, "numbers");
    uint8_t* const flag = reinterpret_cast<uint8_t*>(rows_of<bool>(bound, flags, 3 * rows, "flags"));
    if (!number || !flag) throw nb::value_error("numbers and flags are needed");
    batch.reward = number;
    batch.environment = number + rows;
    batch.numbers = {number + 2 * rows, number + 3 * rows, number + 4 * rows};
    batch.final_numbers = {number + 5 * rows, number + 6 * rows, number + 7 * rows};
    batch.terminated = flag;
    batch.truncated = flag + rows;
    batch.ended = flag + 2 * rows;
    new (self) BoundBatch(std::move(bound));
}

using Pairs = std::shared_ptr<const std::vector<uint8_t>>;

std::unique_ptr<Player> make_player(const std::string& protocol, std::unique_ptr<Environment> environment,
                                    const PlaySettings& play, const ViewSettings& view,
                                    std::shared_ptr<const Scaler> scaler, const Start& start, const Seed& seed) {
    if (protocol == "ale") return std::make_unique<AlePlayer>(std::move(environment), play, view, scaler, start, seed);
    if (protocol == "frames")
        return std::make_unique<FramePlayer>(std::move(environment), play, view, scaler, start, seed);
    if (protocol == "baselines")
        return std::make_unique<BaselinesPlayer>(std::move(environment), play, view, scaler, start, seed);
    throw std::invalid_argument("there is no protocol " + protocol);
}

void make_vector(BoundVector* self, const std::vector<std::shared_ptr<Game>>& games,
                 const std::vector<std::vector<int>>& actions, const std::vector<std::vector<int>>& action_sets,
                 const std::vector<std::optional<int>>& modes, const std::vector<std::optional<int>>& difficulties,
                 Seeds seeds, const std::vector<nb::bytes>& pairs, double probability, int episode_limit,
                 const std::string& protocol, std::pair<int, int> frame_skip, std::pair<int, int> noops,
                 bool fire_counts, const std::string& fire, bool episodic_life, bool life_loss_info,
                 const std::string& on_reset, bool last_life, bool seamless_lives, bool clip_reward, int max_frames,
                 const std::string& pixels, int height, int width, int stack, bool max_pool,
                 const std::string& end_frames, bool pads_zero, int batch_size, int threads, int first_core,
                 const std::string& autoreset) {
    const size_t size = games.size();
    if (size == 0 || actions.size() != size || action_sets.size() != size || modes.size() != size ||
        difficulties.size() != size || seeds.shape(0) != size || seeds.shape(1) != kSeedWords || pairs.size() != size)
        throw nb::value_error("there must be an entry for each environment, and at least one");
    if (batch_size < 1 || static_cast<size_t>(batch_size) > size || threads < 1 || stack < 1 || frame_skip.first < 1 ||
        frame_skip.second <= frame_skip.first || noops.first < 0 || noops.second < noops.first)
        throw nb::value_error("batch_size, threads, stack, frame_skip or noops is out of range");
    const Settings settings{probability, 1, episode_limit, false, false};
    const PlaySettings play{frame_skip,    noops.first,    noops.second,
                            fire_counts,   chosen(kFires, fire), episodic_life,
                            life_loss_info, chosen(kOnResets, on_reset), last_life,
                            seamless_lives, clip_reward,   max_frames};
    ViewSettings view{chosen(kPixels, pixels), height, width, stack, max_pool, chosen(kEndFrames, end_frames), pads_zero, {}};
    std::map<const char*, Pairs> tables;  // by where Python keeps them
    std::vector<Pairs> table_of;
    for (const nb::bytes& bytes : pairs) {
        if (bytes.size() != 65536 && view.pixels == Pixels::kGrayOfRgb)
            throw nb::value_error("the gray values of pairs of colours are 65536 bytes");
        Pairs& table = tables[bytes.c_str()];
        const auto* data = reinterpret_cast<const uint8_t*>(bytes.c_str());
        if (!table) table = std::make_shared<const std::vector<uint8_t>>(data, data + bytes.size());
        table_of.push_back(table);
    }
    const VectorSettings vector{batch_size, threads, first_core, chosen(kAutoresets, autoreset)};
    std::vector<Vector::Member> members;
    {
        const nb::gil_scoped_release release;
        std::map<int, std::shared_ptr<const Scaler>> scalers;  // by height of the picture
        std::map<const Game*, const Environment*> twins;
        for (size_t i = 0; i < size; ++i) {
            const Environment*& twin = twins[games[i].get()];
            const Seed seed = seed_of(seeds, i);
            auto environment = std::make_unique<Environment>(games[i], settings, seed.emulator, twin);
            if (!twin) twin = environment.get();
            if (modes[i]) environment->set_mode(*modes[i]);
            if (difficulties[i]) environment->set_difficulty(*difficulties[i]);
            auto& scaler = scalers[environment->height()];
            if (!scaler && view.pixels != Pixels::kNone)
                scaler = std::make_shared<const Scaler>(environment->height(), height, width);
            view.pairs = table_of[i];
            const std::vector<int>& own = action_sets[i];
            const auto has = [&](int action) { return std::find(own.begin(), own.end(), action) != own.end(); };
            const Start start{has(0), has(1), own.size() > 2 ? own[2] : 0};
            members.push_back({make_player(protocol, std::move(environment), play, view, scaler, start, seed), actions[i]});
        }
    }
    new (self) BoundVector(std::move(members), vector);
}

nb::object screen_of(BoundVector& vector, int environment) {
    const auto height = vector.ask<size_t>(environment, [](Environment& e) { return e.height(); });
    auto* bytes = new uint8_t[height * kScreenWidth * 3];
    nb::capsule owner(bytes, [](void* memory) noexcept { delete[] static_cast<uint8_t*>(memory); });
    vector.ask<int>(environment, [&](Environment& e) {
        e.screen_rgb(bytes);
        return 0;
    });
    const size_t shape[3] = {height, kScreenWidth, 3};
    return nb::cast(nb::ndarray<nb::numpy, uint8_t, nb::c_contig, nb::device::cpu>(bytes, 3, shape, owner));
}

}  // namespace

#define ARRAY(type) "numpy.typing.NDArray[numpy." type "]"

void register_vector(nb::module_& m) {
    nb::class_<BoundBatch>(m, "Batch", "Arrays for the results of a batch. Threads write to them between start and receive.")
        .def("__init__", &make_batch, "vector"_a, nb::kw_only(), "pixels"_a.none(), "ram"_a.none(), "final_pixels"_a.none(),
             "final_ram"_a.none(), "numbers"_a, "flags"_a,
             nb::sig("def __init__(self, vector: Vector, *, pixels: " ARRAY("uint8") " | None, ram: " ARRAY("uint8")
                     " | None, final_pixels: " ARRAY("uint8") " | None, final_ram: " ARRAY("uint8")
                     " | None, numbers: " ARRAY("int32") ", flags: " ARRAY("bool") ") -> None"),
             "`numbers` is int32 (8, rows): reward, environment, lives, frame and episode frame number, and the last three\n"
             "of the final observation; `flags` bool (3, rows): terminated, truncated, has a final observation.");
    nb::class_<MemberState>(m, "MemberState", "The state of an environment of a vector, in memory. It can be pickled.")
        .def("__getstate__",
             [](const MemberState& state) {
                 if (!state.snapshot) return std::tuple(nb::bytes(state.bytes.data(), state.bytes.size()), state.image);
                 const std::vector<uint8_t> bytes = state.snapshot->bytes();
                 return std::tuple(nb::bytes(bytes.data(), bytes.size()), image_digest(*state.snapshot->game));
             })
        .def("__setstate__", [](MemberState& state, const std::tuple<nb::bytes, uint64_t>& pickled) {
            const auto& [bytes, image] = pickled;
            const auto* data = reinterpret_cast<const uint8_t*>(bytes.c_str());
            new (&state) MemberState{nullptr, {data, data + bytes.size()}, image};
        });
    nb::class_<BoundVector>(m, "Vector", "Environments played by a pool of threads. Use it through atari.AtariVectorEnv.")
        .def("__init__", &make_vector, nb::kw_only(), "games"_a, "actions"_a, "action_sets"_a, "modes"_a, "difficulties"_a,
             "seeds"_a, "pairs"_a, "repeat_action_probability"_a, "episode_limit"_a, "protocol"_a, "frame_skip"_a,
             "noops"_a, "fire_counts"_a, "fire"_a, "episodic_life"_a, "life_loss_info"_a, "on_reset"_a, "last_life"_a,
             "seamless_lives"_a, "clip_reward"_a, "max_frames"_a, "pixels"_a, "height"_a, "width"_a, "stack"_a,
             "max_pool"_a, "end_frames"_a, "pads_zero"_a, "batch_size"_a, "threads"_a, "first_core"_a, "autoreset"_a,
             nb::sig("def __init__(self, *, games: Sequence[Game], actions: Sequence[Sequence[int]], "
                     "action_sets: Sequence[Sequence[int]], modes: Sequence[int | None], "
                     "difficulties: Sequence[int | None], seeds: " ARRAY("uint32") ", pairs: Sequence[bytes], "
                     "repeat_action_probability: float, episode_limit: int, protocol: str, frame_skip: tuple[int, int], "
                     "noops: tuple[int, int], fire_counts: bool, fire: str, episodic_life: bool, life_loss_info: bool, "
                     "on_reset: str, last_life: bool, seamless_lives: bool, clip_reward: bool, max_frames: int, "
                     "pixels: str, height: int, width: int, stack: int, max_pool: bool, end_frames: str, "
                     "pads_zero: bool, batch_size: int, threads: int, first_core: int, autoreset: str) -> None"),
             "`seeds` is (environments, 9): the emulator's, and eight words for the other generator.")
        .def("start", &BoundVector::start, "actions"_a, "strengths"_a.none(), "batch"_a.none(),
             nb::sig("def start(self, actions: " ARRAY("int64") ", strengths: " ARRAY("float32")
                     " | None, batch: Batch | None) -> None"),
             "Begin a step of the environments of the last batch; the batch is where results go if it is of all of them.")
        .def("reset", &BoundVector::reset, "mask"_a, "seeded"_a, "seeds"_a, "batch"_a.none(),
             nb::sig("def reset(self, mask: " ARRAY("bool") ", seeded: " ARRAY("bool") ", seeds: " ARRAY("uint32")
                     ", batch: Batch | None) -> None"),
             "Begin a reset of the environments in `mask`; `seeds` as above.")
        .def("receive", &BoundVector::receive, "batch"_a, "Wait for a batch of results.")
        .def("snapshot", &BoundVector::snapshot, "environments"_a)
        .def("restore", &BoundVector::restore, "environments"_a, "states"_a)
        .def("fork", &BoundVector::fork, "source"_a, "targets"_a)
        .def("save", &BoundVector::save, "environment"_a, "The state of one environment as bytes.")
        .def("load", &BoundVector::load, "environment"_a, "state"_a)
        .def("screen_rgb", &screen_of, "environment"_a,
             nb::sig("def screen_rgb(self, environment: int) -> " ARRAY("uint8")))
        .def("ram", [](BoundVector& x, int i) {
                 const auto ram = x.ask<std::vector<uint8_t>>(i, [](Environment& e) {
                     return std::vector<uint8_t>(e.ram(), e.ram() + 128);
                 });
                 return nb::bytes(ram.data(), ram.size());
             }, "environment"_a)
        .def("set_ram", [](BoundVector& x, int i, int index, int value) {
                 x.ask<int>(i, [&](Environment& e) { e.set_ram(index & 127, value & 255); return 0; });
             }, "environment"_a, "index"_a, "value"_a)
        .def("numbers", [](BoundVector& x, int i) {
                 return x.ask<std::vector<int>>(i, [](Environment& e) {
                     return std::vector<int>{e.lives(), e.frame_number(), e.episode_frame_number()};
                 });
             }, "environment"_a, "Lives, frame number, episode frame number.")
        .def("mode", [](BoundVector& x, int i) { return x.ask<int>(i, [](Environment& e) { return e.mode(); }); },
             "environment"_a)
        .def("difficulty",
             [](BoundVector& x, int i) { return x.ask<int>(i, [](Environment& e) { return e.difficulty(); }); },
             "environment"_a)
        .def("set_mode", [](BoundVector& x, int i, int mode) {
                 x.ask<int>(i, [&](Environment& e) { e.set_mode(mode); return 0; });
             }, "environment"_a, "mode"_a)
        .def("set_difficulty", [](BoundVector& x, int i, int difficulty) {
                 x.ask<int>(i, [&](Environment& e) { e.set_difficulty(difficulty); return 0; });
             }, "environment"_a, "difficulty"_a);
}

}  // namespace atari
