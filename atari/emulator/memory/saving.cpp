// The saved state of a replay memory. Rows are already in their place; the rest of the state is written to one of two
// sections in turn, so that the last complete section is never overwritten. The caller of the three phases of a save
// waits after each until the block is on the disk:
//
// 1. `begin_save` marks the section as being written: `begun` has its number, and `completed` the number before it.
// 2. `write_save` writes the content.
// 3. `complete_save` writes the checksum and `completed`.
//
// Then `end_save` counts the save. Neither a kill nor a loss of power leaves a section with `begun` == `completed` and
// another checksum: such a section is damaged.
#include <algorithm>
#include <atomic>
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

// Returns the number of the save that a section had before the save `number`; 0 if none.
uint64_t number_before(uint64_t number) { return number > 2 ? number - 2 : 0; }

}  // namespace

std::string ReplayMemory::place(size_t offset) const { return " (at byte " + std::to_string(offset) + " of its data)"; }

uint64_t ReplayMemory::section_check(const uint8_t* section, uint64_t number) const {
    Checksum sum(number);
    sum.add(section + sizeof(SectionHeader), layout_.section_bytes - sizeof(SectionHeader));
    return sum.value();
}

// Marks a section as being written. After each store, the section is still the complete one, or is being written.
void ReplayMemory::begin_section(uint8_t* section, uint64_t number) {
    put(section + offsetof(SectionHeader, completed), number_before(number));
    put(section + offsetof(SectionHeader, begun), number);
    put(section + offsetof(SectionHeader, check), 0);
}

void ReplayMemory::write_section(uint8_t* section) const {
    uint8_t* to = section + sizeof(SectionHeader);
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
    if (!tree_) return;
    write(tree_->leaves(), static_cast<size_t>(geometry_.cells()) * sizeof(double));
    write(greatest_->leaves(), static_cast<size_t>(slots_) * sizeof(double));
}

void ReplayMemory::complete_section(uint8_t* section, uint64_t number) const {
    put(section + offsetof(SectionHeader, check), section_check(section, number));
    put(section + offsetof(SectionHeader, completed), number);
}

void ReplayMemory::begin_save() { begin_section(section(saves_ + 1), saves_ + 1); }

void ReplayMemory::write_save() {
    write_section(section(saves_ + 1));
    written_ = state_;
}

void ReplayMemory::complete_save() { complete_section(section(saves_ + 1), saves_ + 1); }

void ReplayMemory::end_save() {
    ++saves_;
    saved_ = written_;
    saving_ = geometry_.saved;
    if (frames_.packed()) release_chunks();
}

void ReplayMemory::save_copy(uint8_t* copy) const {
    uint8_t* const section = copy + layout_.sections[(saves_ + 1) % 2];
    begin_section(section, saves_ + 1);
    write_section(section);
    complete_section(section, saves_ + 1);
}

// Returns the number of a complete section, or 0. Before the last store of a save, `completed` is one save behind.
uint64_t ReplayMemory::complete_number(uint64_t which) const {
    const uint64_t number = header_of(section(which)).begun;
    const bool complete = number > 0 && number < uint64_t{1} << 62 && number % 2 == which &&
                          header_of(section(which)).check == section_check(section(which), number);
    return complete ? number : 0;
}

// Returns whether a section may stand beside the complete section `number`, whose state is then the newest.
bool ReplayMemory::may_follow(uint64_t which, uint64_t number) const {
    const SectionHeader header = header_of(section(which));
    const bool writing = header.begun == number + 1 && header.completed == number_before(number + 1);
    const bool unwritten = number == 1 && header.begun == 0 && header.completed == 0;
    return writing || unwritten || (number > 1 && complete_number(which) == number - 1);
}

uint64_t ReplayMemory::newest_save() const {
    const uint64_t numbers[2] = {complete_number(0), complete_number(1)}, newest = std::max(numbers[0], numbers[1]);
    if (newest > 0 && may_follow((newest + 1) % 2, newest)) return newest;
    const SectionHeader even = header_of(section(0)), odd = header_of(section(1));
    if (even.begun == 0 && even.completed == 0 && odd.begun <= 1 && odd.completed == 0)
        throw std::invalid_argument("it has no saved state: the process that made it ended too early; remove it");
    throw std::invalid_argument("the saved state is damaged" + place(layout_.sections[(newest + 1) % 2]) + "; " +
                                complete_saves());
}

// Returns the end of a message: the saves that are complete.
std::string ReplayMemory::complete_saves() const {
    const uint64_t even = complete_number(0), odd = complete_number(1), first = std::min(even, odd);
    if (even == 0 && odd == 0) return "no flush of it is complete";
    return "it has flush " + (first > 0 ? std::to_string(first) + " and " : "") + std::to_string(std::max(even, odd));
}

void ReplayMemory::check_state(const State& state) const {
    const bool good = state.head >= 0 && state.head < (int64_t{1} << 62) / geometry_.lanes && state.tail >= 0 &&
                      state.tail <= state.head && state.head - state.tail <= geometry_.rows && state.finals >= 0 &&
                      state.finals < int64_t{1} << 62 && state.steps >= 0 && state.started <= 1 &&
                      (state.started || state.head == 0) && state.greatest >= 0 && state.greatest <= kMostPriority &&
                      state.first_final >= 0 && state.first_final <= state.finals &&
                      state.finals - state.first_final <= geometry_.finals;
    const bool drawn = std::any_of(std::begin(state.generator.words), std::end(state.generator.words),
                                   [](uint64_t word) { return word != 0; });
    if (!good || !drawn) throw std::invalid_argument("the saved state has numbers that cannot be");
}

