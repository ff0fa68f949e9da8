// The pixels that an object of the TIA covers in its present state.
#pragma once

#include <new>

#include "masks.hpp"
#include "tia_state.hpp"

namespace atari {

Mask object_mask(const Tia& tia, int object);

// Constructs the mask in place: a copy right after the construction would stall on its stores.
inline void make_mask(Mask& mask, const Tia& tia, int object) { new (&mask) Mask(object_mask(tia, object)); }

// Returns the graphics that a player shows: the new ones or the delayed ones.
inline uint8_t shown_graphics(const Tia& tia, int player) {
    return tia.vdelp[player] ? tia.old_grp[player] : tia.grp[player];
}

}  // namespace atari
