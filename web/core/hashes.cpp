#include "hashes.hpp"

#include <algorithm>
#include <array>
#include <cstring>

namespace atari::web {
namespace {

uint64_t rotated_right(uint64_t value, int bits) { return value >> bits | value << (64 - bits); }
uint32_t rotated_left(uint32_t value, int bits) { return value << bits | value >> (32 - bits); }

class Blake2b {
  public:
    explicit Blake2b(size_t digest_size) {
        std::copy_n(kStart, 8, state_);
        state_[0] ^= 0x01010000 ^ digest_size;
    }

    void add_block(const uint8_t* block, uint64_t bytes_so_far, bool last) {
        uint64_t words[16], v[16];
        std::memcpy(words, block, sizeof words);
        std::copy_n(state_, 8, v);
        std::copy_n(kStart, 8, v + 8);
        v[12] ^= bytes_so_far;
        if (last) v[14] = ~v[14];
        for (int round = 0; round < 12; ++round) {
            const uint8_t* const order = kOrders[round % 10];
            const auto mix = [&](int a, int b, int c, int d, int i) {
                v[a] += v[b] + words[order[i]];
                v[d] = rotated_right(v[d] ^ v[a], 32);
                v[c] += v[d];
                v[b] = rotated_right(v[b] ^ v[c], 24);
                v[a] += v[b] + words[order[i + 1]];
                v[d] = rotated_right(v[d] ^ v[a], 16);
                v[c] += v[d];
                v[b] = rotated_right(v[b] ^ v[c], 63);
            };
            for (int i = 0; i < 4; ++i) mix(i, 4 + i, 8 + i, 12 + i, 2 * i);
            for (int i = 0; i < 4; ++i) mix(i, 4 + (i + 1) % 4, 8 + (i + 2) % 4, 12 + (i + 3) % 4, 8 + 2 * i);
        }
        for (int i = 0; i < 8; ++i) state_[i] ^= v[i] ^ v[i + 8];
    }

    Bytes digest(size_t size) const {
        Bytes all(sizeof state_);
        std::memcpy(all.data(), state_, sizeof state_);
        all.resize(size);
        return all;
    }

  private:
    static constexpr uint64_t kStart[8] = {0x6a09e667f3bcc908, 0xbb67ae8584caa73b, 0x3c6ef372fe94f82b,
                                           0xa54ff53a5f1d36f1, 0x510e527fade682d1, 0x9b05688c2b3e6c1f,
                                           0x1f83d9abfb41bd6b, 0x5be0cd19137e2179};
    static constexpr uint8_t kOrders[10][16] = {
        {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15}, {14, 10, 4, 8, 9, 15, 13, 6, 1, 12, 0, 2, 11, 7, 5, 3},
        {11, 8, 12, 0, 5, 2, 15, 13, 10, 14, 3, 6, 7, 1, 9, 4}, {7, 9, 3, 1, 13, 12, 11, 14, 2, 6, 5, 10, 4, 0, 15, 8},
        {9, 0, 5, 7, 2, 4, 10, 15, 14, 1, 11, 12, 6, 8, 3, 13}, {2, 12, 6, 10, 0, 11, 8, 3, 4, 13, 7, 5, 15, 14, 1, 9},
        {12, 5, 1, 15, 14, 13, 4, 10, 0, 7, 6, 3, 9, 2, 8, 11}, {13, 11, 7, 14, 12, 1, 3, 9, 5, 0, 15, 4, 8, 6, 2, 10},
        {6, 15, 14, 9, 11, 3, 0, 8, 12, 2, 13, 7, 1, 4, 10, 5}, {10, 2, 8, 4, 7, 6, 1, 5, 15, 11, 9, 14, 3, 12, 13, 0},
    };

