#include "deflate.hpp"

#include <algorithm>
#include <array>

#include "hashes.hpp"

namespace atari::web {
namespace {

constexpr int kLongestCode = 15;
constexpr size_t kLengths = 29, kDistances = 30, kLongestMatch = 258, kFurthest = 32768;

struct Range {
    uint16_t first;
    uint8_t bits;  // extra bits
};

// The lengths of symbols 257..285 and the distances: groups of codes share a number of extra bits.
template <size_t count>
constexpr std::array<Range, count> ranges(uint16_t first, size_t plain, size_t group) {
    std::array<Range, count> found{};
    uint32_t next = first;
    for (size_t i = 0; i < count; ++i) {
        const auto bits = static_cast<uint8_t>(i < plain ? 0 : (i - plain) / group + 1);
        found[i] = {static_cast<uint16_t>(next), bits};
        next += 1u << bits;
    }
    return found;
}
constexpr auto kLengthRanges = [] {
    auto found = ranges<kLengths>(3, 8, 4);
    found[28] = {258, 0};
    return found;
}();
constexpr auto kDistanceRanges = ranges<kDistances>(1, 4, 2);

class BitReader {
  public:
    explicit BitReader(View stream) : stream_(stream) {}

    uint32_t bits(int count) {
        while (held_ < count) {
            if (at_ == stream_.size()) throw Refused("the packed bytes end too early");
            word_ |= uint32_t{stream_[at_++]} << held_;
            held_ += 8;
        }
        const uint32_t value = word_ & ((1u << count) - 1);
        word_ >>= count;
        held_ -= count;
        return value;
    }
    void to_byte() { word_ = 0, held_ = 0; }  // at most seven bits are held
    size_t left() const { return stream_.size() - at_; }
    View take(size_t size) {
        if (size > left()) throw Refused("the packed bytes end too early");
        at_ += size;
        return stream_.subspan(at_ - size, size);
    }

  private:
    View stream_;
    size_t at_ = 0;
    uint32_t word_ = 0;
    int held_ = 0;
};

// A canonical Huffman code, decoded bit by bit.
class HuffmanCode {
  public:
    // Throws Refused if more codes of some length are used than exist, or if some are left over. As in zlib, a code of
    // one symbol may be incomplete if `may_be_single`, and a code without symbols is an error only where it is read.
    explicit HuffmanCode(std::span<const uint8_t> lengths, bool may_be_single = true) {
        for (const uint8_t length : lengths) ++count_[length];
        count_[0] = 0;
        int unused = 1;
        size_t longest = 0;
        std::array<uint16_t, kLongestCode + 2> at{};
        for (int length = 1; length <= kLongestCode; ++length) {
            const auto index = static_cast<size_t>(length);
            unused = 2 * unused - count_[index];
            if (unused < 0) throw Refused("the packed bytes have an impossible code");
            if (count_[index]) longest = index;
            at[index + 1] = static_cast<uint16_t>(at[index] + count_[index]);
        }
        if (unused > 0 && longest > (may_be_single ? 1 : 0)) throw Refused("the packed bytes have an incomplete code");
        symbols_.resize(lengths.size());
        for (size_t symbol = 0; symbol < lengths.size(); ++symbol)
            if (lengths[symbol]) symbols_[at[lengths[symbol]]++] = static_cast<uint16_t>(symbol);
    }

    uint32_t read(BitReader& in) const {
        int code = 0, first = 0, index = 0;
        for (size_t length = 1; length <= kLongestCode; ++length) {
            code |= static_cast<int>(in.bits(1));
            const int count = count_[length];
            if (code - first < count) return symbols_[static_cast<size_t>(index + code - first)];
            index += count;
            first = (first + count) << 1;
            code <<= 1;
        }
        throw Refused("the packed bytes have an unknown code");
    }

