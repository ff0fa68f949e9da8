#include "frames.hpp"

#include <algorithm>
#include <cstring>

#include "checksum.hpp"
#include "codec.hpp"

namespace atari::memory {
namespace {

// Copies a frame. Meanwhile it loads the frame `ahead` line by line into the cache, unless `ahead` is null.
void copy(uint8_t* to, const uint8_t* from, size_t bytes, [[maybe_unused]] const uint8_t* ahead) {
#if defined(__GNUC__)
    constexpr size_t kLine = 64;
    for (; ahead && bytes >= kLine; to += kLine, from += kLine, ahead += kLine, bytes -= kLine) {
        __builtin_prefetch(ahead, 0, 2);
        std::memcpy(to, from, kLine);
    }
#endif
    std::memcpy(to, from, bytes);
}

}  // namespace

Frames::Frames(const Geometry& geometry, const Layout& layout, uint8_t* block)
    : geometry_(geometry), layout_(layout), block_(block), slots_(geometry.slots()) {
    if (!geometry.compressed) return;
    packed_ = std::make_unique<PackedFrames>(geometry, block + layout.packed);
    code_.resize(most_encoded(std::ranges::max(geometry.parts, {}, &Part::bytes).bytes));
}

uint8_t* Frames::row(size_t part, int64_t row) const {
    const auto frame = static_cast<size_t>(place(row) * geometry_.lanes);
    return block_ + layout_.frames[part] + frame * geometry_.parts[part].bytes;
}

PackedFrame Frames::pack(size_t part, int64_t row, const uint8_t* frame, const uint8_t* before) {
    const Part& size = geometry_.parts[part];
    return packed_->store(code_.data(), encode(frame, before, size.bytes, size.pitch, code_.data(), scratch_), row);
}

void Frames::store(int64_t row) {
    if (!packed_) return;
    for (size_t part = 0; part < geometry_.parts.size(); ++part) {
        const size_t bytes = geometry_.parts[part].bytes;
        const uint8_t* frame = this->row(part, row);
        const uint8_t* before = row % kGroup ? this->row(part, row + 2) : nullptr;  // row - 1, modulo 3
        PackedFrame* const table = packed_table(layout_.packed_frames[part]);
        for (int64_t lane = 0; lane < geometry_.lanes; ++lane, frame += bytes) {
            table[cell(row, lane)] = pack(part, row, frame, before);
            if (before) before += bytes;
        }
    }
}

void Frames::store_final(size_t part, int64_t entry, int64_t row, int64_t lane, const uint8_t* frame) {
    const size_t bytes = geometry_.parts[part].bytes, slot = final_slot(entry);
    if (packed_)
        packed_table(layout_.packed_finals[part])[slot] =
            pack(part, row, frame, this->row(part, row) + static_cast<size_t>(lane) * bytes);
    else std::memcpy(block_ + layout_.finals[part] + slot * bytes, frame, bytes);
}

uint64_t Frames::check(int64_t row, uint64_t seed) const {
    Checksum sum(seed);
    for (size_t part = 0; part < geometry_.parts.size(); ++part) {
        const auto lanes = static_cast<size_t>(geometry_.lanes);
        if (!packed_) {
            sum.add(this->row(part, row), lanes * geometry_.parts[part].bytes);
            continue;
        }
        const PackedFrame* const frames = packed_table(layout_.packed_frames[part]) + cell(row, 0);
        sum.add(frames, lanes * sizeof(PackedFrame));
        for (size_t lane = 0; lane < lanes; ++lane)
            if (const uint8_t* code = packed_->find(frames[lane])) sum.add(code, frames[lane].bytes);
    }
    return sum.value();
}

uint64_t Frames::check_final(int64_t entry, uint64_t seed) const {
    Checksum sum(seed);
    for (size_t part = 0; part < geometry_.parts.size(); ++part) {
        const size_t bytes = geometry_.parts[part].bytes, slot = final_slot(entry);
        if (!packed_) {
            sum.add(block_ + layout_.finals[part] + slot * bytes, bytes);
            continue;
        }
        const PackedFrame& frame = packed_table(layout_.packed_finals[part])[slot];
        sum.add(&frame, sizeof frame);
        if (const uint8_t* code = packed_->find(frame)) sum.add(code, frame.bytes);
    }
    return sum.value();
}

bool Frames::reload(int64_t first, int64_t head, int64_t first_final, int64_t finals, const int64_t* owners) {
    if (!packed_) return true;
    packed_->clear();
    bool good = true;
    for (size_t part = 0; part < geometry_.parts.size(); ++part) {
        const PackedFrame* const table = packed_table(layout_.packed_frames[part]);
        for (int64_t row = first; row < head; ++row)
            for (int64_t lane = 0; lane < geometry_.lanes; ++lane)
                good = packed_->enter(table[cell(row, lane)], row) && good;
        const PackedFrame* const final_table = packed_table(layout_.packed_finals[part]);
        for (int64_t entry = first_final; entry < finals; ++entry) {
            const size_t slot = final_slot(entry);
            good = packed_->enter(final_table[slot], owners[slot] / geometry_.lanes) && good;
        }
    }
    packed_->finish_entering();
    if (!good || head == 0) return good;
    // Decode the row before the pending row: the pending row is encoded from it.
    Reader reader(*this);
    for (size_t part = 0; part < geometry_.parts.size(); ++part)
        for (int64_t lane = 0; lane < geometry_.lanes; ++lane)
            reader.read(part, head - 1, lane, head,
                        row(part, head - 1) + static_cast<size_t>(lane) * geometry_.parts[part].bytes);
    return true;
}

Frames::Reader::Reader(const Frames& frames)
    : frames_(frames), decoded_(frames.packed_ ? frames.geometry_.parts.size() : 0) {
    for (size_t part = 0; part < decoded_.size(); ++part)
        decoded_[part].frame.resize(frames.geometry_.parts[part].bytes);
}

const std::vector<uint8_t>& Frames::Reader::decode(size_t part, int64_t row, int64_t lane) {
    Decoded& decoded = decoded_[part];
    const Part& size = frames_.geometry_.parts[part];
    const PackedFrame* const table = frames_.packed_table(frames_.layout_.packed_frames[part]);
    const int64_t group = row - row % kGroup;
    const bool continues = decoded.lane == lane && decoded.row >= group && decoded.row <= row;
    for (int64_t next = continues ? decoded.row + 1 : group; next <= row; ++next) {
        const PackedFrame frame = table[frames_.cell(next, lane)];
        const uint8_t* const code = frames_.packed_->find(frame);
        // Damaged code, in a file that was opened unchecked, is decoded to zeros.
        if (!code || !atari::memory::decode(code, frame.bytes, decoded.frame.data(), size.bytes, size.pitch))
            std::fill(decoded.frame.begin(), decoded.frame.end(), uint8_t{0});
    }
    decoded.row = row;
    decoded.lane = lane;
    return decoded.frame;
}

void Frames::Reader::read(size_t part, int64_t row, int64_t lane, int64_t head, uint8_t* to, const uint8_t* ahead) {
    const size_t bytes = frames_.geometry_.parts[part].bytes;
    if (frames_.packed_ && row < head) std::memcpy(to, decode(part, row, lane).data(), bytes);
    else copy(to, frames_.row(part, row) + static_cast<size_t>(lane) * bytes, bytes, ahead);
}

void Frames::Reader::read_final(size_t part, int64_t entry, int64_t row, int64_t lane, int64_t head, uint8_t* to) {
    const Part& size = frames_.geometry_.parts[part];
    const size_t slot = frames_.final_slot(entry);
    if (!frames_.packed_) {
        std::memcpy(to, frames_.block_ + frames_.layout_.finals[part] + slot * size.bytes, size.bytes);
        return;
    }
    read(part, row, lane, head, to);
    const PackedFrame frame = frames_.packed_table(frames_.layout_.packed_finals[part])[slot];
    const uint8_t* const code = frames_.packed_->find(frame);
    if (!code || !atari::memory::decode(code, frame.bytes, to, size.bytes, size.pitch)) std::memset(to, 0, size.bytes);
}

}  // namespace atari::memory
