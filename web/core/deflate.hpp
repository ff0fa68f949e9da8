// DEFLATE (RFC 1951), raw and within zlib's frame (RFC 1950).
#pragma once

#include "bytes.hpp"

namespace atari::web {

// Returns the content of a raw stream of at most `most` bytes. Throws Refused if it is damaged, longer, cut, or has bytes
// after its end.
Bytes inflate(View stream, size_t most);
// The same for a zlib stream, whose checksum is compared.
Bytes inflate_zlib(View stream, size_t most);

// Compresses by repeated sequences and the fixed codes, which suit short texts; no stream is much longer than its content.
Bytes deflate(View content);
Bytes deflate_zlib(View content);

}  // namespace atari::web
