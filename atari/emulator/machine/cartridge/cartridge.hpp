// Cartridges: the ROM image, the detection of its type, the properties of its bank switching, and the registers.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "machine/flag.hpp"

namespace atari {

// clang-format off
enum class CartridgeType : uint8_t { k2K, k4K, kF8, kF8Swapped, kF6, kF4, kF8SC, kF6SC, kF4SC, kFASC, kE0, kE7, kFE,
                                     kDPC, k3F, k3E, kUA, kCV, kMB };
// clang-format on

// A part of the 4 KiB window at which the processor addresses the cartridge.
struct Window {
    unsigned from, size;
};

// A ROM image and its type. Immutable, so that all consoles of the game share it.
class Cartridge {
  public:
    // `type` is a name such as "F8", or empty to detect it by size and signature.
    // Throws std::invalid_argument if the image is of no supported type, or too short for the given type.
    Cartridge(std::vector<uint8_t> image, const std::string& type);

    CartridgeType type() const { return type_; }
    std::string type_name() const;
    bool watches_tia() const;     // accesses of the TIA switch banks
    size_t ram_size() const;      // bytes of RAM on the cartridge
    size_t random_bytes() const;  // bytes of this RAM that a reset fills from the machine's generator
    const uint8_t* image() const { return image_.data(); }
    size_t size() const { return image_.size(); }
    // The part of the window that maps ROM in every bank, without RAM, registers or addresses that switch banks.
    Window plain_window() const;

  private:
    std::vector<uint8_t> image_;
    CartridgeType type_;
};

// The registers of a cartridge.
struct CartridgeState {
    uint8_t bank;      // also the slice of 3F and 3E
    uint8_t slice[4];  // E0: 1 KiB each; E7: [0] the low slice, [1] the RAM page; 3E: [1] RAM page, [2] RAM mapped
    // DPC (Pitfall II)
    uint8_t top[8], bottom[8], flag[8];
    uint16_t counter[8];
    Flag music[8];
    uint8_t random;
    int32_t stamp;
    double fraction;
};

}  // namespace atari
