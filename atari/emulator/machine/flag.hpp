// A truth value in a byte. Unlike a `bool` it is defined for every byte that a damaged state may hold.
#pragma once

#include <cstdint>

namespace atari {

struct Flag {
    uint8_t value;
    Flag& operator=(bool on) {
        value = on;
        return *this;
    }
    operator bool() const { return value != 0; }
};

}  // namespace atari
