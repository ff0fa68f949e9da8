// Cartridge accesses: bank switching, cartridge RAM, and the DPC chip of Pitfall II.
#include "console.hpp"

#include <algorithm>
#include <array>

#include "tia_registers.hpp"

namespace atari {

using Type = CartridgeType;

// Writes to these addresses choose the ROM bank of 3F and 3E, and the RAM page of 3E.
constexpr uint16_t kSelectRam = 0x3e, kSelectRom = 0x3f;

// Maps image bytes to the window by type and bank: 16 segments of 1 KiB, by bits 10 to 13 of the address. Bit 12
// selects the cartridge; by bit 13 FE chooses its bank.
void Console::map_segments() {
    const CartridgeState& cart = m_.cart;
    const auto size = static_cast<uint32_t>(cartridge_->size());
    uint32_t first[4];
    for (uint32_t i = 0; i < 4; ++i) first[i] = 4096u * cart.bank + 1024 * i;
    switch (cartridge_->type()) {
        case Type::k2K:
            for (uint32_t i = 0; i < 4; ++i) first[i] = 1024 * (i & 1);
            break;
        case Type::kE0:
            for (int i = 0; i < 4; ++i) first[i] = 1024u * cart.slice[i];
            break;
        case Type::k3F:
        case Type::k3E:
        case Type::kCV:
        case Type::kE7: {
            const bool last_is_7 = cartridge_->type() == Type::kE7;
            for (uint32_t i = 0; i < 2; ++i) first[i] = 2048u * (last_is_7 ? cart.slice[0] : cart.bank) + 1024 * i;
            for (uint32_t i = 0; i < 2; ++i) first[2 + i] = (last_is_7 ? 16384 : size) - 2048 + 1024 * i;
            break;
        }
        default: break;
    }
    for (uint32_t i = 0; i < 4; ++i) {
        segment_[4 + i] = cartridge_->type() == Type::kFE ? 4096 + first[i] : first[i];
        segment_[12 + i] = first[i];
    }
}

// Reads an address that is not constant ROM. A bank switch happens before the fetch, so the byte comes from the new
// bank.
uint8_t Console::read_cartridge(uint16_t address) {
    const uint8_t* image = cartridge_->image();
    const CartridgeState& cart = m_.cart;
    const uint16_t offset = address & 0xfff;
    switch (cartridge_->type()) {
        case Type::kDPC:
            if (offset < 0x80 || offset >= 0xfc0) return read_dpc(offset);
            break;
        case Type::kE7:
            hotspot(offset, true);
            if (offset < 0x800 && cart.slice[0] == 7)
                return offset >= 0x400 ? cart_ram_[offset & 0x3ff] : image[2048 * 7 + offset];
            if (offset >= 0x900 && offset < 0xa00)
                return cart_ram_[1024u + 256u * (cart.slice[1] & 3) + (offset & 0xff)];
            break;
        case Type::k3E:
            if (offset < 0x800 && cart.slice[2]) return cart_ram_[1024u * cart.slice[1] + (offset & 0x3ff)];
            break;
        case Type::kCV:
            if (offset < 0x800) return cart_ram_[offset & 0x3ff];
            break;
        case Type::kF8SC:
        case Type::kF6SC:
        case Type::kF4SC:
            if (offset >= 0x80 && offset < 0x100) return cart_ram_[offset & 0x7f];
            hotspot(offset, true);
            break;
        case Type::kFASC:
            if (offset >= 0x100 && offset < 0x200) return cart_ram_[offset & 0xff];
            hotspot(offset, true);
            break;
        default: hotspot(offset, true);
    }
    return image[segment_[(address >> 10 & 15) | 4] + (offset & 0x3ff)];  // 3F and 3E map ROM below the window, too
}

void Console::write_cartridge(uint16_t address, uint8_t value) {
    const uint16_t offset = address & 0xfff;
    switch (cartridge_->type()) {
        case Type::kDPC: return write_dpc(offset, value);
        case Type::kF8SC:
        case Type::kF6SC:
        case Type::kF4SC:
            if (offset < 0x80) cart_ram_[offset] = value;
            break;
        case Type::kFASC:
            if (offset < 0x100) cart_ram_[offset] = value;
            break;
        case Type::kE7:
            if (offset < 0x400 && m_.cart.slice[0] == 7) cart_ram_[offset] = value;
            if (offset >= 0x800 && offset < 0x900)
                cart_ram_[1024u + 256u * (m_.cart.slice[1] & 3) + (offset & 0xff)] = value;
            break;
        case Type::kCV:
            if (offset >= 0x400 && offset < 0x800) cart_ram_[offset & 0x3ff] = value;
            return;
        case Type::k3E:
            if (m_.cart.slice[2] && offset >= 0x400 && offset < 0x800) {
                cart_ram_[1024u * m_.cart.slice[1] + (offset & 0x3ff)] = value;
                return;
            }
            [[fallthrough]];
        case Type::k3F:
            select_slice(offset, value);
            return write_tia(tia_register(offset), value);  // other addresses reach the TIA
        default: break;
    }
    hotspot(offset, false);
}

// Switches banks and slices. Reads and writes have the same effect.
void Console::hotspot(uint16_t offset, bool reading) {
    if (offset < 0xfe0) return;
    CartridgeState& cart = m_.cart;
    const uint8_t bank_before = cart.bank;
    const std::array<uint8_t, 4> slices_before = std::to_array(cart.slice);
    const auto switch_bank = [&](int first, int count) {
        if (offset >= first && offset < first + count) cart.bank = static_cast<uint8_t>(offset - first);
    };
    switch (cartridge_->type()) {
        case Type::kF8:
        case Type::kF8Swapped:
        case Type::kF8SC: switch_bank(0xff8, 2); break;
        case Type::kF6:
        case Type::kF6SC: switch_bank(0xff6, 4); break;
        case Type::kF4: switch_bank(0xff4, 8); break;
        case Type::kF4SC:
            if (reading) switch_bank(0xff4, 8);  // a defect of the reference that is kept
            break;
        case Type::kFASC: switch_bank(0xff8, 3); break;
        case Type::kMB:
            if (offset == 0xff0) cart.bank = (cart.bank + 1) & 15;
            break;
        case Type::kE0:
            if (offset >= 0xfe0 && offset < 0xff8) cart.slice[(offset - 0xfe0) >> 3] = offset & 7;
            break;
        case Type::kE7:
            if (offset >= 0xfe0 && offset < 0xfe8) cart.slice[0] = offset & 7;
            if (offset >= 0xfe8 && offset < 0xfec) cart.slice[1] = offset & 3;
            break;
        default: break;
    }
    if (cart.bank != bank_before || std::to_array(cart.slice) != slices_before) map_segments();
}

// Handles a write to TIA space on a 3F or 3E cartridge, which selects what the lower half of the window maps.
void Console::select_slice(uint16_t offset, uint8_t value) {
    CartridgeState& cart = m_.cart;
    const bool has_ram = cartridge_->type() == Type::k3E;
    if (has_ram && offset == kSelectRam) {
        cart.slice[1] = value & 31;
        cart.slice[2] = 1;
    } else if (offset == kSelectRom || (!has_ram && offset < kSelectRom)) {
        cart.bank = static_cast<uint8_t>(value % (cartridge_->size() / 2048));
        cart.slice[2] = 0;
    }
    map_segments();
}

// Returns whether the cartridge drives a read of TIA space: 3F and 3E do in the TIA's first page. UA switches banks at
// two addresses in TIA space.
bool Console::cartridge_answers(uint16_t address) {
    if (!watches_tia_) return false;
    if (cartridge_->type() != Type::kUA) return (address & 0x1fff) < 0x40;
    cartridge_watches(address, 0);
    return false;
}

void Console::cartridge_watches(uint16_t address, uint8_t value) {
    const uint16_t place = address & 0x1fff;
    if (cartridge_->type() == Type::kUA) {
        if (place == 0x220) m_.cart.bank = 0;
        if (place == 0x240) m_.cart.bank = 1;
        map_segments();
    } else if (place < 0x40) {
        select_slice(place, value);
    }
}

// --- DPC: eight data fetchers, a random number generator and three square waves ---

void Console::switch_dpc_bank(uint16_t offset) {
    if (offset != 0xff8 && offset != 0xff9) return;
    const uint8_t bank = offset & 1;
    if (m_.cart.bank == bank) return;
    m_.cart.bank = bank;
    map_segments();
}

uint8_t Console::read_dpc(uint16_t offset) {
    if (offset < 0x40) return read_fetcher(offset);
    clock_dpc_random();
    switch_dpc_bank(offset);
    return image_[4096 * m_.cart.bank + offset];
}

uint8_t Console::read_fetcher(unsigned offset) {
    CartridgeState& cart = m_.cart;
    clock_dpc_random();
    const unsigned function = offset >> 3 & 7, i = offset & 7;
    const unsigned counter = cart.counter[i], low = counter & 0xff;
    if (low == cart.top[i]) cart.flag[i] = 0xff;
    else if (low == cart.bottom[i]) cart.flag[i] = 0;
    if (i < 5 || !cart.music[i]) cart.counter[i] = (counter - 1) & 0x7ff;
    switch (function) {
        case 0: return i < 4 ? cart.random : dpc_music();
        case 1: return image_[8192 + 2047 - counter];
        case 2: return image_[8192 + 2047 - counter] & cart.flag[i];
        case 7: return cart.flag[i];
        default: return 0;
    }
}

// Returns the sum of the three voices.
uint8_t Console::dpc_music() {
    static constexpr uint8_t kAmplitude[8] = {0, 4, 5, 9, 6, 10, 11, 15};
    update_dpc_music();
    const CartridgeState& cart = m_.cart;
    unsigned on = 0;
    for (unsigned k = 0; k < 3; ++k) on |= static_cast<unsigned>(cart.music[5 + k] && cart.flag[5 + k]) << k;
    return kAmplitude[on];
}

void Console::write_dpc(uint16_t offset, uint8_t value) {
    CartridgeState& cart = m_.cart;
    clock_dpc_random();
    switch_dpc_bank(offset);
    if (offset < 0x40 || offset >= 0x80) return;
    const int i = offset & 7;
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

// Advances the counters of the three voices by the pulses since the last access, of an oscillator of 15750 Hz.
void Console::update_dpc_music() {
    CartridgeState& cart = m_.cart;
    const auto elapsed = static_cast<int32_t>(m_.cycles - static_cast<uint32_t>(cart.stamp));
    cart.stamp = static_cast<int32_t>(m_.cycles);
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

// Selects the power-on banks and fills the cartridge's RAM with random bytes. The DPC's registers keep their values.
void Console::reset_cartridge() {
    CartridgeState& cart = m_.cart;
    switch (cartridge_->type()) {
        case Type::kF8:
        case Type::kF8SC:
        case Type::kDPC:
        case Type::kMB: cart.bank = 1; break;
        case Type::kFASC: cart.bank = 2; break;
        default: cart.bank = 0; break;
    }
    for (int i = 0; i < 4; ++i) cart.slice[i] = cartridge_->type() == Type::kE0 ? static_cast<uint8_t>(4 + i) : 0;
    cart.stamp = static_cast<int32_t>(m_.cycles);
    cart.fraction = 0.0;
    for (size_t i = 0; i < cartridge_->random_bytes(); ++i) cart_ram_[i] = static_cast<uint8_t>(machine_word());
    if (cartridge_->type() == Type::kCV && cartridge_->random_bytes() == 0)
        std::copy_n(cartridge_->image(), cart_ram_.size(), cart_ram_.begin());
    map_segments();
}

}  // namespace atari
