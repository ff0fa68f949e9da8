// The state of controllers and console switches. `Environment` writes it between frames; the RIOT and the TIA read it.
#pragma once

#include <cstdint>

#include "flag.hpp"

namespace atari {

struct Inputs {
    uint8_t switches;  // SWCHB
    uint8_t stick[2];  // bits 0-3: up, down, left, right pressed; player A, player B
    Flag fire[2];
    int32_t resistance[4];  // by paddle, in ohms
    Flag paddle_fire[4];
};

}  // namespace atari
