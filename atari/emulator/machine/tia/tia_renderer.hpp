// The reference TIA's renderer: draws pixels and latches collisions from the TIA's state. It needs no other chip.
//
// It updates framebuffer and collisions before the state that they depend on changes. Deferred rendering and deferred
// collisions are tested against it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "machine/console_config.hpp"
#include "machine/framebuffers.hpp"
#include "masks.hpp"
#include "tia_state.hpp"

namespace atari {

class TiaRenderer {
  public:
    // Keeps references to all three.
    TiaRenderer(Tia& tia, const ConsoleConfig& config, Framebuffers& framebuffers)
        : t_(tia), config_(config), framebuffers_(framebuffers) {}

    // Renders up to `Tia::pending`, the clock up to which the present state is valid.
    void catch_up() { render_to(t_.pending); }

    // Marks the masks of a set of objects as out of date.
    void touch(unsigned objects) { stale_ |= objects; }

    // Makes the framebuffer grey from a scan line on, after the instruction limit has ended a frame early.
    void grey_from(int scan_line);

  private:
    void render_to(int32_t clock);
    void render_span(int x, int count);
    void end_line();
    void paint(const Mask& p0, const Mask& p1, const Mask& pf, int x, int count);
    const Mask& mask(int object);
    bool enabled(int object) const;
    // Memory for the next `count` pixels. Only a restored state may have a position after the framebuffer's end.
    uint8_t* next_pixels(int count) {
        const auto end = static_cast<std::size_t>(t_.write_pos + count) + Framebuffers::kMargin;
        return framebuffers_.use(t_.current, std::max(config_.framebuffer_bytes(), end)) + t_.write_pos;
    }

    Tia& t_;
    const ConsoleConfig& config_;
    Framebuffers& framebuffers_;
    Mask masks_[6];                 // by object, computed when needed
    unsigned stale_ = kAllObjects;  // objects whose masks are out of date
};

}  // namespace atari
