#include "codec.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

namespace atari::memory {
namespace {

// The first byte of a code: the prediction of the frame.
enum Kind : uint8_t { kFromBefore = 0, kFromAbove = 1, kPlain = 2 };

// After the kind, a code repeats three fields: the number of bytes that are as predicted, the number of bytes that are
// not, and these bytes. The rest of the frame is as predicted. Lengths have 7 bits a byte, the lowest first.
constexpr size_t kShortestMatch = 4;  // a shorter match saves nothing: its two lengths take as much

uint64_t word_at(const uint8_t* bytes) {
    uint64_t word;
    std::memcpy(&word, bytes, sizeof word);
    return word;
}

int equal_bytes(uint64_t difference) {
    return (std::endian::native == std::endian::little ? std::countr_zero(difference) : std::countl_zero(difference)) /
           8;
}

// Returns the number of equal bytes from `start` on.
size_t match(const uint8_t* a, const uint8_t* b, size_t start, size_t end) {
    size_t i = start;
    for (; i + 64 <= end; i += 64) {
        uint64_t difference = 0;
        for (size_t j = 0; j < 64; j += 8) difference |= word_at(a + i + j) ^ word_at(b + i + j);
        if (difference) break;
    }
    for (; i + 8 <= end; i += 8)
        if (const uint64_t difference = word_at(a + i) ^ word_at(b + i))
            return i + static_cast<size_t>(equal_bytes(difference)) - start;
    while (i < end && a[i] == b[i]) ++i;
    return i - start;
}

// Returns the number of bytes from `start` to the next match that is long enough.
size_t mismatch(const uint8_t* a, const uint8_t* b, size_t start, size_t end) {
    size_t equal = 0;
    for (size_t i = start; i < end; ++i) {
        equal = a[i] == b[i] ? equal + 1 : 0;
        if (equal == kShortestMatch) return i + 1 - equal - start;
    }
    return end - equal - start;
}

size_t put_length(uint8_t* out, size_t length) {
    size_t size = 0;
    for (; length >= 128; length >>= 7) out[size++] = static_cast<uint8_t>(length | 128);
    out[size++] = static_cast<uint8_t>(length);
    return size;
}

// Writes the frame as differences from `predicted`. Returns 0 if the code would have `most` bytes or more.
size_t encode_from(const uint8_t* predicted, const uint8_t* frame, size_t bytes, Kind kind, uint8_t* out, size_t most) {
    out[0] = kind;
    size_t size = 1;
    for (size_t i = 0; i < bytes;) {
        const size_t same = match(frame, predicted, i, bytes);
        if (i + same == bytes) break;
        const size_t other = mismatch(frame, predicted, i + same, bytes);
        if (size + other + 20 > most) return 0;
        size += put_length(out + size, same);
        size += put_length(out + size, other);
        std::memcpy(out + size, frame + i + same, other);
        size += other;
        i += same + other;
    }
    return size;
}

// Copies `count` bytes from `pitch` bytes before `to`. If source and target overlap, new bytes are copied again.
void copy_from_above(uint8_t* to, size_t count, size_t pitch) {
    for (size_t done = 0; done < count;) {
        const size_t part = std::min(count - done, pitch);
        std::memcpy(to + done, to + done - pitch, part);
        done += part;
    }
}

bool get_length(const uint8_t*& code, const uint8_t* end, size_t& length) {
    length = 0;
    for (int shift = 0; shift < 35; shift += 7) {
        if (code == end) return false;
        const uint8_t byte = *code++;
        length |= static_cast<size_t>(byte & 127) << shift;
        if (byte < 128) return true;
    }
    return false;
}

}  // namespace

size_t encode(const uint8_t* frame, const uint8_t* before, size_t bytes, size_t pitch, uint8_t* out,
              EncoderScratch& scratch) {
    size_t size = before ? encode_from(before, frame, bytes, kFromBefore, out, bytes) : 0;
    if (size > 0 && size < bytes / 16) return size;
    // The row above the first row counts as 0, so the prediction is a row of zeros and then the frame.
    auto& [above, code] = scratch;
    above.assign(pitch, 0);
    above.insert(above.end(), frame, frame + bytes - pitch);
    code.resize(most_encoded(bytes));
    const size_t other = encode_from(above.data(), frame, bytes, kFromAbove, code.data(), size > 0 ? size : bytes);
    if (other > 0) {
        std::memcpy(out, code.data(), other);
        return other;
    }
    if (size > 0) return size;
    out[0] = kPlain;
    std::memcpy(out + 1, frame, bytes);
    return bytes + 1;
}

bool decode(const uint8_t* code, size_t size, uint8_t* frame, size_t bytes, size_t pitch) {
    if (size == 0 || pitch == 0 || pitch > bytes) return false;
    const uint8_t* const end = code + size;
    const uint8_t kind = *code++;
    if (kind == kPlain) {
        if (size != bytes + 1) return false;
        std::memcpy(frame, code, bytes);
        return true;
    }
    if (kind > kPlain) return false;
    size_t i = 0;
    const auto predict = [&](size_t count) {
        if (kind == kFromAbove) {
            const size_t first = i < pitch ? std::min(count, pitch - i) : 0;
            std::memset(frame + i, 0, first);
            copy_from_above(frame + i + first, count - first, pitch);
        }
        i += count;
    };
    while (code < end) {
        size_t same, other;
        if (!get_length(code, end, same) || !get_length(code, end, other)) return false;
        if (same > bytes - i || other > bytes - i - same || other > static_cast<size_t>(end - code)) return false;
        predict(same);
        std::memcpy(frame + i, code, other);
        code += other;
        i += other;
    }
    predict(bytes - i);
    return true;
}

}  // namespace atari::memory
