// `_emulator.ReplayMemory`: the memory of atari/learning/memory, which validates options and makes the arrays.
// threads.hpp has the rule for locks and the GIL.

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "memory/replay_memory.hpp"
#include "arrays.hpp"
#include "threads.hpp"

namespace atari {
namespace {

using memory::Geometry;

// Arrays that are read or written without the GIL, held until the call has ended.
class Arrays {
  public:
    // Returns the memory of an array that must have `size` values.
    template <typename T>
    T* writable(nb::handle array, size_t size, const char* name) {
        T* const values = values_of<T>(array, size, name, " of its type");
        held_.push_back(nb::borrow(array));
        held_.push_back(prevent_resize(array));
        return values;
    }

    template <typename T>
    const T* readable(nb::handle array, size_t size, const char* name) {
        const T* const values = values_of<const T>(array, size, name, " of its type");
        held_.push_back(nb::borrow(array));
        return values;
    }

  private:
    std::vector<nb::object> held_;
};

// The memory that Python threads share. The block is an object that Python releases.
class BoundMemory : Exclusive {
  public:
    BoundMemory(const Geometry& geometry, nb::object block) : block_(std::move(block)) {
        uint8_t* const bytes = arrays_.writable<uint8_t>(block_, memory::Layout(geometry).bytes, "the block");
        memory_ = std::make_unique<memory::ReplayMemory>(geometry, bytes);
    }

    template <typename Work>
    auto use(Work&& work) {
        return locked([&] {
            check_process(process_, "replay memory");
            return work(*memory_);
        });
    }

    template <typename Work>
    auto use_briefly(Work&& work) {
        return briefly([&] {
            check_process(process_, "replay memory");
            return work(*memory_);
        });
    }

    const Geometry& geometry() const { return memory_->geometry(); }
    nb::object block() const { return block_; }

  private:
    const uint32_t process_ = process_generation;
    nb::object block_;
    Arrays arrays_;
    std::unique_ptr<memory::ReplayMemory> memory_;
};

// A method of `ReplayMemory`, bound as one of `BoundMemory`: without the GIL, or for work that takes little time.
template <auto method, typename... Arguments>
auto call(BoundMemory& bound, Arguments... arguments) {
    return bound.use([&](memory::ReplayMemory& memory) { return (memory.*method)(arguments...); });
}
template <auto method, typename... Arguments>
auto call_briefly(BoundMemory& bound, Arguments... arguments) {
    return bound.use_briefly([&](memory::ReplayMemory& memory) { return (memory.*method)(arguments...); });
}

std::vector<const uint8_t*> parts_of(Arrays& arrays, const Geometry& geometry, const std::vector<nb::object>& frames) {
    std::vector<const uint8_t*> result;
    if (frames.size() != geometry.parts.size()) throw std::invalid_argument("there must be an array for each part");
    for (size_t part = 0; part < frames.size(); ++part)
        result.push_back(arrays.readable<uint8_t>(
            frames[part], static_cast<size_t>(geometry.lanes) * geometry.parts[part].bytes, "observations"));
    return result;
}

// The arrays of one batch, checked once. Their shapes must not change while this exists.
struct BoundTarget {
    Arrays arrays;
    memory::Target target{};
    std::vector<int> stacks;
    int64_t count = 0, length = 0;  // `length` is 0 for transitions

