#include "geometry.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "state.hpp"

namespace atari::memory {
namespace {

constexpr size_t kPage = 4096;
constexpr int64_t kMostCells = int64_t{1} << 40;
constexpr uint64_t kMostBytes = uint64_t{1} << 46;

void require(bool good, const char* what) {
    if (!good) throw std::invalid_argument(what);
}

}  // namespace

void Geometry::check() const {
    require(lanes >= 1 && lanes <= (1 << 20), "num_envs must be within 1..1048576");
    require(rows >= 1 && rows <= kMostCells / lanes, "capacity must be at least 1, and at most 2**40");
    require(margin >= 0 && margin <= kMostCells / lanes, "margin must not be negative, and at most 2**40");
    require(finals >= 0 && finals <= kMostCells, "final_frames must not be negative, and at most 2**40");
    require(autoreset == Autoreset::kNextStep || finals >= 2 * lanes,
            "final_frames must be at least 2 for each environment, in this autoreset mode");
    require(!parts.empty() && parts.size() <= 16, "an observation must have 1 to 16 parts");
    for (const Part& part : parts) {
        require(part.bytes >= 1 && part.bytes <= (1u << 26), "a frame must have 1 to 2**26 bytes");
        require(part.pitch >= 1 && part.pitch <= part.bytes, "the pitch must be within the frame");
        require(part.stack >= 1 && part.stack <= 1024, "stack_num must be within 1..1024");
    }
    require(action_bytes >= 1 && action_bytes <= 4096, "an action must have 1 to 4096 bytes");
    require(std::isfinite(exponent) && exponent >= 0 && exponent <= 100, "priority_exponent must be within 0..100");
    const double cells = static_cast<double>(rows + history() + 2 + margin) * static_cast<double>(lanes);
    const double frame = static_cast<double>(compressed ? 0 : frame_bytes());
    const double most =
        cells * (frame + static_cast<double>(action_bytes) + 64) + static_cast<double>(finals) * (frame + 64);
    require(most < static_cast<double>(kMostBytes), "the memory would be larger than 2**46 bytes");
    if (!compressed) return;
    require(packed_bytes <= kMostBytes, "compressed_bytes must be at most 2**46");
    const size_t least = least_packed_bytes(*this);
    if (packed_bytes < least)
        throw std::invalid_argument("compressed_bytes must be at least " + std::to_string(least) + " here, not " +
                                    std::to_string(packed_bytes));
}

int Geometry::most_frames() const { return std::ranges::max(parts, {}, &Part::stack).stack; }

int64_t Geometry::history() const { return most_frames() - 1 + (compressed ? kGroup - 1 : 0); }

int64_t Geometry::kept_finals() const {
    return saved && autoreset != Autoreset::kNextStep ? finals - std::max(lanes, finals / 8) : finals;
}

size_t Geometry::frame_bytes() const {
    size_t bytes = 0;
    for (const Part& part : parts) bytes += part.bytes;
    return bytes;
}

Layout::Layout(const Geometry& geometry) {
    size_t end = 0;
    const auto place = [&end](size_t size) {
        const size_t start = end;
        end = (end + size + kPage - 1) / kPage * kPage;
        return start;
    };
    const auto lanes = static_cast<size_t>(geometry.lanes), slots = static_cast<size_t>(geometry.slots());
    const auto cells = lanes * slots, final_slots = static_cast<size_t>(geometry.finals);
    section_bytes = sizeof(SectionHeader) + sizeof(State) + 2 * lanes + lanes * geometry.frame_bytes() +
                    (geometry.prioritised ? (cells + slots) * sizeof(double) : 0);
    for (size_t& section : sections) section = place(section_bytes);
    actions = place(cells * geometry.action_bytes);
    rewards = place(cells * sizeof(float));
    flags = place(cells);
    checks = place(geometry.saved ? slots * sizeof(uint64_t) : 0);
    final_owners = place(final_slots * sizeof(int64_t));
    final_checks = place(geometry.saved ? final_slots * sizeof(uint64_t) : 0);
    for (const Part& part : geometry.parts) {
        frames.push_back(place((geometry.compressed ? 3 * lanes : cells) * part.bytes));
        finals.push_back(place(geometry.compressed ? 0 : final_slots * part.bytes));
        packed_frames.push_back(place(geometry.compressed ? cells * sizeof(PackedFrame) : 0));
        packed_finals.push_back(place(geometry.compressed ? final_slots * sizeof(PackedFrame) : 0));
    }
    packed = place(geometry.compressed ? geometry.packed_bytes : 0);
    bytes = end;
}

}  // namespace atari::memory
