// The two sound channels: dividers and shift registers, one step a sample.
//
// Samples are generated once for each act, from the last values of the registers, as in ALE. The times of writes inside
// a frame have no effect. The generator is never reset.
#include "sound.hpp"

namespace atari {
namespace {

struct Shifts {
    uint8_t p4, p5;
};

uint8_t poly4(uint8_t p4) { return p4 ? static_cast<uint8_t>((p4 << 1 | ((p4 >> 3 ^ p4 >> 2) & 1)) & 15) : 1; }
uint8_t poly5(uint8_t p5) { return p5 ? static_cast<uint8_t>((p5 << 1 | ((p5 >> 4 ^ p5 >> 2) & 1)) & 31) : 1; }
uint8_t push4(uint8_t p4, int bit) { return static_cast<uint8_t>((p4 << 1 | bit) & 15); }
uint8_t div2(uint8_t p4) { return push4(p4, ~p4 & 1); }
uint8_t div6(uint8_t p4) { return static_cast<uint8_t>(((~p4 << 1) & 14) | ((p4 & 4) == 0 && (p4 & 7) != 0)); }

Shifts step(Shifts old, int mode) {
    const int top4 = old.p4 >> 3 & 1, top5 = old.p5 >> 4 & 1;
    if (mode == 0 || mode == 11) return {push4(old.p4, 1), old.p5};
    if (mode == 1) return {poly4(old.p4), old.p5};
    if (mode == 4 || mode == 5) return {div2(old.p4), old.p5};
    if (mode == 12 || mode == 13) return {div6(old.p4), old.p5};
    if (mode == 8) {
        if (!old.p4 && !old.p5) return {0, 1};
        return {push4(old.p4, top5), static_cast<uint8_t>((old.p5 << 1 | (top4 ^ top5)) & 31)};
    }
    const uint8_t p5 = poly5(old.p5);
    if (mode == 9) return {push4(old.p4, top5), p5};
    // In all other modes, the five-bit register gates the clock of the four-bit one.
    const bool gate = mode == 3 || mode == 7 || mode == 15 ? (p5 & 16) != 0 : (p5 & 15) == 8;
    if (!gate) return {old.p4, p5};
    if (mode == 2 || mode == 3) return {poly4(old.p4), p5};
    if (mode == 6 || mode == 7) return {div2(old.p4), p5};
    if (mode == 10) return {push4(old.p4, p5 >> 4 & 1), p5};
    return {div6(old.p4), p5};
}

}  // namespace

void Sound::make_samples(uint8_t* out) {
    for (int i = 0; i < kAudioSamples; ++i) {
        int sample = 128;
        for (int k = 0; k < 2; ++k) {
            if (++counter[k] > audf[k]) {
                counter[k] = 0;
                const Shifts next = step({p4[k], p5[k]}, audc[k]);
                p4[k] = next.p4;
                p5[k] = next.p5;
            }
            if (p4[k] & 8) sample += 4 * audv[k];
        }
        out[i] = static_cast<uint8_t>(sample);
    }
}

}  // namespace atari
