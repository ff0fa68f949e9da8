// Cartridges: the ROM image, how it is recognised, and what its bank switching does.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "decoder.hpp"
#include "state.hpp"
#include "translation.hpp"

namespace atari {

enum class CartridgeType : uint8_t { k2K, k4K, kF8, kF8Swapped, kF6, kF4, kF8SC, kF6SC, kF4SC, kFASC, kE0, kE7, kFE,
                                     kDPC, k3F, k3E, kUA, kCV, kMB };

// A part of the 4 KiB through which the processor sees the cartridge.
struct Window {
    unsigned from, size;
};

// An image and its type; immutable, so that all machines that run the game can share it.
class Cartridge {
  public:
    // `type` is a name such as "F8", or empty to recognise it by size and signature.
    // Its code is translated where that is possible, unless it is not to be.
    // Throws std::invalid_argument if the image is of no supported type, or too short for the type asked for.
    Cartridge(std::vector<uint8_t> image, const std::string& type, bool translated = true);

    CartridgeType type() const { return type_; }
    std::string type_name() const;
    size_t ram_size() const;     // bytes of RAM on the cartridge
    size_t random_bytes() const; // bytes of it filled from the machine's generator at each reset
    const uint8_t* image() const { return image_.data(); }
    size_t size() const { return image_.size(); }
    // Where the window shows plain image in every bank: no RAM, no registers, no addresses that switch banks.
    Window plain_window() const;
    const Record* code() const { return code_.data(); }  // a record for each byte of the image
    const Translation& translation() const { return translation_; }
    const uint8_t* const* pages() const { return pages_.data(); }  // each 64 bytes of the image

  private:
    std::vector<uint8_t> image_;
    CartridgeType type_;
    std::vector<Record> code_;
    Translation translation_;
    std::vector<const uint8_t*> pages_;
};

}  // namespace atari
