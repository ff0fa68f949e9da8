// The reference TIA's registers, without sound: writes, reads, and the end of a frame. It needs no other chip.
//
// A frame's end and WSYNC concern the processor, too: `write` reports the first, and `Console` does the second.
#pragma once

#include <cstdint>

#include "machine/inputs.hpp"
#include "tia_renderer.hpp"

namespace atari {

class ReferenceTia {
  public:
    // Keeps references to all three.
    ReferenceTia(Tia& tia, const ConsoleConfig& config, TiaRenderer& renderer)
        : t_(tia), config_(config), renderer_(renderer) {}

    // Returns whether the write ends the frame.
    bool write(uint8_t reg, uint8_t value, uint32_t cycles);
    // Brings the state up to a read of a register, CXM0P .. INPT5 by number.
    void prepare_read(int reg, uint32_t cycles);
    uint8_t read(int reg, uint32_t cycles, uint8_t bus, const Inputs& inputs) const;

    void reset();
    // Begins a frame `begun` clocks after the start of a line. The present cycle gets number 0.
    void start_frame(int32_t begun);
    // Makes cycle number `cycles` number 0.
    void rebase(uint32_t cycles);

    // Parts of `write` and `read` that `FastConsole` needs, too.
    bool write_vsync(uint8_t value, uint32_t cycles);               // returns whether the write ends the frame
    bool switch_dump(uint8_t old, uint8_t value, uint32_t cycles);  // returns whether the inputs' charging times change
    uint64_t input_from(int port, const Inputs& inputs) const;

  private:
    template <typename T, typename V>
    void change(T& field, V value, unsigned objects);
    void write_nusiz(int player, uint8_t value);
    void write_graphics(int player, uint8_t value);
    void write_vblank(uint8_t value, uint32_t cycles);
    void reset_player(int player, int hpos, uint32_t cycles);
    void reset_missile(int missile, int hpos, uint32_t cycles);
    void reset_ball(int hpos, uint32_t cycles);
    void hmove(int cycle_in_line, uint32_t cycles);
    void release_missile(int missile, uint8_t value);

    Tia& t_;
    const ConsoleConfig& config_;
    TiaRenderer& renderer_;
};

}  // namespace atari
