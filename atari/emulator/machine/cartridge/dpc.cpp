#include "dpc.hpp"

namespace atari {
namespace {

// Advances the three voices' counters by the pulses of a 15750 Hz oscillator since the last access.
void update_music(CartridgeState& cart, uint32_t cycles) {
    const auto elapsed = static_cast<int32_t>(cycles - static_cast<uint32_t>(cart.stamp));
    cart.stamp = static_cast<int32_t>(cycles);
    const double pulses = (15750.0 * elapsed) / 1193191.66666667 + cart.fraction;
    const auto whole = static_cast<int32_t>(pulses);
    cart.fraction = pulses - whole;
    if (whole <= 0) return;
    for (int i = 5; i <= 7; ++i) {
        if (!cart.music[i]) continue;
        int low = cart.counter[i] & 0xff;
        const int top = cart.top[i];
        if (top == 0) {
            low = 0;
        } else {
            low -= whole <= top ? whole : whole % (top + 1);
            if (low < 0) low += top + 1;
        }
        if (low <= cart.bottom[i]) cart.flag[i] = 0;
        else if (low <= top) cart.flag[i] = 0xff;
        cart.counter[i] = static_cast<uint16_t>((cart.counter[i] & 0x700) | low);
    }
}

// Returns the sum of the three voices.
uint8_t music(CartridgeState& cart, uint32_t cycles) {
    static constexpr uint8_t kAmplitude[8] = {0, 4, 5, 9, 6, 10, 11, 15};
    update_music(cart, cycles);
    unsigned on = 0;
    for (unsigned k = 0; k < 3; ++k) on |= static_cast<unsigned>(cart.music[5 + k] && cart.flag[5 + k]) << k;
    return kAmplitude[on];
}

}  // namespace

void clock_dpc_random(CartridgeState& cart) { cart.random = kDpcRandom[cart.random]; }

uint8_t read_dpc(CartridgeState& cart, const uint8_t* image, unsigned offset, uint32_t cycles) {
    const unsigned i = offset & 7, counter = cart.counter[i];
    // The data are read before the stores below, or handlers would save a register for `image`.
    const uint8_t data = image[8192 + 2047 - counter], low = counter & 0xff;
    clock_dpc_random(cart);
    if (low == cart.top[i]) cart.flag[i] = 0xff;
    else if (low == cart.bottom[i]) cart.flag[i] = 0;
    if (i < 5 || !cart.music[i]) cart.counter[i] = (counter - 1) & 0x7ff;
    switch (offset >> 3 & 7) {
        case 0: return i < 4 ? cart.random : music(cart, cycles);
        case 1: return data;
        case 2: return data & cart.flag[i];
        case 7: return cart.flag[i];
        default: return 0;
    }
}

void write_dpc(CartridgeState& cart, unsigned offset, uint8_t value) {
    const unsigned i = offset & 7;
    switch (offset >> 3 & 7) {
        case 0:
            cart.top[i] = value;
            cart.flag[i] = 0;
            break;
        case 1: cart.bottom[i] = value; break;
        case 2:
            cart.counter[i] =
                static_cast<uint16_t>((cart.counter[i] & 0x700) | (i >= 5 && cart.music[i] ? cart.top[i] : value));
            break;
        case 3:
            cart.counter[i] = static_cast<uint16_t>((value & 7) << 8 | (cart.counter[i] & 0xff));
            if (i >= 5) cart.music[i] = value & 0x10;
            break;
        case 6: cart.random = 1; break;
        default: break;
    }
}

}  // namespace atari
