// Sampling: draws steps, and writes them to a batch.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <thread>

#include "replay_memory.hpp"

namespace atari::memory {

// A transition of up to n steps; `steps` is their number. Without `complete`, neither n steps nor an end are stored.
struct ReplayMemory::Transition {
    int64_t steps;
    double reward, discount;
    bool terminated, truncated, complete;
};

// The newest frame of an observation: the frame of a row, or the final observation after the row.
struct ReplayMemory::Source {
    int64_t row;
    int64_t final;  // entry, or -1
};

// The steps that can be sampled with a reach: all valid steps before row `first`, and the steps in `newest`.
struct ReplayMemory::Span {
    int64_t first;
    int64_t older;                  // the number of valid steps before `first`
    std::vector<int64_t> newest;    // indices
    std::vector<int64_t> excluded;  // cells of valid steps from row `first` on that are not in `newest`
    int64_t count() const { return older + static_cast<int64_t>(newest.size()); }
};

// Writes observations to a batch, for one thread.
class ReplayMemory::Writer {
  public:
    explicit Writer(const ReplayMemory& memory) : memory_(memory), reader_(memory.frames_) {}

    // Writes the stack that ends with `source`. `older`, if not null, is a stack of the same size and episode that ends
    // with row `older_row`; frames that both stacks have are copied from it.
    void write(size_t part, int64_t lane, Source source, int frames, uint8_t* to, const uint8_t* older = nullptr,
               int64_t older_row = 0) {
        const size_t bytes = memory_.geometry_.parts[part].bytes;
        const int64_t head = memory_.state_.head;
        int64_t left = frames - (source.final >= 0 ? 1 : 0), first = source.row;
        while (first > 0 && source.row - first + 1 < left && !(memory_.flags(first, lane) & kFirst)) --first;
        uint8_t* next = to;
        const int64_t padding = left > 0 ? left - (source.row - first + 1) : 0;
        if (left > 0) {
            next += static_cast<size_t>(padding) * bytes;
            for (int64_t row = first; row <= source.row; ++row, next += bytes) {
                if (older && row <= older_row && row > older_row - frames)
                    std::memcpy(next, older + static_cast<size_t>(frames - 1 - (older_row - row)) * bytes, bytes);
                else reader_.read(part, row, lane, head, next, ahead(part, row));
            }
        }
        if (source.final >= 0) reader_.read_final(part, source.final, source.row, lane, head, next);
        const uint8_t* const oldest = to + static_cast<size_t>(padding) * bytes;
        for (int64_t i = 0; i < padding; ++i) {
            uint8_t* const frame = to + static_cast<size_t>(i) * bytes;
            if (memory_.geometry_.repeat_first) std::memcpy(frame, oldest, bytes);
            else std::memset(frame, 0, bytes);
        }
    }

    // Loads the frames of the step `next` while the frames of the step `now` are read.
    void look_ahead(int64_t now, int64_t next) {
        const int64_t lanes = memory_.geometry_.lanes;
        ahead_rows_ = next / lanes - now / lanes;
        ahead_lane_ = next % lanes;
    }
    void look_ahead_no_more() { ahead_lane_ = -1; }

  private:
    const uint8_t* ahead(size_t part, int64_t row) const {
        if (ahead_lane_ < 0 || memory_.frames_.packed()) return nullptr;
        return memory_.lane_frames(part, std::max<int64_t>(0, row + ahead_rows_), ahead_lane_);
    }

