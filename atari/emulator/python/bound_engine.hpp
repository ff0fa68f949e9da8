// `BoundEngine`: the vector engine, shared by the threads of Python and of compiled functions (binding_xla.cpp).
#pragma once

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "ale/programs/labels.hpp"
#include "arrays.hpp"
#include "state.hpp"
#include "threads.hpp"
#include "vector/lanes.hpp"

namespace atari {

using Seeds = Table<const uint32_t>;

inline SeedWords words_of(const Seeds& seeds, size_t i) {
    SeedWords words;
    for (size_t word = 0; word < words.size(); ++word) words[word] = seeds(i, word);
    return words;
}

// A batch whose observations are the user's arrays.
struct BoundBatch {
    Batch batch;
    BatchShape shape;
    std::vector<nb::object> observations;  // the arrays, and weak references to them, see `prevent_resize`
    std::shared_ptr<BatchMemory> memory;   // the other arrays
};

// A sequence that an engine plays, with the sizes of its results.
struct BoundSequence {
    std::shared_ptr<Sequence> sequence;
    size_t lanes, players;
};

// The state of a lane in memory. After unpickling it consists of bytes, and `snapshot` is null.
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

// The engine that Python threads share. The GIL is released while environments are played or waited for.
class BoundEngine : Exclusive {
  public:
    static constexpr size_t kMostSteps = 1'000'000;  // of a sequence

    explicit BoundEngine(std::unique_ptr<VectorEngine> engine) : engine_(std::move(engine)) {}

    // Joins the threads, which may still write to `current_`.
    ~BoundEngine() {
        const GilRelease release;
        engine_.reset();
    }

    void start(List<const int64_t> actions, std::optional<List<const float>> strengths, nb::object batch,
               std::optional<List<const int64_t>> environments) {
        launch(actions, strengths, std::move(batch), environments, nullptr);
    }

    BoundSequence play(List<const int64_t> actions, std::optional<List<const float>> strengths, nb::object batch,
                       std::optional<List<const int64_t>> environments, size_t steps, double discount, bool stops,
                       bool every) {
        if (queued()) throw std::invalid_argument("a sequence is played in batches of all environments");
        if (steps < 1 || steps > kMostSteps)
            throw std::invalid_argument("a sequence has 1 to " + std::to_string(kMostSteps) + " steps, got " +
                                        std::to_string(steps));
        if (!std::isfinite(discount)) throw std::invalid_argument("discount must be finite");
        const auto sequence = std::make_shared<Sequence>();
        sequence->steps = steps;
        sequence->discount = discount;
        sequence->stops = stops;
        sequence->every = every;
        launch(actions, strengths, std::move(batch), environments, sequence);
        return {sequence, static_cast<size_t>(engine_->size()), players()};
    }

    void reset(List<const bool> mask, List<const bool> seeded, Seeds seeds, nb::object batch, bool new_games) {
        const auto size = static_cast<size_t>(engine_->size());
        if (mask.shape(0) != size || seeded.shape(0) != size || seeds.shape(0) != size ||
            seeds.shape(1) != SeedWords{}.size())
            throw std::invalid_argument("there must be an entry for each environment");
        std::vector<Seed> values(size);
        std::vector<const Seed*> given(size);
        std::vector<bool> which(size);
        for (size_t i = 0; i < size; ++i) {
            values[i] = seed_of(words_of(seeds, i));
            given[i] = seeded(i) ? &values[i] : nullptr;
            which[i] = mask(i);
        }
        const Batch* const target = checked(batch, 1);
        locked([&] {
            check_process(process_, "vector environment");
            if (std::find(which.begin(), which.end(), false) != which.end()) check_unfailed();
            engine_->drain();
            std::swap(current_, batch);
            target_ = target;
            sent_ = true;
            ready_ = failed_ = false;
            order_.clear();
            engine_->reset(which, given, target, new_games);
        });
    }

    bool receive(const BoundBatch& batch) {
        return locked([&] {
            if (target_ != &batch.batch) check_size(batch, 1);
            check_process(process_, "vector environment");
            if (!sent_) throw std::runtime_error("no step has been started");
            if (target_ && target_ != &batch.batch)
                throw std::invalid_argument("the step was started with another batch");
            sent_ = ready_ = false;
            const bool ended = engine_->receive(batch.batch);
            ready_ = true;
            return ended;
        });
    }

