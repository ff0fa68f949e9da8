// Address decoding: the chip that an access reaches, and the byte that stays on the data bus.
#include "console.hpp"

#include "tia_registers.hpp"

namespace atari {

uint8_t Console::read_chip(uint16_t address) {
    if (!(address & 0x80)) return cartridge_answers(address) ? read_cartridge(address) : read_tia(address);
    if (!(address & 0x200)) return m_.riot.ram[address & 0x7f];
    return read_riot(address);
}

void Console::write(uint16_t address, uint8_t value) {
    if (address & 0x1000) {
        write_cartridge(address, value);
    } else if (!(address & 0x80)) {
        if (watches_tia_) cartridge_watches(address, value);
        write_tia(tia_register(address), value);
    } else if (!(address & 0x200)) {
        m_.riot.ram[address & 0x7f] = value;
    } else {
        write_riot(address, value);
    }
    m_.bus = value;
    m_.cpu.last_access_was_read = false;
}

}  // namespace atari