    int64_t ahead_rows_ = 0, ahead_lane_ = -1;
    const ReplayMemory& memory_;
    Frames::Reader reader_;
};

// Returns whether the episode of a complete step continues in the next row.
bool ReplayMemory::continues(int64_t row, int64_t lane) const {
    if (flags(row, lane) & (kTerminated | kTruncated)) return false;
    const uint8_t next = flags(row + 1, lane);
    return !(next & kFirst) && (row + 1 == state_.head || !(next & kNoStep));
}

ReplayMemory::Transition ReplayMemory::walk(int64_t row, int64_t lane, int64_t reach, double discount) const {
    Transition transition{0, 0, 1, false, false, true};
    for (;; ++row) {
        const int64_t here = cell(row, lane);
        transition.reward += transition.discount * static_cast<double>(rewards_[here]);
        transition.discount *= discount;
        ++transition.steps;
        if (!continues(row, lane)) {
            transition.terminated = (flags_[here] & kTerminated) != 0;
            transition.truncated = (flags_[here] & kTruncated) != 0 || !transition.terminated;
            break;
        }
        if (transition.steps == reach) break;
        if (row + 1 == state_.head) {
            transition.complete = false;
            break;
        }
    }
    if (transition.terminated) transition.discount = 0;
    return transition;
}

// Returns the newest frame of the observation `steps` steps after a row. Only the last step may end an episode.
ReplayMemory::Source ReplayMemory::source(int64_t row, int64_t lane, int64_t steps) const {
    const int64_t last = row + steps;
    if (steps > 0 && flags(last, lane) & kFirst) return {last - 1, find_final(last - 1, lane)};
    return {last, -1};
}

ReplayMemory::Span ReplayMemory::span(int64_t reach) const {
    Span span{std::max(state_.tail, state_.head - (reach - 1)), 0, {}, {}};
    for (int64_t lane = 0; lane < geometry_.lanes; ++lane) {
        bool ends = false;
        for (int64_t row = state_.head - 1; row >= span.first; --row) {
            if (flags(row, lane) & kNoStep) continue;
            ends = ends || !continues(row, lane);
            if (ends) span.newest.push_back(row * geometry_.lanes + lane);
            else span.excluded.push_back(cell(row, lane));
        }
    }
    std::sort(span.newest.begin(), span.newest.end());
    span.older = valid_.total() - static_cast<int64_t>(span.newest.size() + span.excluded.size());
    return span;
}

int64_t ReplayMemory::count(int64_t reach) const { return reach <= 1 ? valid_.total() : span(reach).count(); }

// Returns the index of a step from its cell.
int64_t ReplayMemory::index(int64_t cell) const {
    const int64_t newest = state_.head - 1, slot = cell / geometry_.lanes;
    const int64_t row = newest - (newest % slots_ - slot + slots_) % slots_;
    return row * geometry_.lanes + cell % geometry_.lanes;
}

void ReplayMemory::check_choice(const Choice& choice) const {
    if (choice.count < 1) throw std::invalid_argument("batch_size must be at least 1");
    if (choice.reach < 1) throw std::invalid_argument("n, or the length of sequences, must be at least 1");
    if (!(choice.discount >= 0 && choice.discount <= 1)) throw std::invalid_argument("gamma must be within 0..1");
    if (choice.beta && !tree_)
        throw std::invalid_argument("beta needs priorities; make the memory with priority_exponent");
    if (choice.beta && !(*choice.beta >= 0 && *choice.beta <= 100))
        throw std::invalid_argument("beta must be within 0..100");
    for (size_t part = 0; part < choice.stacks.size(); ++part)
        if (choice.stacks[part] < 1 || choice.stacks[part] > geometry_.parts[part].stack)
            throw std::invalid_argument("stack_num must be within 1.." + std::to_string(geometry_.parts[part].stack) +
                                        " here, got " + std::to_string(choice.stacks[part]));
}

// Returns the indices of sampled steps, and writes their weights if `weights` is not null.
std::vector<int64_t> ReplayMemory::draw(const Choice& choice, float* weights) {
    check_choice(choice);
    const Span span = this->span(choice.reach);
    const int64_t count = span.count();
    if (count == 0)
        throw std::invalid_argument("there is no step to sample yet from which " + std::to_string(choice.reach) +
                                    " steps, or the end of an episode, are stored");
    if (choice.beta) return draw_by_priority(choice, span, weights);
    // Steps are numbered by age, from the ring's oldest step.
    const int64_t start = valid_.rank(cell(state_.tail, 0));
    std::vector<int64_t> indices(static_cast<size_t>(choice.count));
    for (int64_t& drawn : indices) {
        const auto k = static_cast<int64_t>(state_.generator.below(static_cast<uint64_t>(count)));
        drawn = k < span.older ? index(valid_.select((start + k) % valid_.total()))
                               : span.newest[static_cast<size_t>(k - span.older)];
    }
    if (weights) std::fill_n(weights, choice.count, 1.0f);
    return indices;
}

namespace {

// Sets leaves of the tree to 0 for its own lifetime.
class Hidden {
  public:
    Hidden(SumTree& tree, const std::vector<int64_t>& cells) : tree_(tree), cells_(cells) {
        for (const int64_t cell : cells) kept_.push_back(tree.get(cell));
        for (const int64_t cell : cells) tree.set(cell, 0);
    }
    Hidden(const Hidden&) = delete;
    Hidden& operator=(const Hidden&) = delete;
    ~Hidden() {
        for (size_t i = 0; i < kept_.size(); ++i) tree_.set(cells_[i], kept_[i]);
    }

