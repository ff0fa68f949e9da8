#include "packed_frames.hpp"

#include <algorithm>
#include <cstring>

#include "codec.hpp"

namespace atari::memory {
namespace {

size_t chunk_bytes(const Geometry& geometry) {
    const size_t most = most_encoded(std::ranges::max(geometry.parts, {}, &Part::bytes).bytes);
    return (std::max(size_t{1} << 16, 8 * most) + 4095) / 4096 * 4096;
}

// The most chunks of a row with a final observation in each lane. An eighth of a chunk may stay empty.
size_t most_chunks_of_row(const Geometry& geometry) {
    size_t bytes = 0;
    for (const Part& part : geometry.parts) bytes += 2 * static_cast<size_t>(geometry.lanes) * most_encoded(part.bytes);
    return bytes / (chunk_bytes(geometry) / 8 * 7) + 2;
}

}  // namespace

size_t least_packed_bytes(const Geometry& geometry) {
    return (static_cast<size_t>(geometry.history()) + 6) * most_chunks_of_row(geometry) * chunk_bytes(geometry);
}

PackedFrames::PackedFrames(const Geometry& geometry, uint8_t* bytes)
    : chunk_(chunk_bytes(geometry)), chunks_(geometry.packed_bytes / chunk_),
      chunks_of_row_(most_chunks_of_row(geometry)),
      spare_(geometry.saved ? std::max(3 * chunks_of_row_, chunks_ / 8) : 0), bytes_(bytes) {
    clear();
    finish_entering();
}

bool PackedFrames::may_keep(int64_t oldest) const {
    const auto first =
        std::partition_point(used_.begin(), used_.end(), [&](const Chunk& chunk) { return chunk.newest < oldest; });
    return static_cast<size_t>(used_.end() - first) + chunks_of_row_ <= chunks_ - spare_;
}

void PackedFrames::release(int64_t oldest) {
    while (!used_.empty() && used_.front().newest < oldest) {
        free_.push(used_.front().index);
        used_.pop_front();
    }
}

PackedFrame PackedFrames::store(const uint8_t* code, size_t size, int64_t row) {
    if (used_.empty() || used_.back().end + size > chunk_) {
        used_.push_back({free_.top(), row, 0});
        free_.pop();
    }
    Chunk& chunk = used_.back();
    const size_t offset = chunk.index * chunk_ + chunk.end;
    std::memcpy(bytes_ + offset, code, size);
    chunk.newest = row;
    chunk.end += size;
    return {offset, static_cast<uint32_t>(size), 0};
}

const uint8_t* PackedFrames::find(PackedFrame frame) const {
    const bool good =
        frame.offset / chunk_ < chunks_ && frame.bytes >= 1 && frame.bytes <= chunk_ - frame.offset % chunk_;
    return good ? bytes_ + frame.offset : nullptr;
}

void PackedFrames::clear() {
    used_.clear();
    free_ = {};
    entered_.assign(chunks_, {0, -1, 0});
}

bool PackedFrames::enter(PackedFrame frame, int64_t row) {
    if (!find(frame)) return false;
    Chunk& chunk = entered_[frame.offset / chunk_];
    chunk.newest = std::max(chunk.newest, row);
    chunk.end = std::max<size_t>(chunk.end, frame.offset % chunk_ + frame.bytes);
    return true;
}

void PackedFrames::finish_entering() {
    for (size_t index = 0; index < chunks_; ++index) {
        entered_[index].index = index;
        if (entered_[index].newest < 0) free_.push(index);
        else used_.push_back(entered_[index]);
    }
    std::sort(used_.begin(), used_.end(), [](const Chunk& a, const Chunk& b) { return a.newest < b.newest; });
    entered_ = {};
}

}  // namespace atari::memory
