// The saved state of a replay memory. Rows are already in their place; the rest of the state is written to one of two
// sections in turn, so that the last complete section is never overwritten.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "checksum.hpp"
#include "replay_memory.hpp"

namespace atari::memory {
namespace {

SectionHeader header_of(const uint8_t* section) {
    SectionHeader header;
    std::memcpy(&header, section, sizeof header);
    return header;
}

// Writes one number of a header, after all earlier writes: a process that is killed leaves them in the file.
void put(uint8_t* to, uint64_t number) {
    std::atomic_signal_fence(std::memory_order_seq_cst);
    std::memcpy(to, &number, sizeof number);
    std::atomic_signal_fence(std::memory_order_seq_cst);
}

}  // namespace

std::string ReplayMemory::place(size_t offset) const { return " (at byte " + std::to_string(offset) + " of its data)"; }

uint64_t ReplayMemory::section_check(const uint8_t* section, uint64_t number) const {
    Checksum sum(number);
    sum.add(section + sizeof(SectionHeader), layout_.section_bytes - sizeof(SectionHeader));
    return sum.value();
}

void ReplayMemory::save() {
    const uint64_t number = saves_ + 1;
    uint8_t* const header = section(static_cast<int>(number % 2));
    put(header + offsetof(SectionHeader, begun), number);
    uint8_t* to = header + sizeof(SectionHeader);
    const auto write = [&to](const void* data, size_t size) {
        std::memcpy(to, data, size);
        to += size;
    };
    const auto lanes = static_cast<size_t>(geometry_.lanes);
    write(&state_, sizeof state_);
    write(waiting_.data(), lanes);
    write(flags_ + cell(state_.head, 0), lanes);
    for (size_t part = 0; part < geometry_.parts.size(); ++part)
        write(frames_.row(part, state_.head), lanes * geometry_.parts[part].bytes);
    if (tree_) write(tree_->leaves(), static_cast<size_t>(geometry_.cells()) * sizeof(double));
    put(header + offsetof(SectionHeader, check), section_check(header, number));
    put(header + offsetof(SectionHeader, completed), number);
    saves_ = number;
    saved_ = state_;
    saving_ = geometry_.saved;
}

// Returns the section to load. While a section is being written, its `begun` is ahead by 2; the other is complete.
int ReplayMemory::newest_section() const {
    SectionHeader headers[2];
    bool complete[2];
    for (int i = 0; i < 2; ++i) {
        headers[i] = header_of(section(i));
        const SectionHeader& header = headers[i];
        complete[i] = header.completed > 0 && header.begun == header.completed &&
                      header.completed % 2 == static_cast<uint64_t>(i) &&
                      header.check == section_check(section(i), header.completed);
    }
    for (int i = 0; i < 2; ++i) {
        const SectionHeader &here = headers[i], &other = headers[1 - i];
        if (!complete[i]) continue;
        const bool never = other.begun == 0 && other.completed == 0 && here.completed == 1;
        const bool torn = other.begun == here.completed + 1 &&
                          (other.completed + 2 == other.begun || (other.completed == 0 && other.begun <= 2));
        const bool older = complete[1 - i] && other.completed + 1 == here.completed;
        if (never || torn || older) return i;
    }
    for (int i = 0; i < 2; ++i)
        if (!complete[i]) throw std::invalid_argument("the saved state is damaged" + place(layout_.sections[i]));
    throw std::invalid_argument("the two saved states do not follow each other" + place(layout_.sections[0]));
}

void ReplayMemory::check_state(const State& state) const {
    const bool good = state.head >= 0 && state.head < (int64_t{1} << 62) / geometry_.lanes && state.tail >= 0 &&
                      state.tail <= state.head && state.head - state.tail <= geometry_.rows && state.finals >= 0 &&
                      state.steps >= 0 && state.started <= 1 && (state.started || state.head == 0) &&
                      std::isfinite(state.greatest) && state.greatest >= 0 && state.first_final >= 0 &&
                      state.first_final <= state.finals && state.finals - state.first_final <= geometry_.finals;
    const bool drawn = std::any_of(std::begin(state.generator.words), std::end(state.generator.words),
                                   [](uint64_t word) { return word != 0; });
    if (!good || !drawn) throw std::invalid_argument("the saved state has numbers that cannot be");
}

void ReplayMemory::load_section(const uint8_t* section) {
    const auto lanes = static_cast<size_t>(geometry_.lanes);
    const uint8_t* from = section + sizeof(SectionHeader);
    State state;
    std::memcpy(&state, from, sizeof state);
    check_state(state);
    from += sizeof state;
    state_ = state;
    for (uint8_t& waiting : waiting_) waiting = *from++ != 0;
    for (int64_t lane = 0; lane < geometry_.lanes; ++lane) flags_[cell(state_.head, lane)] = *from++ & kFirst;
    for (size_t part = 0; part < geometry_.parts.size(); ++part) {
        const size_t size = lanes * geometry_.parts[part].bytes;
        std::memcpy(frames_.row(part, state_.head), from, size);
        from += size;
    }
    if (!tree_) return;
    std::vector<double> priorities(static_cast<size_t>(geometry_.cells()));
    std::memcpy(priorities.data(), from, priorities.size() * sizeof(double));
    for (const double priority : priorities)
        if (!(priority >= 0) || !std::isfinite(priority))
            throw std::invalid_argument("the saved state has priorities that cannot be");
    tree_->load(priorities.data(), priorities.size());
}

uint64_t ReplayMemory::row_check(int64_t row) const {
    const auto first = static_cast<size_t>(cell(row, 0)), lanes = static_cast<size_t>(geometry_.lanes);
    Checksum sum(static_cast<uint64_t>(row));
    sum.add(actions_ + first * geometry_.action_bytes, lanes * geometry_.action_bytes);
    sum.add(rewards_ + first, lanes * sizeof(float));
    sum.add(flags_ + first, lanes);
    return frames_.check(row, sum.value());
}

uint64_t ReplayMemory::final_check(int64_t entry) const {
    Checksum sum(static_cast<uint64_t>(entry));
    sum.add(&final_owners_[entry % geometry_.finals], sizeof(int64_t));
    return frames_.check_final(entry, sum.value());
}

// Throws if rows or final observations of the loaded state are damaged.
void ReplayMemory::check_rows(bool verify) const {
    const int64_t first = std::max<int64_t>(0, state_.tail - geometry_.history());
    for (int64_t row = first; verify && geometry_.saved && row < state_.head; ++row)
        if (checks_[row % slots_] != row_check(row))
            throw std::invalid_argument("row " + std::to_string(row) + " of its frames and actions is damaged" +
                                        place(frames_.packed() ? layout_.flags + static_cast<size_t>(cell(row, 0))
                                                               : frames_.row_offset(0, row)));
    int64_t before = -1;
    for (int64_t entry = state_.first_final; entry < state_.finals; ++entry) {
        const int64_t slot = entry % geometry_.finals, owner = final_owners_[slot];
        const bool good = owner > before && owner < state_.head * geometry_.lanes;
        if (!good || (verify && geometry_.saved && final_checks_[slot] != final_check(entry)))
            throw std::invalid_argument("the final observation in slot " + std::to_string(slot) + " is damaged" +
                                        place(layout_.final_owners + static_cast<size_t>(slot) * sizeof(int64_t)));
        before = owner;
    }
}

// Computes the members that are not saved.
void ReplayMemory::rebuild() {
    valid_ = ValidSteps(geometry_.cells());
    for (int64_t row = state_.tail; row < state_.head; ++row)
        for (int64_t lane = 0; lane < geometry_.lanes; ++lane) {
            const bool step = !(flags(row, lane) & kNoStep);
            valid_.set(cell(row, lane), step);
            if (step && flags(row + 1, lane) & kFirst && find_final(row, lane) < 0)
                throw std::invalid_argument("the final observation after row " + std::to_string(row) + " is missing");
        }
    for (int64_t i = 0; tree_ && i < geometry_.cells(); ++i)
        if (tree_->get(i) > 0 && !valid_.get(i)) tree_->set(i, 0);
}

void ReplayMemory::load(bool verify) {
    const int newest = newest_section();
    load_section(section(newest));
    saves_ = header_of(section(newest)).completed;
    check_rows(verify);
    const int64_t oldest = std::max<int64_t>(0, state_.tail - geometry_.history());
    if (!frames_.reload(oldest, state_.head, state_.first_final, state_.finals, final_owners_))
        throw std::invalid_argument("the table of compressed frames is damaged");
    rebuild();
    saved_ = state_;
    saving_ = geometry_.saved;
}

}  // namespace atari::memory