void ReplayMemory::load_section(const uint8_t* section) {
    const uint8_t* from = section + sizeof(SectionHeader);
    State state;
    std::memcpy(&state, from, sizeof state);
    check_state(state);
    state_ = state;
    for (size_t lane = 0; lane < waiting_.size(); ++lane) waiting_[lane] = from[sizeof state + lane] != 0;
    if (!tree_) return;
    from = pending_flags(section) + pending_bytes();
    const auto read_priorities = [&from](int64_t count) {
        std::vector<double> priorities(static_cast<size_t>(count));
        std::memcpy(priorities.data(), from, priorities.size() * sizeof(double));
        from += priorities.size() * sizeof(double);
        for (const double priority : priorities)
            if (!(priority >= 0 && priority <= kMostPriority))
                throw std::invalid_argument("the saved state has priorities that cannot be");
        return priorities;
    };
    tree_->load(read_priorities(geometry_.cells()));
    greatest_->load(read_priorities(slots_));
    state_.greatest = greatest_of_new();
}

// The flags of the pending row in a section; its frames follow them.
const uint8_t* ReplayMemory::pending_flags(const uint8_t* section) const {
    return section + sizeof(SectionHeader) + sizeof(State) + waiting_.size();
}

size_t ReplayMemory::pending_bytes() const { return waiting_.size() * (1 + geometry_.frame_bytes()); }

void ReplayMemory::resume() {
    const uint8_t* from = pending_flags(section(saves_));
    for (int64_t lane = 0; lane < geometry_.lanes; ++lane) flags_[cell(state_.head, lane)] = *from++ & kFirst;
    for (size_t part = 0; part < geometry_.parts.size(); ++part) {
        const size_t size = waiting_.size() * geometry_.parts[part].bytes;
        std::memcpy(frames_.row(part, state_.head), from, size);
        from += size;
    }
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
    // Rows ascend, and a step has one final observation. The steps of a row may have theirs in any order.
    int64_t before = 0;
    std::vector<int64_t> rows(static_cast<size_t>(geometry_.lanes), -1);  // by lane, the last row with an entry
    for (int64_t entry = state_.first_final; entry < state_.finals; ++entry) {
        const int64_t slot = entry % geometry_.finals, owner = final_owners_[slot], row = owner / geometry_.lanes;
        bool good = owner >= 0 && row >= before && row < state_.head;
        if (good) {
            int64_t& last = rows[static_cast<size_t>(owner % geometry_.lanes)];
            good = last != row;
            last = before = row;
        }
        if (!good || (verify && geometry_.saved && final_checks_[slot] != final_check(entry)))
            throw std::invalid_argument("the final observation in slot " + std::to_string(slot) + " is damaged" +
                                        place(layout_.final_owners + static_cast<size_t>(slot) * sizeof(int64_t)));
    }
}

// Computes the members that are not saved. `pending` has the flags of the pending row.
void ReplayMemory::rebuild(const uint8_t* pending) {
    valid_ = ValidSteps(geometry_.cells());
    int64_t entry = state_.first_final;
    std::vector<uint8_t> has_final(static_cast<size_t>(geometry_.lanes));
    for (int64_t row = state_.tail; row < state_.head; ++row) {
        std::fill(has_final.begin(), has_final.end(), uint8_t{0});
        for (; entry < state_.finals && owner(entry) / geometry_.lanes <= row; ++entry)
            if (owner(entry) / geometry_.lanes == row)
                has_final[static_cast<size_t>(owner(entry) % geometry_.lanes)] = 1;
        for (int64_t lane = 0; lane < geometry_.lanes; ++lane) {
            const bool step = !(flags(row, lane) & kNoStep);
            valid_.set(cell(row, lane), step);
            const uint8_t next = row + 1 < state_.head ? flags(row + 1, lane) : pending[lane];
            if (step && next & kFirst && !has_final[static_cast<size_t>(lane)])
                throw std::invalid_argument("the final observation after row " + std::to_string(row) + " is missing");
        }
    }
    for (int64_t i = 0; tree_ && i < geometry_.cells(); ++i)
        if (tree_->get(i) > 0 && !valid_.get(i)) tree_->set(i, 0);
}

void ReplayMemory::load(bool verify, std::optional<uint64_t> save) {
    const uint64_t number = save ? *save : newest_save();
    if (number == 0 || complete_number(number % 2) != number)
        throw std::invalid_argument("it has no flush " + std::to_string(number) + "; " + complete_saves());
    const bool overwritten = complete_number((number + 1) % 2) > number;  // by later steps, perhaps
    load_section(section(number));
    try {
        check_rows(verify || overwritten);
    } catch (const std::invalid_argument& error) {
        if (!overwritten) throw;
        throw std::invalid_argument("steps after flush " + std::to_string(number + 1) + " have overwritten flush " +
                                    std::to_string(number) + ": " + error.what());
    }
    const int64_t oldest = std::max<int64_t>(0, state_.tail - geometry_.history());
    if (!frames_.reload(oldest, state_.head, state_.first_final, state_.finals, final_owners_))
        throw std::invalid_argument("the table of compressed frames is damaged");
    rebuild(pending_flags(section(number)));
    saves_ = number;
    saved_ = state_;
    saving_ = geometry_.saved;
    if (!may_follow((number + 1) % 2, number)) begin_section(section(number + 1), number + 1);
}

}  // namespace atari::memory
