// The CRC-32 of zlib, eight bytes at a time: the programs of this folder must not need zlib for each platform.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace atari {

using Crc32Tables = std::array<std::array<uint32_t, 256>, 8>;

constexpr Crc32Tables make_crc32_tables() {
    Crc32Tables tables{};
    for (uint32_t byte = 0; byte < 256; ++byte) {
        uint32_t sum = byte;
        for (int bit = 0; bit < 8; ++bit) sum = (sum >> 1) ^ (sum & 1 ? 0xedb88320 : 0);
        tables[0][byte] = sum;
    }
    for (size_t i = 1; i < 8; ++i) {
        for (size_t byte = 0; byte < 256; ++byte) {
            const uint32_t before = tables[i - 1][byte];
            tables[i][byte] = (before >> 8) ^ tables[0][before & 0xff];
        }
    }
    return tables;
}

// Continues the sum `crc` (0 at the beginning) over these bytes.
inline uint32_t crc32(uint32_t crc, const uint8_t* data, size_t size) {
    static constexpr Crc32Tables kTables = make_crc32_tables();
    crc = ~crc;
    for (; size >= 8; size -= 8, data += 8) {
        uint32_t next = 0;
        for (size_t i = 0; i < 4; ++i) next ^= kTables[7 - i][data[i] ^ ((crc >> (8 * i)) & 0xff)];
        for (size_t i = 4; i < 8; ++i) next ^= kTables[7 - i][data[i]];
        crc = next;
    }
    for (; size > 0; --size, ++data) crc = (crc >> 8) ^ kTables[0][(crc ^ *data) & 0xff];
    return ~crc;
}

}  // namespace atari