  private:
    SumTree& tree_;
    const std::vector<int64_t>& cells_;
    std::vector<double> kept_;
};

}  // namespace

std::vector<int64_t> ReplayMemory::draw_by_priority(const Choice& choice, const Span& span, float* weights) {
    const Hidden hidden(*tree_, span.excluded);
    const double total = tree_->total();
    if (!(total > 0)) throw std::invalid_argument("the priorities of all steps are 0: no step can be sampled");
    std::vector<double> exact(static_cast<size_t>(choice.count));
    for (size_t i = 0; i < exact.size(); ++i)
        exact[i] = (static_cast<double>(i) + state_.generator.fraction()) / static_cast<double>(choice.count) * total;
    std::vector<int64_t> indices = tree_->find(exact);
    for (size_t i = 0; i < indices.size(); ++i) {
        exact[i] = tree_->get(indices[i]);
        indices[i] = index(indices[i]);
    }
    // A weight is (count * probability) ** -beta, divided by the greatest weight, which the least priority has.
    const double least = *std::min_element(exact.begin(), exact.end());
    for (size_t i = 0; weights && i < exact.size(); ++i)
        weights[i] = static_cast<float>(std::pow(least / exact[i], *choice.beta));
    return indices;
}

namespace {

// Calls `work(own, i)` for i below `count` in up to `threads` threads; `own` is the thread's result of `make()`.
template <typename Make, typename Work>
void share(int64_t count, int threads, Make&& make, Work&& work) {
    constexpr int64_t kTogether = 4;
    std::atomic<int64_t> next{0};
    const auto run = [&](auto& own) {
        for (int64_t start; (start = next.fetch_add(kTogether)) < count;)
            for (int64_t i = start; i < std::min(count, start + kTogether); ++i) work(own, i);
    };
    auto own = make();
    std::vector<std::thread> others;
    try {
        others.reserve(static_cast<size_t>(threads));
        for (int i = 1; i < std::min<int64_t>(threads, count / kTogether); ++i)
            others.emplace_back([&run, theirs = make()]() mutable { run(theirs); });  // only this statement may throw
    } catch (const std::exception&) {
        // The threads that have started do the work.
    }
    run(own);
    for (std::thread& other : others) other.join();
}

}  // namespace

void ReplayMemory::observe(const std::vector<int>& stacks, const std::vector<uint8_t*>& to) const {
    if (!state_.started) throw std::invalid_argument("call reset(observations) first");
    check_choice({1, 1, 1.0, {}, stacks, 1});
    Writer writer(*this);
    for (size_t part = 0; part < to.size(); ++part) {
        const size_t size = geometry_.parts[part].bytes * static_cast<size_t>(stacks[part]);
        for (int64_t lane = 0; lane < geometry_.lanes; ++lane)
            writer.write(part, lane, {state_.head, -1}, stacks[part], to[part] + static_cast<size_t>(lane) * size);
    }
}

// Begins to load the data of a step, which lie far apart in memory.
void ReplayMemory::prefetch_step([[maybe_unused]] int64_t index) const {
#if defined(__GNUC__)
    const int64_t row = index / geometry_.lanes, lane = index % geometry_.lanes, here = cell(row, lane);
    __builtin_prefetch(&rewards_[here]);
    __builtin_prefetch(actions_ + static_cast<size_t>(here) * geometry_.action_bytes);
    for (int64_t i = std::max<int64_t>(0, row - geometry_.most_frames() + 2); i <= row + 1; ++i)
        __builtin_prefetch(&flags_[cell(i, lane)]);
#endif
}

void ReplayMemory::sample(const Choice& choice, const Target& target) {
    if (target.next.empty() && choice.reach != 1)
        throw std::invalid_argument("a batch of shared frames is for n=1, not " + std::to_string(choice.reach));
    const std::vector<int64_t> indices = draw(choice, target.weights);
    share(
        choice.count, choice.threads, [&] { return Writer(*this); },
        [&](Writer& writer, int64_t at) {
            const auto i = static_cast<size_t>(at);
            const int64_t row = indices[i] / geometry_.lanes, lane = indices[i] % geometry_.lanes;
            constexpr size_t kAhead = 6;
            if (i + kAhead < indices.size()) prefetch_step(indices[i + kAhead]);
            if (i + 1 < indices.size()) writer.look_ahead(indices[i], indices[i + 1]);
            else writer.look_ahead_no_more();
            const Transition transition = walk(row, lane, choice.reach, choice.discount);
            target.indices[i] = indices[i];
            std::memcpy(target.actions + i * geometry_.action_bytes,
                        actions_ + static_cast<size_t>(cell(row, lane)) * geometry_.action_bytes,
                        geometry_.action_bytes);
            target.rewards[i] = static_cast<float>(transition.reward);
            target.discounts[i] = static_cast<float>(transition.discount);
            target.terminated[i] = transition.terminated;
            target.truncated[i] = transition.truncated;
            const Source next = source(row, lane, transition.steps);
            for (size_t part = 0; part < geometry_.parts.size(); ++part) {
                const int frames = choice.stacks[part];
                const size_t bytes = geometry_.parts[part].bytes, size = bytes * static_cast<size_t>(frames);
                uint8_t* const observation = target.observations[part] + i * (size + (target.next.empty() ? bytes : 0));
                writer.write(part, lane, {row, -1}, frames, observation);
                if (target.next.empty()) writer.write(part, lane, next, 1, observation + size);
                else writer.write(part, lane, next, frames, target.next[part] + i * size, observation, row);
            }
        });
}

void ReplayMemory::sample_sequences(const Choice& choice, const Target& target) {
    const std::vector<int64_t> indices = draw(choice, nullptr);
    const auto length = static_cast<size_t>(choice.reach);
    share(
        choice.count, choice.threads, [&] { return Writer(*this); },
        [&](Writer& writer, int64_t at) {
            const auto i = static_cast<size_t>(at);
            const int64_t row = indices[i] / geometry_.lanes, lane = indices[i] % geometry_.lanes;
            const auto steps = static_cast<size_t>(walk(row, lane, choice.reach, 1.0).steps);
            target.indices[i] = indices[i];
            for (size_t step = 0; step < length; ++step) {
                const size_t to = i * length + step;
                const bool inside = step < steps;
                const int64_t now = row + static_cast<int64_t>(step);
                const Transition one = inside ? walk(now, lane, 1, 1.0) : Transition{};
                uint8_t* const action = target.actions + to * geometry_.action_bytes;
                if (inside)
                    std::memcpy(action, actions_ + static_cast<size_t>(cell(now, lane)) * geometry_.action_bytes,
                                geometry_.action_bytes);
                else std::memset(action, 0, geometry_.action_bytes);
                target.rewards[to] = static_cast<float>(one.reward);
                target.terminated[to] = one.terminated;
                target.truncated[to] = one.truncated;
                target.mask[to] = inside;
            }
            for (size_t part = 0; part < geometry_.parts.size(); ++part) {
                const int frames = choice.stacks[part];
                const size_t size = geometry_.parts[part].bytes * static_cast<size_t>(frames);
                uint8_t* to = target.observations[part] + i * (length + 1) * size;
                const uint8_t* older = nullptr;
                for (size_t step = 0; step <= length; older = to, to += size, ++step) {
                    const int64_t now = row + static_cast<int64_t>(step);
                    if (step > steps) std::memset(to, 0, size);
                    else
                        writer.write(part, lane, source(row, lane, static_cast<int64_t>(step)), frames, to, older,
                                     now - 1);
                }
            }
        });
}

}  // namespace atari::memory
