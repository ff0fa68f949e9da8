// Snapshots as the portable bytes of atari/cores/snapshot.py: of one core, with its state as the only blob.
#pragma once

#include <string_view>

#include "bytes.hpp"

namespace atari::web {

// Returns the bytes of a snapshot with these facts, an object of JSON, and a state.
Bytes pack_snapshot(std::string_view facts, View state);

// Returns the state. Throws Refused if the bytes are no snapshot, of another version, damaged, or if one of the
// `expected` facts, an object of JSON, has another value; "sound" may differ if `any_sound`.
Bytes unpack_snapshot(View snapshot, std::string_view expected, bool any_sound = false);

}  // namespace atari::web
