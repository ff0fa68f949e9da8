// A cartridge's code as machine code of the processor that runs this, made from the records (decoder.hpp) when the
// cartridge is loaded. It does what the handlers do, without going from record to record.
//
// The handlers stay: they run what has no record of its own (code in RAM), everything on processors other than x86-64,
// and wherever memory cannot be made executable. Each instruction of the machine code either does its work with what is
// likely, or calls its handler; so the two agree if the likely cases do (tests/emulator/test_fast_equals_plain.py, which
// runs both).
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "decoder.hpp"
#include "executable.hpp"

namespace atari {

class Console;
struct Registers;

class Translation {
  public:
    // Of a cartridge's image and records. Where machine code cannot be run `has` stays false for all of them.
    void make(const uint8_t* image, const std::vector<Record>& records);

    bool any() const { return code_.begin() != nullptr; }

    // Whether the instruction that begins at this byte of the image has been translated.
    bool has(std::size_t place) const { return any() && begins(place) != kNowhere; }

    // Runs from there on, until it gets to an instruction that has not been translated or the handlers would leave their
    // loop: an `Exit`, with the registers as the handlers leave them.
    int run(Registers& registers, Console& console, std::size_t place) const {
        using Begin = int (*)(Registers&, Console&, const uint8_t*);
        const uint8_t* const code = code_.begin();
        const auto begin = reinterpret_cast<Begin>(reinterpret_cast<uintptr_t>(code + enter_));
        return begin(registers, console, code + begins(place));
    }

  private:
    // Where each instruction begins in the machine code is written in front of it.
    static constexpr int32_t kNowhere = 0;
    int32_t begins(std::size_t place) const { return reinterpret_cast<const int32_t*>(code_.begin())[place]; }

    std::size_t enter_ = 0;
    Executable code_;
};

}  // namespace atari