    BoundTarget(const BoundMemory& memory, int64_t count, int64_t length, std::vector<int> stacks,
                const std::vector<nb::object>& observations, const std::vector<nb::object>& next, nb::object actions,
                nb::object rewards, nb::object terminated, nb::object truncated, nb::object indices,
                nb::object discounts, nb::object weights, nb::object mask)
        : stacks(std::move(stacks)), count(count), length(length) {
        const Geometry& geometry = memory.geometry();
        const size_t parts = geometry.parts.size();
        action_bytes = geometry.action_bytes;
        for (const memory::Part& part : geometry.parts) frame_bytes.push_back(part.bytes);
        if (count < 1 || count > (1 << 24) || length < 0 || length > (1 << 24))
            throw std::invalid_argument("batch_size and length must be within 1..16777216");
        const bool has_next = !next.empty();
        if (observations.size() != parts || (has_next && (length || next.size() != parts)) ||
            this->stacks.size() != parts)
            throw std::invalid_argument("there must be an array and a number of frames for each part");
        const auto rows = static_cast<size_t>(count), steps = rows * static_cast<size_t>(length ? length : 1);
        const size_t shown = length ? rows * static_cast<size_t>(length + 1) : rows;
        for (size_t part = 0; part < parts; ++part) {
            const int stack = this->stacks[part];
            if (stack < 1 || stack > geometry.parts[part].stack)
                throw std::invalid_argument("stack_num must be within 1.." +
                                            std::to_string(geometry.parts[part].stack) +
                                            ", the stack_num of the memory");
            const auto frames = static_cast<size_t>(stack + (length || has_next ? 0 : 1));
            const size_t size = shown * frames * geometry.parts[part].bytes;
            target.observations.push_back(arrays.writable<uint8_t>(observations[part], size, "observations"));
            if (has_next) target.next.push_back(arrays.writable<uint8_t>(next[part], size, "next_observations"));
        }
        target.actions = arrays.writable<uint8_t>(actions, steps * geometry.action_bytes, "actions");
        target.rewards = arrays.writable<float>(rewards, steps, "rewards");
        target.terminated = reinterpret_cast<uint8_t*>(arrays.writable<bool>(terminated, steps, "terminations"));
        target.truncated = reinterpret_cast<uint8_t*>(arrays.writable<bool>(truncated, steps, "truncations"));
        target.indices = arrays.writable<int64_t>(indices, rows, "indices");
        if (length) {
            target.mask = reinterpret_cast<uint8_t*>(arrays.writable<bool>(mask, steps, "mask"));
        } else {
            target.discounts = arrays.writable<float>(discounts, rows, "discounts");
            target.weights = arrays.writable<float>(weights, rows, "weights");
        }
    }

    // Returns whether a batch of a memory of this geometry has these sizes.
    bool fits(const Geometry& geometry) const {
        bool same = geometry.action_bytes == action_bytes && geometry.parts.size() == frame_bytes.size();
        for (size_t part = 0; same && part < frame_bytes.size(); ++part)
            same = geometry.parts[part].bytes == frame_bytes[part];
        return same;
    }

