// `TranslatedCode`: a cartridge's code as machine code of the host. The JIT translator (translator.hpp) makes it from
// the decoded instructions (decoder.hpp) when the cartridge is loaded. It has the effect of the handlers without a
// dispatch from one decoded instruction to the next.
//
// The handlers stay in use for code in RAM, on processors other than x86-64 and arm64, by ATARI_JIT=0 (switch.hpp), and
// if memory cannot be made executable.
// Translated code of an instruction either handles the likely case inline, or calls the handler. Both agree if the
// likely cases agree (tests/emulator/test_fast_equals_plain.py runs both).
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "fast/interpreter/decoder.hpp"
#include "executable.hpp"

namespace atari {

class FastConsole;
struct Registers;

class TranslatedCode {
  public:
    // Makes translated code of a cartridge's image and decoded instructions. If the platform cannot run it, `has` stays
    // false for all instructions.
    void make(const uint8_t* image, const std::vector<DecodedInstruction>& decoded);

    bool any() const { return code_.begin() != nullptr; }

    // Returns whether the instruction at this offset of the image is translated.
    bool has(std::size_t place) const { return any() && entry(place) != kNowhere; }

    // Runs from that instruction on, until it reaches an untranslated instruction or a handler returns anything but
    // kNext. Returns an `Exit`, with the registers as the handlers leave them.
    int run(Registers& registers, FastConsole& console, std::size_t place) const {
        using Begin = int (*)(Registers&, FastConsole&, const uint8_t*);
        const uint8_t* const code = code_.begin();
        const auto begin = reinterpret_cast<Begin>(reinterpret_cast<uintptr_t>(code + start_));
        return begin(registers, console, code + entry(place));
    }

  private:
    // The code begins with a table: by byte of the image, the entry of the instruction there.
    static constexpr int32_t kNowhere = 0;
    int32_t entry(std::size_t place) const { return reinterpret_cast<const int32_t*>(code_.begin())[place]; }

    std::size_t start_ = 0;
    Executable code_;
};

}  // namespace atari
