// A cartridge's code as translated code: machine code of the processor that runs this program, made from the decoded
// instructions (decoder.hpp) by the JIT translator (translator.hpp) when the cartridge is loaded. It does what the
// handlers do, without going from one decoded instruction to the next.
//
// The handlers stay: they run code in RAM, everything on processors other than x86-64, and everything where memory cannot
// be made executable. Each instruction of translated code either does its work itself in the likely case, or calls its
// handler; so the two agree if the likely cases do (tests/emulator/test_fast_equals_plain.py, which runs both).
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
    // Of a cartridge's image and decoded instructions. Where translated code cannot run `has` stays false for all of them.
    void make(const uint8_t* image, const std::vector<DecodedInstruction>& decoded);

    bool any() const { return code_.begin() != nullptr; }

    // Whether the instruction at this place of the image has been translated.
    bool has(std::size_t place) const { return any() && entry(place) != kNowhere; }

    // Runs from there on, until it gets to an instruction that has not been translated or the handlers would leave their
    // loop. Returns an `Exit`, with the registers as the handlers leave them.
    int run(Registers& registers, FastConsole& console, std::size_t place) const {
        using Begin = int (*)(Registers&, FastConsole&, const uint8_t*);
        const uint8_t* const code = code_.begin();
        const auto begin = reinterpret_cast<Begin>(reinterpret_cast<uintptr_t>(code + start_));
        return begin(registers, console, code + entry(place));
    }

  private:
    // The code begins with a table: for each byte of the image, where the instruction there is entered.
    static constexpr int32_t kNowhere = 0;
    int32_t entry(std::size_t place) const { return reinterpret_cast<const int32_t*>(code_.begin())[place]; }

    std::size_t start_ = 0;
    Executable code_;
};

}  // namespace atari
