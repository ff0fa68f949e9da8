// Address decoding: the chip that an access reaches, and the byte that stays on the data bus. The processor's
// instructions are templates on the bus, and are compiled here.
#include "console.hpp"

#include "machine/cpu/cpu_instructions.hpp"
#include "machine/tia/tia_registers.hpp"

namespace atari {

uint8_t Console::read_chip(uint16_t address) {
    if (!(address & 0x80)) {
        if (slot_.watches_tia && slot_.answers(address)) return slot_.read(address, m_.cycles);
        const int reg = address & 0xf;
        before_tia_read(reg);
        return tia_.read(reg, m_.cycles, m_.bus, m_.inputs);
    }
    if (!(address & 0x200)) return m_.riot.ram[address & 0x7f];
    return m_.riot.read(address, m_.cycles, m_.inputs, config_);
}

void Console::write(uint16_t address, uint8_t value) {
    if (address & 0x1000) {
        if (slot_.write(address, value)) write_tia(tia_register(address), value);
    } else if (!(address & 0x80)) {
        if (slot_.watches_tia) slot_.watch(address, value);
        write_tia(tia_register(address), value);
    } else if (!(address & 0x200)) {
        m_.riot.ram[address & 0x7f] = value;
    } else {
        m_.riot.write(address, value, m_.cycles);
    }
    m_.bus = value;
    m_.cpu.last_access_was_read = false;
}

void Console::write_tia(uint8_t reg, uint8_t value) {
    if (tia_.write(reg, value, m_.cycles)) end_frame();
    if (reg == WSYNC) halt_until_line_start();
    else if (reg >= AUDC0 && reg <= AUDV1) m_.sound.write(reg, value);
}

void Console::end_frame() {
    m_.cpu.stop = true;
    m_.tia.partial = false;
}

void Console::halt_until_line_start() {
    if (!m_.cpu.last_access_was_read) return;
    const int in_line = m_.tia.line_clock(m_.cycles) / 3;
    if (in_line != 0) spend(kCyclesPerLine - in_line);
}

void Console::run_instruction() { m_.cpu.run_instruction(*this); }

void Console::emulate_frame(bool) {
    m_.cpu.run_frame(*this);
    catch_up();
}

}  // namespace atari
