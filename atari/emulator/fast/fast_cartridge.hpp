// `FastCartridge`: a cartridge with the decoded instructions and the translated code that are made from its image at
// load.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "machine/cartridge/cartridge.hpp"
#include "fast/interpreter/decoder.hpp"
#include "fast/jit/translated_code.hpp"

namespace atari {

// Immutable, so that all consoles that run the game share it.
class FastCartridge final : public Cartridge {
  public:
    // Takes the arguments of `Cartridge`. If `translated`, the JIT translator runs too, by the choice of ATARI_JIT
    // (switch.hpp).
    FastCartridge(std::vector<uint8_t> image, const std::string& type, bool translated = true);

    const DecodedInstruction* code() const { return code_.data(); }  // one for each byte of the image
    const TranslatedCode& translated_code() const { return translated_code_; }
    const uint8_t* const* pages() const { return pages_.data(); }  // each 64 bytes of the image

  private:
    std::vector<DecodedInstruction> code_;
    TranslatedCode translated_code_;
    std::vector<const uint8_t*> pages_;
};

}  // namespace atari
