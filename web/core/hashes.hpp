// The hashes of the project's files: CRC-16 and CRC-32 of replays, BLAKE2b of snapshots, Adler-32 of zlib, and MD5, by
// which ROM images are recognised.
#pragma once

#include <cstdint>
#include <string>

#include "bytes.hpp"

namespace atari::web {

uint16_t crc16(View bytes);  // CRC-16 CCITT, from 0, as `binascii.crc_hqx`
uint32_t adler32(View bytes);
Bytes blake2b(View bytes, size_t digest_size);  // RFC 7693, without a key; 1..64 bytes
Bytes md5(View bytes);                          // RFC 1321

std::string hex(View bytes);

}  // namespace atari::web