  private:
    std::array<uint16_t, kLongestCode + 1> count_{};
    std::vector<uint16_t> symbols_;
};

std::array<uint8_t, 288> fixed_lengths() {
    std::array<uint8_t, 288> lengths{};
    for (size_t i = 0; i < 288; ++i) lengths[i] = i < 144 ? 8 : i < 256 ? 9 : i < 280 ? 7 : 8;
    return lengths;
}

void check_room(const Bytes& out, size_t more, size_t most) {
    if (more > most - out.size()) throw Refused("the unpacked bytes are too many");
}

void inflate_block(BitReader& in, const HuffmanCode& literals, const HuffmanCode& distances, Bytes& out, size_t most) {
    for (;;) {
        const uint32_t symbol = literals.read(in);
        if (symbol == 256) return;
        if (symbol < 256) {
            check_room(out, 1, most);
            out.push_back(static_cast<uint8_t>(symbol));
            continue;
        }
        if (symbol - 257 >= kLengths) throw Refused("the packed bytes have an unknown length");
        const Range length_range = kLengthRanges[symbol - 257];
        const size_t length = length_range.first + in.bits(length_range.bits);
        const uint32_t place = distances.read(in);
        if (place >= kDistances) throw Refused("the packed bytes have an unknown distance");
        const size_t distance = kDistanceRanges[place].first + in.bits(kDistanceRanges[place].bits);
        if (distance > out.size()) throw Refused("the packed bytes refer to bytes before their start");
        check_room(out, length, most);
        for (size_t i = 0; i < length; ++i) out.push_back(out[out.size() - distance]);
    }
}

void inflate_dynamic_block(BitReader& in, Bytes& out, size_t most) {
    static constexpr uint8_t kOrder[19] = {16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15};
    const size_t literals = in.bits(5) + 257, distances = in.bits(5) + 1, own = in.bits(4) + 4;
    if (literals > 286 || distances > kDistances) throw Refused("the packed bytes have too many codes");
    std::array<uint8_t, 19> own_lengths{};
    for (size_t i = 0; i < own; ++i) own_lengths[kOrder[i]] = static_cast<uint8_t>(in.bits(3));
    const HuffmanCode of_lengths(own_lengths, false);
    std::vector<uint8_t> lengths;
    while (lengths.size() < literals + distances) {
        const uint32_t symbol = of_lengths.read(in);
        if (symbol < 16) {
            lengths.push_back(static_cast<uint8_t>(symbol));
            continue;
        }
        if (symbol == 16 && lengths.empty()) throw Refused("the packed bytes repeat no length");
        const uint8_t repeated = symbol == 16 ? lengths.back() : 0;
        const size_t times = symbol == 16 ? 3 + in.bits(2) : symbol == 17 ? 3 + in.bits(3) : 11 + in.bits(7);
        if (times > literals + distances - lengths.size()) throw Refused("the packed bytes have too many lengths");
        lengths.insert(lengths.end(), times, repeated);
    }
    if (lengths[256] == 0) throw Refused("the packed bytes have no end");
    const std::span<const uint8_t> all(lengths);
    inflate_block(in, HuffmanCode(all.first(literals)), HuffmanCode(all.subspan(literals)), out, most);
}

// Returns the content of the stream at the front of `in`.
Bytes inflate_from(BitReader& in, size_t most) {
    Bytes out;
    for (bool last = false; !last;) {
        last = in.bits(1) != 0;
        const uint32_t kind = in.bits(2);
        if (kind == 0) {
            in.to_byte();
            const uint32_t size = in.bits(16), complement = in.bits(16);
            if (size != (complement ^ 0xffff)) throw Refused("the packed bytes have a damaged length");
            check_room(out, size, most);
            append(out, in.take(size));
        } else if (kind == 1) {
            static const HuffmanCode literals(fixed_lengths());
            static const HuffmanCode distances(Bytes(32, 5));
            inflate_block(in, literals, distances, out, most);
        } else if (kind == 2) {
            inflate_dynamic_block(in, out, most);
        } else {
            throw Refused("the packed bytes have a block of an unknown kind");
        }
    }
    return out;
}

class BitWriter {
  public:
    void bits(uint32_t value, int count) {
        word_ |= value << held_;
        for (held_ += count; held_ >= 8; held_ -= 8, word_ >>= 8) out_.push_back(static_cast<uint8_t>(word_));
    }
    // Huffman codes begin with their highest bit.
    void code(uint32_t value, int count) {
        for (int bit = count; bit-- > 0;) bits(value >> bit & 1, 1);
    }
    void symbol(uint32_t symbol) {  // by the fixed code
        if (symbol < 144) code(0x30 + symbol, 8);
        else if (symbol < 256) code(0x190 + symbol - 144, 9);
        else if (symbol < 280) code(symbol - 256, 7);
        else code(0xc0 + symbol - 280, 8);
    }
    void match(size_t length, size_t distance) {
        const auto index_of = [](const auto& ranges, size_t value) {
            size_t index = ranges.size() - 1;
            while (ranges[index].first > value) --index;
            return index;
        };
        const size_t l = index_of(kLengthRanges, length), d = index_of(kDistanceRanges, distance);
        symbol(static_cast<uint32_t>(257 + l));
        bits(static_cast<uint32_t>(length - kLengthRanges[l].first), kLengthRanges[l].bits);
        code(static_cast<uint32_t>(d), 5);
        bits(static_cast<uint32_t>(distance - kDistanceRanges[d].first), kDistanceRanges[d].bits);
    }
    Bytes finish() {
        if (held_ > 0) bits(0, 8 - held_);
        return std::move(out_);
    }

