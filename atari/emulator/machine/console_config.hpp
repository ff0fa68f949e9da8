// The settings of a console that stay constant while a game is loaded.
#pragma once

#include <algorithm>
#include <cstddef>

#include "framebuffers.hpp"
#include "raster.hpp"

namespace atari {

struct ConsoleConfig {
    int first_line = 34;               // scan line of the framebuffer's first row
    int height = 210;                  // rows of the framebuffer
    bool pal = false;                  // PAL rules: 342 lines, colour loss
    bool hmove_blanks = true;          // HMOVE blanks eight pixels at the left edge
    bool paddles[2] = {false, false};  // left and right jack; otherwise a joystick
    bool swap_ports = false;
    bool swap_paddles = false;

    // The size of a framebuffer: at least 200 rows, and an HMOVE blank after the last.
    std::size_t framebuffer_bytes() const {
        return static_cast<std::size_t>(kScreenWidth * std::max(height, 200) + Framebuffers::kMargin);
    }
};

}  // namespace atari
