#include "bankswitching.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "dpc.hpp"
#include "machine/raster.hpp"

namespace atari {

using Type = CartridgeType;

// Writes to these addresses choose the ROM bank of 3F and 3E, and the RAM page of 3E.
constexpr uint16_t kSelectRam = 0x3e, kSelectRom = 0x3f;

CartridgeSlot::CartridgeSlot(std::shared_ptr<const Cartridge> cartridge, CartridgeState& state, Listener& heard)
    : image(cartridge->image()), plain(cartridge->plain_window()), watches_tia(cartridge->watches_tia()),
      ram(cartridge->ram_size()), cart(state), listener(heard), inserted(std::move(cartridge)) {}

// Bit 12 of the address selects the cartridge; by bit 13 FE chooses its bank.
void CartridgeSlot::map_segments() {
    const auto size = static_cast<uint32_t>(inserted->size());
    uint32_t first[4];
    for (uint32_t i = 0; i < 4; ++i) first[i] = 4096u * cart.bank + 1024 * i;
    switch (inserted->type()) {
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
            const bool last_is_7 = inserted->type() == Type::kE7;
            for (uint32_t i = 0; i < 2; ++i) first[i] = 2048u * (last_is_7 ? cart.slice[0] : cart.bank) + 1024 * i;
            for (uint32_t i = 0; i < 2; ++i) first[2 + i] = (last_is_7 ? 16384 : size) - 2048 + 1024 * i;
            break;
        }
        default: break;
    }
    for (uint32_t i = 0; i < 4; ++i) {
        segment[4 + i] = inserted->type() == Type::kFE ? 4096 + first[i] : first[i];
        segment[12 + i] = first[i];
    }
    listener.segments_changed();
}

uint8_t CartridgeSlot::read(uint16_t address, uint32_t cycles) {
    const uint16_t offset = address & 0xfff;
    switch (inserted->type()) {
        case Type::kDPC:
            if (offset < 0x40) return read_dpc(cart, image, offset, cycles);
            if (offset < 0x80 || offset >= 0xfc0) access_dpc(offset);
            break;
        case Type::kE7:
            hotspot(offset, true);
            if (offset < 0x800 && cart.slice[0] == 7)
                return offset >= 0x400 ? ram[offset & 0x3ff] : image[2048 * 7 + offset];
            if (offset >= 0x900 && offset < 0xa00) return ram[1024u + 256u * (cart.slice[1] & 3) + (offset & 0xff)];
            break;
        case Type::k3E:
            if (offset < 0x800 && cart.slice[2]) return ram[1024u * cart.slice[1] + (offset & 0x3ff)];
            break;
        case Type::kCV:
            if (offset < 0x800) return ram[offset & 0x3ff];
            break;
        case Type::kF8SC:
        case Type::kF6SC:
        case Type::kF4SC:
            if (offset >= 0x80 && offset < 0x100) return ram[offset & 0x7f];
            hotspot(offset, true);
            break;
        case Type::kFASC:
            if (offset >= 0x100 && offset < 0x200) return ram[offset & 0xff];
            hotspot(offset, true);
            break;
        default: hotspot(offset, true);
    }
    return image[segment[(address >> 10 & 15) | 4] + (offset & 0x3ff)];  // 3F and 3E map ROM below the window, too
}

bool CartridgeSlot::write(uint16_t address, uint8_t value) {
    const uint16_t offset = address & 0xfff;
    switch (inserted->type()) {
        case Type::kDPC:
            access_dpc(offset);
            if (offset >= 0x40 && offset < 0x80) write_dpc(cart, offset, value);
            return false;
        case Type::kF8SC:
        case Type::kF6SC:
        case Type::kF4SC:
            if (offset < 0x80) ram[offset] = value;
            break;
        case Type::kFASC:
            if (offset < 0x100) ram[offset] = value;
            break;
        case Type::kE7:
            if (offset < 0x400 && cart.slice[0] == 7) ram[offset] = value;
            if (offset >= 0x800 && offset < 0x900) ram[1024u + 256u * (cart.slice[1] & 3) + (offset & 0xff)] = value;
            break;
        case Type::kCV:
            if (offset >= 0x400 && offset < 0x800) ram[offset & 0x3ff] = value;
            return false;
        case Type::k3E:
            if (cart.slice[2] && offset >= 0x400 && offset < 0x800) {
                ram[1024u * cart.slice[1] + (offset & 0x3ff)] = value;
                return false;
            }
            [[fallthrough]];
        case Type::k3F: select_slice(offset, value); return true;
        default: break;
    }
    hotspot(offset, false);
    return false;
}

// Switches banks and slices. Reads and writes have the same effect.
void CartridgeSlot::hotspot(uint16_t offset, bool reading) {
    if (offset < 0xfe0) return;
    const uint8_t bank_before = cart.bank;
    const std::array<uint8_t, 4> slices_before = std::to_array(cart.slice);
    const auto switch_bank = [&](int first, int count) {
        if (offset >= first && offset < first + count) cart.bank = static_cast<uint8_t>(offset - first);
    };
    switch (inserted->type()) {
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
void CartridgeSlot::select_slice(uint16_t offset, uint8_t value) {
    const bool has_ram = inserted->type() == Type::k3E;
    if (has_ram && offset == kSelectRam) {
        cart.slice[1] = value & 31;
        cart.slice[2] = 1;
    } else if (offset == kSelectRom || (!has_ram && offset < kSelectRom)) {
        cart.bank = static_cast<uint8_t>(value % (inserted->size() / 2048));
        cart.slice[2] = 0;
    }
    map_segments();
}

// 3F and 3E drive reads of the TIA's first page. UA switches banks at two addresses in TIA space.
bool CartridgeSlot::answers(uint16_t address) {
    if (inserted->type() != Type::kUA) return (address & 0x1fff) < 0x40;
    watch(address, 0);
    return false;
}

void CartridgeSlot::watch(uint16_t address, uint8_t value) {
    const uint16_t place = address & 0x1fff;
    if (inserted->type() == Type::kUA) {
        if (place == 0x220) cart.bank = 0;
        if (place == 0x240) cart.bank = 1;
        map_segments();
    } else if (place < 0x40) {
        select_slice(place, value);
    }
}

// Advances the DPC's generator, and switches between its two banks.
void CartridgeSlot::access_dpc(uint16_t offset) {
    clock_dpc_random(cart);
    if (offset != 0xff8 && offset != 0xff9) return;
    const uint8_t bank = offset & 1;
    if (cart.bank == bank) return;
    cart.bank = bank;
    map_segments();
}

// The DPC's registers keep their values.
void CartridgeSlot::reset(uint32_t cycles) {
    switch (inserted->type()) {
        case Type::kF8:
        case Type::kF8SC:
        case Type::kDPC:
        case Type::kMB: cart.bank = 1; break;
        case Type::kFASC: cart.bank = 2; break;
        default: cart.bank = 0; break;
    }
    for (int i = 0; i < 4; ++i) cart.slice[i] = inserted->type() == Type::kE0 ? static_cast<uint8_t>(4 + i) : 0;
    cart.stamp = static_cast<int32_t>(cycles);
    cart.fraction = 0.0;
    if (inserted->type() == Type::kCV && inserted->random_bytes() == 0) std::copy_n(image, ram.size(), ram.begin());
    map_segments();
}

void CartridgeSlot::rebase(uint32_t cycles) {
    if (inserted->type() == Type::kDPC) rebase_stamp(cart.stamp, cycles);
}

}  // namespace atari
