#include "replay_memory.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <ranges>
#include <stdexcept>

namespace atari::memory {

ReplayMemory::ReplayMemory(const Geometry& geometry, uint8_t* block)
    : geometry_(geometry), layout_(geometry_), slots_(geometry_.slots()), block_(block),
      actions_(block + layout_.actions), rewards_(reinterpret_cast<float*>(block + layout_.rewards)),
      flags_(block + layout_.flags), checks_(reinterpret_cast<uint64_t*>(block + layout_.checks)),
      final_owners_(reinterpret_cast<int64_t*>(block + layout_.final_owners)),
      final_checks_(reinterpret_cast<uint64_t*>(block + layout_.final_checks)),
      waiting_(static_cast<size_t>(geometry_.lanes)), frames_(geometry_, layout_, block), valid_(geometry_.cells()) {
    state_.greatest = 1;
    state_.generator.seed(0);
    if (!geometry_.prioritised) return;
    tree_.emplace(geometry_.cells());
    greatest_.emplace(slots_);
}

uint8_t* ReplayMemory::lane_frames(size_t part, int64_t row, int64_t lane) const {
    return frames_.row(part, row) + static_cast<size_t>(lane) * geometry_.parts[part].bytes;
}

void ReplayMemory::reset() {
    if (!state_.started) {
        state_.started = 1;
        std::fill_n(flags_, geometry_.lanes, uint8_t{kFirst});
        return;
    }
    check_row();
    make_space(0);
    frames_.store(state_.head);
    for (int64_t lane = 0; lane < geometry_.lanes; ++lane) {
        flags_[cell(state_.head, lane)] |= kNoStep;
        begin_row(lane, kFirst);
        waiting_[static_cast<size_t>(lane)] = 0;
    }
    complete_row();
}

void ReplayMemory::reset(const uint8_t* mask, const std::vector<const uint8_t*>& frames) {
    if (!state_.started) throw std::invalid_argument("the first reset must be of all environments, without a mask");
    if (geometry_.autoreset == Autoreset::kNextStep)
        throw std::invalid_argument("a reset of some environments needs autoreset_mode 'disabled' or 'same_step'");
    const int64_t before = state_.head - 1;
    const auto follows_step = [&](int64_t lane) {
        return before >= state_.tail && !(flags(before, lane) & kNoStep) && !(flags(state_.head, lane) & kFirst);
    };
    int64_t finals = 0;
    for (int64_t lane = 0; lane < geometry_.lanes; ++lane) finals += mask[lane] && follows_step(lane);
    make_space(finals);
    for (int64_t lane = 0; lane < geometry_.lanes; ++lane) {
        if (!mask[lane]) continue;
        std::vector<const uint8_t*> last;
        for (size_t part = 0; part < frames.size(); ++part) last.push_back(lane_frames(part, state_.head, 0));
        if (follows_step(lane)) push_final(before, lane, last, lane);
        for (size_t part = 0; part < frames.size(); ++part) {
            const size_t bytes = geometry_.parts[part].bytes;
            std::memcpy(lane_frames(part, state_.head, lane), frames[part] + static_cast<size_t>(lane) * bytes, bytes);
        }
        flags_[cell(state_.head, lane)] = kFirst;
        waiting_[static_cast<size_t>(lane)] = 0;
    }
}

void ReplayMemory::check_results(const StepResults& results) const {
    if (!state_.started) throw std::invalid_argument("call reset(observations) before the first add");
    const bool needs_finals = geometry_.autoreset == Autoreset::kSameStep && results.finals.empty();
    for (int64_t lane = 0; lane < geometry_.lanes; ++lane) {
        if (!std::isfinite(results.rewards[lane]))
            throw std::invalid_argument("the reward of environment " + std::to_string(lane) + " is " +
                                        std::to_string(results.rewards[lane]) + "; rewards must be finite");
        if (needs_finals && (results.terminated[lane] || results.truncated[lane]))
            throw std::invalid_argument("the episode of environment " + std::to_string(lane) +
                                        " has ended, and info has no final_obs; autoreset_mode is 'same_step' here");
    }
}

void ReplayMemory::add(const StepResults& results) {
    check_results(results);
    const bool same_step = geometry_.autoreset == Autoreset::kSameStep;
    const bool next_step = geometry_.autoreset == Autoreset::kNextStep;
    int64_t finals = 0;
    for (int64_t lane = 0; same_step && lane < geometry_.lanes; ++lane)
        finals += results.terminated[lane] || results.truncated[lane];
    check_row();
    make_space(finals);
    const int64_t head = state_.head;
    std::memcpy(actions_ + static_cast<size_t>(cell(head, 0)) * geometry_.action_bytes, results.actions,
                static_cast<size_t>(geometry_.lanes) * geometry_.action_bytes);
    frames_.store(head);
    for (int64_t lane = 0; lane < geometry_.lanes; ++lane) {
        const int64_t here = cell(head, lane);
        uint8_t& waiting = waiting_[static_cast<size_t>(lane)];
        if (waiting) {
            rewards_[here] = 0;
            flags_[here] |= kNoStep;
            begin_row(lane, next_step ? kFirst : 0);
            if (next_step) waiting = 0;
            continue;
        }
        const bool terminated = results.terminated[lane] != 0, truncated = results.truncated[lane] != 0;
        rewards_[here] = results.rewards[lane];
        flags_[here] |= (terminated ? kTerminated : 0) | (truncated ? kTruncated : 0);
        valid_.set(here, true);
        if (tree_) tree_->set(here, state_.greatest);
        const bool ended = terminated || truncated;
        begin_row(lane, ended && same_step ? kFirst : 0);
        if (ended && same_step) push_final(head, lane, results.finals, lane);
        else waiting = ended;
    }
    complete_row();
}

// Advances to the next row, which has its frames and flags.
void ReplayMemory::complete_row() {
    if (geometry_.saved) checks_[state_.head % slots_] = row_check(state_.head);
    ++state_.head;
    state_.steps += geometry_.lanes;
    while (state_.head - state_.tail > geometry_.rows) forget_oldest();
    if (frames_.packed()) release_chunks();
}

void ReplayMemory::forget_oldest() {
    for (int64_t lane = 0; lane < geometry_.lanes; ++lane) {
        const int64_t here = cell(state_.tail, lane);
        if (!valid_.get(here)) continue;
        valid_.set(here, false);
        if (tree_) tree_->set(here, 0);
    }
    if (greatest_) set_greatest(state_.tail, 0);
    ++state_.tail;
    while (state_.first_final < state_.finals && owner(state_.first_final) / geometry_.lanes < state_.tail)
        ++state_.first_final;
}

bool ReplayMemory::must_save() const {
    if (!saving_) return false;
    const int64_t finals = geometry_.autoreset == Autoreset::kNextStep ? 0 : geometry_.lanes;
    // An `add` and the resets of a mask after it take space for a row each, and together final observations for one.
    return !row_fits() || !finals_fit(finals) || (frames_.packed() && !frames_.packed()->has_space(2));
}

void ReplayMemory::check_row() const {
    if (saving_ && !row_fits())
        throw Overwrites("the next step would overwrite rows of flush " + std::to_string(saves_) +
                         "; call flush() first; must_flush says when");
}

// Makes space for the frames of the pending row and `finals` final observations: forgets the oldest rows. Which rows does
// not depend on the saves, so that a memory that is opened again goes on as one that was not.
void ReplayMemory::make_space(int64_t finals) {
    PackedFrames* const packed = frames_.packed();
    if (saving_ && (!finals_fit(finals) || (packed && !packed->has_space())))
        throw Overwrites("the next step would overwrite frames of flush " + std::to_string(saves_) +
                         "; call flush() first; must_flush says when");
    while (state_.first_final < state_.finals + finals - geometry_.kept_finals()) forget_oldest();
    while (packed && !packed->may_keep(state_.tail - geometry_.history())) forget_oldest();
    if (packed) release_chunks();
}

void ReplayMemory::release_chunks() { frames_.packed()->release(kept_tail() - geometry_.history()); }

void ReplayMemory::push_final(int64_t row, int64_t lane, const std::vector<const uint8_t*>& frames, int64_t frame) {
    const int64_t entry = state_.finals, slot = entry % geometry_.finals;
    for (size_t part = 0; part < frames.size(); ++part)
        frames_.store_final(part, entry, row, lane,
                            frames[part] + static_cast<size_t>(frame) * geometry_.parts[part].bytes);
    final_owners_[slot] = row * geometry_.lanes + lane;
    if (geometry_.saved) final_checks_[slot] = final_check(entry);
    ++state_.finals;
}

// Returns the entry of the final observation after a step, or -1. Rows ascend; the entries of a row have any order.
int64_t ReplayMemory::find_final(int64_t row, int64_t lane) const {
    const int64_t wanted = row * geometry_.lanes;
    const auto entries = std::views::iota(state_.first_final, state_.finals);
    auto at = std::ranges::partition_point(entries, [&](int64_t entry) { return owner(entry) < wanted; });
    for (; at != entries.end() && owner(*at) < wanted + geometry_.lanes; ++at)
        if (owner(*at) == wanted + lane) return *at;
    return -1;
}

// Sets the greatest priority that was given to a step of a row.
void ReplayMemory::set_greatest(int64_t row, double priority) {
    if (greatest_->get(row % slots_) == priority) return;
    greatest_->set(row % slots_, priority);
    state_.greatest = greatest_of_new();
}

void ReplayMemory::update_priorities(const int64_t* indices, const double* priorities, int64_t count) {
    if (!tree_) throw std::invalid_argument("this memory has no priorities; make it with priority_exponent");
    std::vector<double> powers;
    for (int64_t i = 0; i < count; ++i) {
        powers.push_back(std::pow(priorities[i], geometry_.exponent));
        if (!(priorities[i] >= 0 && priorities[i] <= kMostPriority && powers.back() <= kMostPriority)) {
            char text[160];
            std::snprintf(text, sizeof text, "priority %lld must be within 0..1e100, and its power by %g too, got %g",
                          static_cast<long long>(i), geometry_.exponent, priorities[i]);
            throw std::invalid_argument(text);
        }
        if (indices[i] < 0 || indices[i] / geometry_.lanes >= state_.head)
            throw std::invalid_argument("index " + std::to_string(indices[i]) + " is of no step of this memory");
    }
    std::vector<int64_t> cells;
    std::vector<double> values;
    for (int64_t i = 0; i < count; ++i) {
        const int64_t row = indices[i] / geometry_.lanes, here = cell(row, indices[i] % geometry_.lanes);
        if (row < state_.tail || !valid_.get(here)) continue;
        const double power = powers[static_cast<size_t>(i)];
        if (power > greatest_->get(row % slots_)) set_greatest(row, power);
        cells.push_back(here);
        values.push_back(power);
    }
    tree_->set(cells, values);
}

size_t ReplayMemory::used_bytes() const {
    const size_t heap = static_cast<size_t>(geometry_.cells()) / 8;
    const size_t tree = tree_ ? static_cast<size_t>(geometry_.cells()) * 9 + static_cast<size_t>(slots_) * 16 : 0;
    if (frames_.packed()) return layout_.packed + frames_.packed()->used_bytes() + heap + tree;
    return layout_.bytes + heap + tree;
}

}  // namespace atari::memory
