// The two sound channels of the TIA.
#pragma once

#include <cstdint>

#include "tia_registers.hpp"

namespace atari {

inline constexpr int kAudioSamples = 512;  // samples of one act, at 31400 Hz

struct Sound {
    uint8_t audc[2], audf[2], audv[2];
    uint8_t counter[2], p4[2], p5[2];  // the generator

    void keep_generator_of(const Sound& other) {
        for (int i : {0, 1}) {
            counter[i] = other.counter[i];
            p4[i] = other.p4[i];
            p5[i] = other.p5[i];
        }
    }

    // Writes one of AUDC0 .. AUDV1.
    void write(uint8_t reg, uint8_t value) {
        uint8_t* const pair = reg < AUDF0 ? audc : reg < AUDV0 ? audf : audv;
        pair[(reg - AUDC0) & 1] = value & bits_of(reg);
    }

    // Generates 512 samples, unsigned around 128, from the present values of the registers.
    void make_samples(uint8_t* out);
};

}  // namespace atari
