// Pooling: the maximum of two frames in gray (Mnih et al. 2015).
//
// In frames of games most rows repeat the row above, and the others differ from it in a few places only. Pooling looks
// up colours only where a row differs from the row above. It reports these places, so that `AreaResize` skips the rest.
//
// A `SimdLevel` other than the chosen one is for tests: the results are the same.
#pragma once

#include <cstdint>

#include "fast/simd.hpp"

namespace atari {

// Writes the maximum of two frames of palette indices, rows x 160, in the gray values of `table` (256). Bit k of
// `changes` (rows) is set if either frame differs from its row above in columns 8k .. 8k+7. In the first row all bits
// are set.
void pool_gray(const uint8_t* early, const uint8_t* late, int rows, const uint8_t* table, uint8_t* out,
               uint32_t* changes, SimdLevel level = simd_level());

// `pool_gray` with a table of 65,536 gray values, by early * 256 + late.
void pool_pairs(const uint8_t* early, const uint8_t* late, int rows, const uint8_t* table, uint8_t* out,
                uint32_t* changes, SimdLevel level = simd_level());

}  // namespace atari
