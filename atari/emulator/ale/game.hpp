// `Game`: a compiled game definition, and the console that plays it.
#pragma once

#include <algorithm>
#include <memory>

#include "environment.hpp"
#include "fast/fast_cartridge.hpp"
#include "machine/console.hpp"
#include "ale/colours/palettes.hpp"
#include "ale/programs/program.hpp"

namespace atari {

struct Game : GameRules {
    std::shared_ptr<const FastCartridge> cartridge;
    ConsoleConfig console;
    const Palette* palette = &NTSC;
    Program step, select_mode;

    int height() const { return std::max(console.height, 200); }  // rows of a screen
    bool paddles() const { return console.paddles[0] || console.paddles[1]; }

    void check() const;  // throws std::invalid_argument if a number is out of the range that `Environment` accepts
};

// Returns the reference core if `plain`, otherwise a `FastConsole`.
std::unique_ptr<Console> make_console(const Game& game, bool plain);

}  // namespace atari