  private:
    size_t action_bytes = 0;
    std::vector<size_t> frame_bytes;  // by part
};

void make_geometry(Geometry* self, int64_t lanes, int64_t rows, int64_t margin, int64_t finals,
                   const std::vector<std::tuple<size_t, size_t, int>>& parts, size_t action_bytes, int autoreset,
                   bool repeat_first, std::optional<double> exponent, bool saved, std::optional<size_t> packed_bytes) {
    Geometry geometry{};
    geometry.lanes = lanes;
    geometry.rows = rows;
    geometry.margin = margin;
    geometry.finals = finals;
    for (const auto& [bytes, pitch, stack] : parts) geometry.parts.push_back({bytes, pitch, stack});
    geometry.action_bytes = action_bytes;
    if (autoreset < 0 || autoreset > 2) throw std::invalid_argument("there is no such autoreset mode");
    geometry.autoreset = static_cast<memory::Autoreset>(autoreset);
    geometry.repeat_first = repeat_first;
    geometry.prioritised = exponent.has_value();
    geometry.exponent = exponent.value_or(0);
    geometry.saved = saved;
    geometry.compressed = packed_bytes.has_value();
    geometry.packed_bytes = packed_bytes.value_or(0);
    geometry.check();
    new (self) Geometry(std::move(geometry));
}

void add(BoundMemory& bound, nb::object actions, nb::object rewards, nb::object terminated, nb::object truncated,
         const std::vector<nb::object>& finals) {
    const Geometry& geometry = bound.geometry();
    const auto lanes = static_cast<size_t>(geometry.lanes);
    Arrays arrays;
    memory::StepResults results{};
    results.actions = arrays.readable<uint8_t>(actions, lanes * geometry.action_bytes, "actions");
    results.rewards = arrays.readable<float>(rewards, lanes, "rewards");
    results.terminated = reinterpret_cast<const uint8_t*>(arrays.readable<bool>(terminated, lanes, "terminations"));
    results.truncated = reinterpret_cast<const uint8_t*>(arrays.readable<bool>(truncated, lanes, "truncations"));
    if (!finals.empty()) results.finals = parts_of(arrays, geometry, finals);
    const auto work = [&](memory::ReplayMemory& memory) { memory.add(results); };
    // Checksums and compression take longer than releasing the GIL.
    if (geometry.saved || geometry.compressed) bound.use(work);
    else bound.use_briefly(work);
}

// Copies rewards of type T as floats. Returns false if they have another type or shape, or if one is not finite then.
template <typename T>
bool get_rewards(nb::handle rewards, size_t lanes, std::vector<float>& values) {
    Values<const T> given;
    if (!nb::try_cast(rewards, given, false) || given.ndim() != 1 || given.size() != lanes) return false;
    values.assign(given.data(), given.data() + lanes);
    return std::all_of(values.begin(), values.end(), [](float value) { return std::isfinite(value); });
}

// Does the same as `add` for the arrays that environments usually return, and checks them faster than Python. For other
// arrays, for ends in SAME_STEP, and for a memory with a file, changes nothing and returns false.
bool try_add(BoundMemory& bound, nb::handle actions, nb::handle rewards, nb::handle terminated, nb::handle truncated) {
    const Geometry& geometry = bound.geometry();
    const auto lanes = static_cast<size_t>(geometry.lanes);
    Values<const int64_t> indices;
    Values<const bool> flags[2];
    std::vector<float> values;
    if (geometry.action_bytes != sizeof(int64_t) || geometry.saved || geometry.compressed ||
        !nb::try_cast(actions, indices, false) || indices.ndim() != 1 || indices.size() != lanes ||
        !(get_rewards<int32_t>(rewards, lanes, values) || get_rewards<double>(rewards, lanes, values)) ||
        !nb::try_cast(terminated, flags[0], false) || flags[0].ndim() != 1 || flags[0].size() != lanes ||
        !nb::try_cast(truncated, flags[1], false) || flags[1].ndim() != 1 || flags[1].size() != lanes)
        return false;
    const auto* const ends = reinterpret_cast<const uint8_t*>(flags[0].data());
    const auto* const cuts = reinterpret_cast<const uint8_t*>(flags[1].data());
    const auto ended = [&](const uint8_t* all) { return std::find(all, all + lanes, uint8_t{1}) != all + lanes; };
    if (geometry.autoreset == memory::Autoreset::kSameStep && (ended(ends) || ended(cuts))) return false;
    const memory::StepResults results{reinterpret_cast<const uint8_t*>(indices.data()), values.data(), ends, cuts, {}};
    return bound.use_briefly([&](memory::ReplayMemory& memory) {
        const bool started = memory.state().started != 0;
        if (started) memory.add(results);
        return started;
    });
}

void reset(BoundMemory& bound, nb::object mask, const std::vector<nb::object>& frames) {
    if (mask.is_none()) {
        bound.use([](memory::ReplayMemory& memory) { memory.reset(); });
        return;
    }
    Arrays arrays;
    const auto* const chosen = reinterpret_cast<const uint8_t*>(
        arrays.readable<bool>(mask, static_cast<size_t>(bound.geometry().lanes), "mask"));
    const std::vector<const uint8_t*> parts = parts_of(arrays, bound.geometry(), frames);
    bound.use([&](memory::ReplayMemory& memory) { memory.reset(chosen, parts); });
}

void observe(BoundMemory& bound, const std::vector<int>& stacks, const std::vector<nb::object>& to) {
    const Geometry& geometry = bound.geometry();
    if (stacks.size() != geometry.parts.size() || to.size() != stacks.size())
        throw std::invalid_argument("there must be an array and a number of frames for each part");
    Arrays arrays;
    std::vector<uint8_t*> parts;
    for (size_t part = 0; part < to.size(); ++part) {
        const int stack = std::clamp(stacks[part], 1, geometry.parts[part].stack);
        parts.push_back(arrays.writable<uint8_t>(
            to[part], static_cast<size_t>(geometry.lanes) * geometry.parts[part].bytes * static_cast<size_t>(stack),
            "observations"));
    }
    bound.use([&](memory::ReplayMemory& memory) { memory.observe(stacks, parts); });
}

void sample(BoundMemory& bound, BoundTarget& target, int64_t reach, double discount, std::optional<double> beta,
            int threads) {
    if (!target.fits(bound.geometry())) throw std::invalid_argument("the batch was made for another memory");
    const memory::Choice choice{target.count, target.length ? target.length : reach, discount, beta, target.stacks,
                                threads};
    const nb::object held = nb::find(target);
    bound.use([&](memory::ReplayMemory& memory) {
        if (target.length) memory.sample_sequences(choice, target.target);
        else memory.sample(choice, target.target);
    });
}

void save_copy(BoundMemory& bound, nb::object block) {
    Arrays arrays;
    auto* const bytes = arrays.writable<uint8_t>(block, memory::Layout(bound.geometry()).bytes, "the block");
    bound.use([&](memory::ReplayMemory& memory) { memory.save_copy(bytes); });
}

void update_priorities(BoundMemory& bound, nb::object indices, nb::object priorities) {
    Arrays arrays;
    Values<const int64_t> given;
    if (!nb::try_cast(nb::handle(indices), given, false)) refuse_type("indices must be int64");
    const auto* const priority = arrays.readable<double>(priorities, given.size(), "priorities");
    const std::vector<int64_t> steps(given.data(), given.data() + given.size());
    const std::vector<double> values(priority, priority + given.size());
    bound.use([&](memory::ReplayMemory& memory) {
        memory.update_priorities(steps.data(), values.data(), static_cast<int64_t>(steps.size()));
    });
}

}  // namespace

void register_memory(nb::module_& m) {
    nb::register_exception_translator([](const std::exception_ptr& error, void*) {
        try {
            std::rethrow_exception(error);
        } catch (const memory::Overwrites& overwrites) {
            PyErr_SetString(PyExc_BufferError, overwrites.what());
        }
    });
    nb::class_<Geometry>(m, "ReplayGeometry", "The sizes of a replay memory. ValueError if a number is out of range.")
        .def("__init__", &make_geometry, nb::kw_only(), "lanes"_a, "rows"_a, "margin"_a, "finals"_a, "parts"_a,
             "action_bytes"_a, "autoreset"_a, "repeat_first"_a, "exponent"_a.none(), "saved"_a, "packed_bytes"_a.none(),
             "`rows` and `margin` are steps of each lane. Each of `parts` has the bytes of a frame, the bytes from a\n"
             "pixel to the one below, and the most frames of an observation. `autoreset` is 0 NEXT_STEP, 1\n"
             "SAME_STEP, 2 DISABLED. With `packed_bytes`, the compressed frames get this number of bytes.")
        .def_static("least_packed_bytes", &memory::least_packed_bytes, "geometry"_a,
                    "The least `packed_bytes` with which a memory of these sizes works.")
        .def_prop_ro(
            "block_bytes", [](const Geometry& geometry) { return memory::Layout(geometry).bytes; },
            "Bytes of the block that holds a memory of these sizes.")
        .def_prop_ro(
            "packed_offset", [](const Geometry& geometry) { return memory::Layout(geometry).packed; },
            "The offset of the compressed frames, which are written when they are needed.");
    nb::class_<BoundMemory>(m, "ReplayMemory",
                            "The frames and steps of a replay memory. Use it through atari.learning.")
        .def(
            "__init__",
            [](BoundMemory* self, const Geometry& geometry, nb::object block) {
                new (self) BoundMemory(geometry, std::move(block));
            },
            "geometry"_a, "block"_a,
            nb::sig("def __init__(self, geometry: ReplayGeometry, block: " NDARRAY("uint8") ") -> None"),
            "`block` has `geometry.block_bytes` bytes: zeros, or a memory of this geometry; then call `load`.")
        .def(
            "next_place",
            [](BoundMemory& bound) {
                return bound.use_briefly([](memory::ReplayMemory& memory) {
                    memory.check_row();
                    return memory.next_place();
                });
            },
            "The place of the next row's frames, in 0 .. places-1. BufferError if a save is due.")
        .def(
            "places",
            [](BoundMemory& bound, size_t part) {
                return bound.use_briefly([&](memory::ReplayMemory& memory) {
                    if (part >= memory.geometry().parts.size()) throw std::out_of_range("there is no such part");
                    return std::pair(memory.frames_offset(part), memory.places());
                });
            },
            "part"_a, "The offset of a part's frames in the block, and the number of rows that have a place.")
        .def("seed", &call_briefly<&memory::ReplayMemory::seed, uint64_t>, "seed"_a)
        .def("reset", &reset, "mask"_a.none(), "frames"_a,
             nb::sig(
                 "def reset(self, mask: " NDARRAY("bool") " | None, frames: Sequence[" NDARRAY("uint8") "]) -> None"),
             "Begin episodes in all lanes with the next row's frames, or in the lanes of `mask` with `frames`.")
        .def("add", &add, "actions"_a, "rewards"_a, "terminated"_a, "truncated"_a, "finals"_a,
             nb::sig(
                 "def add(self, actions: " NDARRAY("uint8") ", rewards: " NDARRAY("float32") ", terminated: " NDARRAY(
                     "bool") ", truncated: " NDARRAY("bool") ", finals: Sequence[" NDARRAY("uint8") "]) -> None"),
             "Complete a step of all lanes, after the next row's frames were written. `actions` are bytes.")
        .def("try_add", &try_add, "actions"_a.none(), "rewards"_a.none(), "terminated"_a.none(), "truncated"_a.none(),
             nb::sig("def try_add(self, actions: object, rewards: object, terminated: object, truncated: object) "
                     "-> bool"),
             "Call `add` if the arrays are int64, int32 or float64, and bool with one axis; returns whether they are.")
        .def("observe", &observe, "stacks"_a, "to"_a,
             nb::sig("def observe(self, stacks: Sequence[int], to: Sequence[" NDARRAY("uint8") "]) -> None"))
        .def("count", &call_briefly<&memory::ReplayMemory::count, int64_t>, "reach"_a)
        .def("sample", &sample, "target"_a, "reach"_a, "discount"_a, "beta"_a.none(), "threads"_a)
        .def("update_priorities", &update_priorities, "indices"_a, "priorities"_a,
             nb::sig("def update_priorities(self, indices: " NDARRAY("int64") ", priorities: " NDARRAY(
                 "float64") ") -> None"))
        .def_prop_ro(
            "must_save", &call_briefly<&memory::ReplayMemory::must_save>,
            "Whether the next `add` or `reset` may raise BufferError, because it would overwrite the last saved state.")
        .def("begin_save", &call<&memory::ReplayMemory::begin_save>,
             "The first of the three phases of a save, which makes the present state the one that `load` finds. After\n"
             "each, the block must reach the disk. `end_save` counts the save.")
        .def("write_save", &call<&memory::ReplayMemory::write_save>)
        .def("complete_save", &call<&memory::ReplayMemory::complete_save>)
        .def("end_save", &call_briefly<&memory::ReplayMemory::end_save>)
        .def("save_copy", &save_copy, "block"_a, nb::sig("def save_copy(self, block: " NDARRAY("uint8") ") -> None"),
             "Save the present state in a copy of the block.")
        .def("load", &call<&memory::ReplayMemory::load, bool, std::optional<uint64_t>>, "verify"_a, "save"_a.none(),
             "Read the last saved state, or the state of the save with this number; ValueError says what is damaged.\n"
             "`verify` reads all frames. Then the block must reach the disk, and `resume` ends the work.")
        .def("resume", &call<&memory::ReplayMemory::resume>)
        .def_prop_ro(
            "numbers",
            [](BoundMemory& bound) {
                return bound.use_briefly([](memory::ReplayMemory& memory) {
                    const memory::State& state = memory.state();
                    return std::tuple(state.started != 0, state.steps, memory.saves(), memory.used_bytes());
                });
            },
            "Whether there was a reset, the steps ever added, the saves, and the bytes in use.");
    nb::class_<BoundTarget>(m, "ReplayTarget", "The arrays of a batch. `sample` writes to them.")
        .def(
            nb::init<const BoundMemory&, int64_t, int64_t, std::vector<int>, const std::vector<nb::object>&,
                     const std::vector<nb::object>&, nb::object, nb::object, nb::object, nb::object, nb::object,
                     nb::object, nb::object, nb::object>(),
            "memory"_a, "count"_a, "length"_a, "stacks"_a, "observations"_a, "next_observations"_a, "actions"_a,
            "rewards"_a, "terminations"_a, "truncations"_a, "indices"_a, "discounts"_a.none(), "weights"_a.none(),
            "mask"_a.none(),
            nb::sig(
                "def __init__(self, memory: ReplayMemory, count: int, length: int, stacks: Sequence[int], "
                "observations: Sequence[" NDARRAY("uint8") "], next_observations: Sequence[" NDARRAY("uint8") "], actions: " NDARRAY("uint8") ", rewards: " NDARRAY("float32") ", terminations: " NDARRAY(
                    "bool") ", truncations: " NDARRAY("bool") ", indices: " NDARRAY("int64") ", discounts: " NDARRAY("float32") " | None, weights: " NDARRAY("float32") " | None, mask: " NDARRAY("bool") " | None) -> None"),
            "`length` is the length of sequences, which have a mask; for transitions it is 0. Transitions of one\n"
            "step may have no `next_observations`; then each observation has one more frame, the newest frame of\n"
            "the next one.");
}

}  // namespace atari
