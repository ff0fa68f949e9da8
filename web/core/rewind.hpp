// `Rewind`: many states of equal size, of which the newest is whole, and each older one is stored as its difference to the
// next. States of successive frames differ in few bytes.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <deque>
#include <utility>

#include "bytes.hpp"

namespace atari::web {

// The bytes where two states of equal size differ: for each run, the equal bytes before it, its length, and its bytes.
inline Bytes difference(const Bytes& one, const Bytes& other) {
    constexpr size_t kGap = 8;  // equal bytes that end a run
    Bytes runs;
    size_t done = 0;
    for (size_t at = 0; at < one.size();) {
        if (at + 8 <= one.size() && std::memcmp(&one[at], &other[at], 8) == 0) {
            at += 8;
            continue;
        }
        if (one[at] == other[at]) {
            ++at;
            continue;
        }
        size_t end = at + 1;
        for (size_t i = end; i < one.size() && i < end + kGap; ++i)
            if (one[i] != other[i]) end = i + 1;
        append_number(runs, static_cast<uint32_t>(at - done), 4);
        append_number(runs, static_cast<uint32_t>(end - at), 4);
        append(runs, View(one).subspan(at, end - at));
        done = at = end;
    }
    return runs;
}

inline void apply_difference(Bytes& state, const Bytes& runs) {
    ByteReader in(runs);
    for (size_t at = 0; in.left() > 0;) {
        at += in.dword();
        const View run = in.take(in.dword());
        std::copy(run.begin(), run.end(), state.begin() + static_cast<std::ptrdiff_t>(at));
        at += run.size();
    }
}

template <typename Place>
class Rewind {
  public:
    void set_budget(size_t bytes) {
        budget_ = bytes;
        drop_oldest();
    }

    size_t size() const { return places_.size(); }
    void clear() {
        differences_.clear();
        places_.clear();
        bytes_ = 0;
    }

    void push(Bytes state, Place place) {
        if (!places_.empty()) {
            differences_.push_back(difference(newest_, state));
            bytes_ += differences_.back().size() + kOverhead;
        }
        newest_ = std::move(state);
        places_.push_back(std::move(place));
        drop_oldest();
    }

    // Returns the newest state and its place, and drops it. There must be one.
    std::pair<Bytes, Place> pop() {
        std::pair<Bytes, Place> found{newest_, std::move(places_.back())};
        places_.pop_back();
        if (!places_.empty()) {
            apply_difference(newest_, differences_.back());
            bytes_ -= differences_.back().size() + kOverhead;
            differences_.pop_back();
        }
        return found;
    }

  private:
    static constexpr size_t kOverhead = sizeof(Place) + sizeof(Bytes);

    void drop_oldest() {
        while (bytes_ > budget_) {
            bytes_ -= differences_.front().size() + kOverhead;
            differences_.pop_front();
            places_.pop_front();
        }
    }

    size_t budget_ = size_t{32} << 20, bytes_ = 0;
    Bytes newest_;
    std::deque<Bytes> differences_;  // from each state but the newest to the next
    std::deque<Place> places_;
};

}  // namespace atari::web