    // Returns whether a batch has been sent and not received.
    bool sent() const { return sent_; }

    // The calls of compiled functions (binding_xla.cpp). Their threads do not have the GIL and never wait for it. All
    // other calls wait until such a call has ended.
    //
    // Plays a step of the environments of the last batch.
    void step_natively(const std::vector<int64_t>& actions, const Batch& batch) {
        natively([&] {
            check_ready();
            begin(actions, std::vector<float>(actions.size(), 1.0f), nullptr, queued() ? nullptr : &batch, nullptr,
                  [] {});
            finish(batch);
        });
    }

    // Begins a step. A batch of all environments is written to `staging`, until it is received or forgotten.
    void send_natively(const std::vector<int64_t>& actions, const std::vector<int64_t>* environments,
                       const Batch& staging) {
        natively([&] {
            check_ready();
            if (environments && environments->size() != rows())
                throw std::invalid_argument("env_id must have as many rows as a batch");
            begin(actions, std::vector<float>(actions.size(), 1.0f), environments, queued() ? nullptr : &staging,
                  nullptr, [] {});
        });
    }

    // Waits for the step that a compiled function, or Python, has begun.
    void receive_natively(const Batch& out) {
        natively([&] {
            check_process(process_, "vector environment");
            if (!sent_) throw std::runtime_error("nothing has been sent; call send or envs.reset_async first");
            if (!order_.empty() && order_.size() != rows())
                throw std::runtime_error("a step of some environments was sent; receive it by envs.recv()");
            const Batch* const written = target_;
            finish(written ? *written : out);
            if (written) copy_rows(*written, out);
        });
    }

