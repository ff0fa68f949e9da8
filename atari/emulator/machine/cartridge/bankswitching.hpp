// The cartridge slot: bank switching and cartridge RAM. It needs no chip of the console.
//
// The window of 4 KiB is mapped in segments of 1 KiB. Most of it is plain ROM, whose bytes `image_at` returns. `read`
// and `write` serve all other addresses. A few cartridges also watch accesses of the TIA.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "cartridge.hpp"

namespace atari {

struct CartridgeSlot {
    struct Listener {
        virtual void segments_changed() {}
        virtual ~Listener() = default;
    };

    // Keeps references to the cartridge's registers and to the listener, which is called when `segment` has changed.
    CartridgeSlot(std::shared_ptr<const Cartridge> cartridge, CartridgeState& state, Listener& listener);

    // Returns whether an address of the window maps plain ROM, and the image byte there.
    bool is_plain(uint16_t address) const { return (address & 0xfffu) - plain.from < plain.size; }
    const uint8_t* image_at(uint16_t address) const { return image + segment[address >> 10 & 15] + (address & 0x3ff); }

    // Reads an address that is not plain ROM. A bank switch happens before the fetch, so the byte comes from the new
    // bank.
    uint8_t read(uint16_t address, uint32_t cycles);
    // Returns whether the write reaches the TIA, too.
    bool write(uint16_t address, uint8_t value);

    // If `watches_tia` is set, `answers` is called for each read of TIA space, and returns whether the cartridge drives
    // it. `watch` is called for each write.
    bool answers(uint16_t address);
    void watch(uint16_t address, uint8_t value);

    // Selects the power-on banks.
    void reset(uint32_t cycles);
    // Makes cycle number `cycles` number 0.
    void rebase(uint32_t cycles);
    // Maps image bytes to the window by type and bank.
    void map_segments();

    const uint8_t* image;
    Window plain;               // the cartridge's plain window
    uint32_t segment[16] = {};  // offsets in the image of the segments, by bits 10 to 13 of the address
    bool watches_tia;           // `Cartridge::watches_tia`
    std::vector<uint8_t> ram;
    CartridgeState& cart;
    Listener& listener;
    std::shared_ptr<const Cartridge> inserted;

  private:
    void hotspot(uint16_t offset, bool reading);
    void select_slice(uint16_t offset, uint8_t value);
    void access_dpc(uint16_t offset);
};

}  // namespace atari