  private:
    Bytes out_;
    uint32_t word_ = 0;
    int held_ = 0;
};

// Finds the longest of the latest sequences that begin with the same three bytes.
class Matcher {
  public:
    explicit Matcher(View content) : content_(content), latest_(kHashes, -1), before_(content.size(), -1) {}

    size_t longest(size_t at, size_t& distance) {
        size_t best = 0;
        if (at + 3 > content_.size()) return best;
        int tries = kTries;
        for (int32_t from = latest_[hash(at)]; best < kLongEnough && from >= 0 && tries > 0;
             from = before_[static_cast<size_t>(from)], --tries) {
            const auto start = static_cast<size_t>(from);
            if (at - start > kFurthest) break;
            size_t length = 0;
            const size_t most = std::min(kLongestMatch, content_.size() - at);
            while (length < most && content_[start + length] == content_[at + length]) ++length;
            if (length > best) best = length, distance = at - start;
        }
        return best >= 3 ? best : 0;
    }
    void add(size_t at) {
        if (at + 3 > content_.size()) return;
        before_[at] = latest_[hash(at)];
        latest_[hash(at)] = static_cast<int32_t>(at);
    }

  private:
    static constexpr size_t kHashes = 4096;
    static constexpr int kTries = 32;
    static constexpr size_t kLongEnough = 64;

    size_t hash(size_t at) const {
        return (content_[at] * 0x9e5u ^ content_[at + 1] * 0x1fbu ^ content_[at + 2] * 0x3du) % kHashes;
    }

    View content_;
    std::vector<int32_t> latest_, before_;
};

}  // namespace

Bytes inflate(View stream, size_t most) {
    BitReader in(stream);
    Bytes out = inflate_from(in, most);
    if (in.left() > 0) throw Refused("there are bytes after the packed bytes");
    return out;
}

Bytes inflate_zlib(View stream, size_t most) {
    if (stream.size() < 6 || (stream[0] & 15) != 8 || stream[0] >> 4 > 7 || (stream[0] * 256 + stream[1]) % 31 != 0 ||
        (stream[1] & 32) != 0)
        throw Refused("the packed bytes are no zlib stream");
    BitReader in(stream.subspan(2));
    Bytes out = inflate_from(in, most);
    const View sum = in.take(4);
    if ((uint32_t{sum[0]} << 24 | sum[1] << 16 | sum[2] << 8 | sum[3]) != adler32(out))
        throw Refused("the unpacked bytes do not match their checksum");
    return out;
}

Bytes deflate(View content) {
    BitWriter out;
    Matcher matcher(content);
    out.bits(1, 1);  // one block, the last
    out.bits(1, 2);  // of fixed codes
    for (size_t at = 0; at < content.size();) {
        size_t distance = 0;
        const size_t length = matcher.longest(at, distance);
        if (length) out.match(length, distance);
        else out.symbol(content[at]);
        for (size_t end = at + std::max<size_t>(length, 1); at < end; ++at) matcher.add(at);
    }
    out.symbol(256);
    return out.finish();
}

Bytes deflate_zlib(View content) {
    Bytes out{0x78, 0x01};
    append(out, deflate(content));
    const uint32_t sum = adler32(content);
    for (int shift = 24; shift >= 0; shift -= 8) out.push_back(static_cast<uint8_t>(sum >> shift));
    return out;
}

}  // namespace atari::web