    // Waits until nothing is written to `staging`. Results that were not received are dropped.
    void forget_natively(const Batch& staging) {
        if (process_ != process_generation) return;  // The threads are in another process.
        natively([&] {
            if (target_ != &staging) return;
            engine_->drain();
            target_ = nullptr;
            if (sent_) failed_ = true;
            sent_ = false;
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

    void restore(const std::vector<int>& environments, const std::vector<const BoundSnapshot*>& states,
                 bool own_generators) {
        if (environments.size() != states.size())
            throw std::invalid_argument("there must be a snapshot for each environment");
        std::vector<BoundSnapshot> copies;  // Another thread may drop the list.
        for (const BoundSnapshot* state : states) copies.push_back(state ? *state : BoundSnapshot{});
        locked([&] {
            check_idle(environments);
            std::vector<VectorEngine::Snapshot> snapshots;
            for (size_t i = 0; i < copies.size(); ++i) {
                snapshots.push_back(copies[i].within(*engine_, environments[i]));
                if (!snapshots[i])
                    throw std::invalid_argument("snapshot " + std::to_string(i) +
                                                " is of another game than environment " +
                                                std::to_string(environments[i]) + ", or was taken with other options");
            }
            for (size_t i = 0; i < copies.size(); ++i)
                engine_->restore(environments[i], std::move(snapshots[i]), own_generators);
        });
    }

    nb::bytes save(int environment) {
        const auto state = locked([&] {
            check_idle({environment});
            std::vector<uint8_t> bytes(engine_->state_size(environment));
            engine_->save(environment, bytes.data());
            return bytes;
        });
        return bytes_of(state);
    }

    void load(int environment, nb::bytes state) {
        const auto* const bytes = static_cast<const uint8_t*>(state.data());
        const size_t size = state.size();
        const bool good = locked([&] {
            check_idle({environment});
            return size == engine_->state_size(environment) && (ready_ = engine_->load(environment, bytes));
        });
        if (!good) throw std::invalid_argument("the state is damaged, or of another game or version");
    }

    // Calls `get(environment)` while no environment is being played.
    template <typename Get>
    auto get(int environment, Get&& get) {
        if (briefly([&] { return engine_->pending() > 0; })) return get_slowly(environment, get);
        return briefly([&] {
            check_received({environment});
            return get(engine_->lane(environment).environment());
        });
    }

    // Does the same as `get`, without the GIL.
    template <typename Get>
    auto get_slowly(int environment, Get&& get) {
        return locked([&] {
            check_idle({environment});
            return get(engine_->lane(environment).environment());
        });
    }

    bool ended(int environment) {
        return get(environment, [&](Environment&) { return engine_->ended(environment); });
    }

    void record_moves(int environment) {
        get(environment, [&](Environment&) { engine_->lane(environment).game().record_moves(); });
    }
    std::vector<std::pair<int, float>> take_moves(int environment) {
        return get(environment, [&](Environment&) { return engine_->lane(environment).game().take_moves(); });
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
            return engine_->pending() == 0 ||
                   std::all_of(environments.begin(), environments.end(), [&](int environment) {
                       return std::find(recent.begin(), recent.end(), environment) != recent.end();
                   });
        });
        if (received)
            briefly([&] {
                check_received(environments);
                copy();
            });
        else
            locked([&] {
                check_idle(environments);
                copy();
            });
        return rams;
    }

    size_t rows() const { return static_cast<size_t>(engine_->batch_size()); }
    size_t players() const { return static_cast<size_t>(engine_->players()); }
    BatchShape shape(bool pixels, bool ram) const { return engine_->shape(pixels, ram); }

  private:
    void launch(List<const int64_t> actions, const std::optional<List<const float>>& strengths, nb::object batch,
                const std::optional<List<const int64_t>>& environments, const std::shared_ptr<Sequence>& sequence) {
        const std::vector<int64_t> indices(actions.data(), actions.data() + actions.size());
        std::vector<int64_t> numbers;
        if (environments) numbers.assign(environments->data(), environments->data() + environments->size());
        std::vector<float> factors(indices.size(), 1.0f);
        if (strengths && strengths->size() != factors.size())
            throw std::invalid_argument("there must be a strength for each action");
        if (strengths) std::copy_n(strengths->data(), factors.size(), factors.begin());
        const Batch* const target = checked(batch, sequence ? sequence->rows() : 1);
        locked([&] {
            check_process(process_, "vector environment");
            begin(indices, factors, environments ? &numbers : nullptr, target, sequence,
                  [&] { std::swap(current_, batch); });
        });
    }

    // Returns the batch of an object, which threads write to. For None returns null: results then wait for `receive`.
    // The batch must have this number of rows for each environment.
    const Batch* checked(nb::handle batch, size_t rows) const {
        if (batch.is_none() && engine_->batch_size() < engine_->size()) return nullptr;
        if (batch.is_none())
            throw std::invalid_argument("a batch of all environments is written while they are played; give one");
        BoundBatch* bound = nullptr;
        if (!nb::try_cast(batch, bound) || !bound) refuse_type("the batch must be a Batch of this engine");
        check_size(*bound, rows);
        return &bound->batch;
    }

    void check_size(const BoundBatch& batch, size_t rows) const {
        BatchShape written = shape(true, true);
        written.rows *= rows;
        if (!batch.shape.fits(written))
            throw std::invalid_argument(
                "the batch is of an engine with batches, observations or players of another number");
    }

    // The functions below need the lock.
    //
    // Begins a step, or a sequence; nothing has changed if it throws. `keep()` keeps the memory of `target`.
    template <typename Keep>
    void begin(const std::vector<int64_t>& actions, const std::vector<float>& strengths,
               const std::vector<int64_t>* environments, const Batch* target, const std::shared_ptr<Sequence>& sequence,
               Keep&& keep) {
        if (sent_) throw std::runtime_error("a step has been started; receive it first");
        check_unfailed();
        std::vector<int> some;
        if (environments) some = chosen(*environments);
        const std::vector<int>& rows = environments ? some : engine_->recent();
        check_actions(rows, actions, strengths, sequence ? sequence->steps : 1);
        keep();
        target_ = target;
        sent_ = true;
        if (sequence) engine_->play(rows, actions.data(), strengths.data(), target, sequence);
        else engine_->step(rows, actions.data(), strengths.data(), target);
        order_ = queued() ? std::vector<int>() : std::move(some);
    }

    // Waits for the results. After this has returned or thrown, no thread writes to `batch`.
    void finish(const Batch& batch) {
        sent_ = ready_ = false;
        try {
            engine_->receive(batch);
        } catch (...) {
            failed_ = true;
            engine_->drain();
            target_ = nullptr;
            throw;
        }
        target_ = nullptr;
        ready_ = true;
    }

    // Throws after an error that has left environments in the middle of a step, until all have been reset.
    void check_unfailed() const {
        if (failed_) throw std::runtime_error("a compiled function has failed in a step; reset all environments first");
    }

    void check_ready() const {
        check_process(process_, "vector environment");
        if (!ready_ && !sent_ && !failed_) throw std::runtime_error("call envs.reset() before the first step");
    }

    bool queued() const { return engine_->batch_size() < engine_->size(); }

    // Copies the results of all environments, in the order in which a step has named them.
    void copy_rows(const Batch& from, const Batch& to) const {
        Batch::for_each(shape(true, true), [&](const char*, auto member, size_t width) {
            const auto* const values = from.*member;
            auto* const out = to.*member;
            if (!values || !out || values == out) return;
            for (size_t row = 0; row < rows(); ++row) {
                const size_t source = order_.empty() ? row : static_cast<size_t>(order_[row]);
                std::copy_n(values + source * width, width, out + row * width);
            }
        });
    }

    // Returns the environments of a step: any environments; but if a batch has fewer than all, those of the last batch
    // in any order.
    std::vector<int> chosen(const std::vector<int64_t>& numbers) const {
        std::vector<bool> available(static_cast<size_t>(engine_->size()));
        for (int environment : engine_->recent()) available[static_cast<size_t>(environment)] = true;
        std::vector<int> environments;
        for (size_t i = 0; i < numbers.size(); ++i) {
            const std::string which = "environment " + std::to_string(numbers[i]) + " in row " + std::to_string(i);
            if (numbers[i] < 0 || numbers[i] >= engine_->size())
                throw std::out_of_range(which + " does not exist; env_id is within 0.." +
                                        std::to_string(engine_->size() - 1));
            if (!available[static_cast<size_t>(numbers[i])])
                throw std::invalid_argument(which + " is given twice, or is not of the last batch");
            available[static_cast<size_t>(numbers[i])] = false;
            environments.push_back(static_cast<int>(numbers[i]));
        }
        if (environments.empty()) throw std::invalid_argument("env_id must name at least one environment");
        if (engine_->batch_size() < engine_->size() && environments.size() != engine_->recent().size())
            throw std::invalid_argument("with batch_size < num_envs, env_id must name all " +
                                        std::to_string(engine_->recent().size()) + " environments of the last batch");
        return environments;
    }

    void check_actions(const std::vector<int>& environments, const std::vector<int64_t>& actions,
                       const std::vector<float>& strengths, size_t steps) const {
        const auto players = static_cast<size_t>(engine_->players()), in_row = steps * players;
        if (actions.size() != environments.size() * in_row)
            throw std::invalid_argument(players == 1 ? "there must be an action for each environment of the batch"
                                                     : "there must be an action for each player of each environment");
        for (size_t i = 0; i < actions.size(); ++i) {
            const int most = engine_->actions_of(environments[i / in_row]) - 1;
            const auto row = [&] {
                const std::string step = std::to_string(i % in_row / players);
                return "row " + std::to_string(i / in_row) + (steps > 1 ? ", step " + step + "," : "");
            };
            if (actions[i] < 0 || actions[i] > most)
                throw std::invalid_argument("action " + std::to_string(actions[i]) + " in " + row() +
                                            " is not within 0.." + std::to_string(most));
            if (!(std::abs(strengths[i]) <= 1000.0f))  // negated, so that NaN fails too
                throw std::invalid_argument("the strength in " + row() +
                                            " must be finite and at most 1000 in magnitude");
        }
    }

    // Throws between `start` and `receive`. If a batch has fewer than all environments, waits for those that are not in
    // the last batch. It is therefore called without the GIL.
    void check_idle(const std::vector<int>& environments) {
        check_received(environments);
        if (engine_->pending()) engine_->settle();
    }

    void check_received(const std::vector<int>& environments) const {
        check_process(process_, "vector environment");
        if (sent_) throw std::runtime_error("environments are being played; call recv() first");
        for (int environment : environments)
            if (environment < 0 || environment >= engine_->size())
                throw std::out_of_range("there is no environment " + std::to_string(environment));
    }

    const uint32_t process_ = process_generation;
    nb::object current_;              // owns `target_`
    const Batch* target_ = nullptr;   // the threads write to it: it must outlive `engine_`
    std::atomic<bool> sent_ = false;  // whether a batch has been sent and not received
    bool ready_ = false;              // whether a batch has been received, and nothing has been sent since
    bool failed_ = false;             // whether a compiled function has failed since the last reset
    std::vector<int> order_;          // the environments that a step of all has named
    std::unique_ptr<VectorEngine> engine_;
};

using EngineClass = nb::class_<BoundEngine>;

}  // namespace atari