    uint64_t state_[8];
};

// The constants of MD5: floor(2^32 * |sin(i + 1)|).
constexpr uint32_t kSines[64] = {
    0xd76aa478, 0xe8c7b756, 0x242070db, 0xc1bdceee, 0xf57c0faf, 0x4787c62a, 0xa8304613, 0xfd469501,
    0x698098d8, 0x8b44f7af, 0xffff5bb1, 0x895cd7be, 0x6b901122, 0xfd987193, 0xa679438e, 0x49b40821,
    0xf61e2562, 0xc040b340, 0x265e5a51, 0xe9b6c7aa, 0xd62f105d, 0x02441453, 0xd8a1e681, 0xe7d3fbc8,
    0x21e1cde6, 0xc33707d6, 0xf4d50d87, 0x455a14ed, 0xa9e3e905, 0xfcefa3f8, 0x676f02d9, 0x8d2a4c8a,
    0xfffa3942, 0x8771f681, 0x6d9d6122, 0xfde5380c, 0xa4beea44, 0x4bdecfa9, 0xf6bb4b60, 0xbebfbc70,
    0x289b7ec6, 0xeaa127fa, 0xd4ef3085, 0x04881d05, 0xd9d4d039, 0xe6db99e5, 0x1fa27cf8, 0xc4ac5665,
    0xf4292244, 0x432aff97, 0xab9423a7, 0xfc93a039, 0x655b59c3, 0x8f0ccc92, 0xffeff47d, 0x85845dd1,
    0x6fa87e4f, 0xfe2ce6e0, 0xa3014314, 0x4e0811a1, 0xf7537e82, 0xbd3af235, 0x2ad7d2bb, 0xeb86d391,
};

void add_md5_block(std::array<uint32_t, 4>& state, const uint8_t* block) {
    static constexpr int kTurns[4][4] = {{7, 12, 17, 22}, {5, 9, 14, 20}, {4, 11, 16, 23}, {6, 10, 15, 21}};
    uint32_t words[16];
    std::memcpy(words, block, sizeof words);
    auto [a, b, c, d] = state;
    for (uint32_t i = 0; i < 64; ++i) {
        const uint32_t round = i / 16;
        const uint32_t mixed = round == 0   ? (b & c) | (~b & d)
                               : round == 1 ? (d & b) | (~d & c)
                               : round == 2 ? b ^ c ^ d
                                            : c ^ (b | ~d);
        const uint32_t word = words[round == 0   ? i
                                    : round == 1 ? (5 * i + 1) % 16
                                    : round == 2 ? (3 * i + 5) % 16
                                                 : 7 * i % 16];
        const uint32_t turned = rotated_left(a + mixed + kSines[i] + word, kTurns[round][i % 4]);
        a = d;
        d = c;
        c = b;
        b += turned;
    }
    state[0] += a;
    state[1] += b;
    state[2] += c;
    state[3] += d;
}

}  // namespace

uint16_t crc16(View bytes) {
    uint32_t sum = 0;
    for (const uint8_t byte : bytes) {
        sum ^= uint32_t{byte} << 8;
        for (int bit = 0; bit < 8; ++bit) sum = sum << 1 ^ (sum & 0x8000 ? 0x1021 : 0);
    }
    return static_cast<uint16_t>(sum);
}

uint32_t adler32(View bytes) {
    uint32_t low = 1, high = 0;
    for (const uint8_t byte : bytes) {
        low = (low + byte) % 65521;
        high = (high + low) % 65521;
    }
    return high << 16 | low;
}

Bytes blake2b(View bytes, size_t digest_size) {
    Blake2b hash(digest_size);
    size_t done = 0;
    for (; bytes.size() - done > 128; done += 128) hash.add_block(bytes.data() + done, done + 128, false);
    uint8_t last[128]{};
    std::copy(bytes.begin() + static_cast<std::ptrdiff_t>(done), bytes.end(), last);
    hash.add_block(last, bytes.size(), true);
    return hash.digest(digest_size);
}

Bytes md5(View bytes) {
    std::array<uint32_t, 4> state{0x67452301, 0xefcdab89, 0x98badcfe, 0x10325476};
    Bytes padded(bytes.begin(), bytes.end());
    padded.push_back(0x80);
    while (padded.size() % 64 != 56) padded.push_back(0);
    const uint64_t bits = uint64_t{bytes.size()} * 8;
    append_number(padded, static_cast<uint32_t>(bits), 4);
    append_number(padded, static_cast<uint32_t>(bits >> 32), 4);
    for (size_t at = 0; at < padded.size(); at += 64) add_md5_block(state, padded.data() + at);
    Bytes digest;
    for (const uint32_t word : state) append_number(digest, word, 4);
    return digest;
}

std::string hex(View bytes) {
    std::string text;
    for (const uint8_t byte : bytes) {
        text += "0123456789abcdef"[byte >> 4];
        text += "0123456789abcdef"[byte & 15];
    }
    return text;
}

}  // namespace atari::web
