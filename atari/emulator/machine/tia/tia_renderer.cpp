#include "tia_renderer.hpp"

#include <algorithm>
#include <cstring>

#include "object_mask.hpp"

namespace atari {
void TiaRenderer::render_to(int32_t target) {
    if (target < t_.draw_start || t_.drawn_to >= t_.draw_stop || t_.drawn_to >= target) return;
    target = std::min(target, t_.draw_stop);
    do {
        int from = kClocksPerLine - t_.to_line_end;  // the clock of the line at which rendering continues
        int count;
        if (target > t_.drawn_to + t_.to_line_end) {
            count = t_.to_line_end;
            t_.to_line_end = kClocksPerLine;
            t_.drawn_to += count;
        } else {
            count = target - t_.drawn_to;
            t_.to_line_end -= count;
            t_.drawn_to = target;
        }
        if (from < kHblankClocks) {
            const int blank = std::min(kHblankClocks - from, count);
            from += blank;
            count -= blank;
        }
        uint8_t* pixels = next_pixels(std::max(count, 0));
        if (count > 0) {
            render_span(from - kHblankClocks, count);
            t_.write_pos += count;
        }
        if (t_.hmove_blank && from < kHblankClocks + kHmoveBlank) {
            std::memset(pixels, 0, static_cast<size_t>(kHblankClocks + kHmoveBlank - from));
            if (count + from >= kHblankClocks + kHmoveBlank) t_.hmove_blank = false;
        }
        if (t_.to_line_end == kClocksPerLine) end_line();
    } while (t_.drawn_to < target);
}

// Called only if rendering continues strictly after the end of a visible line.
void TiaRenderer::end_line() {
    if (t_.pf_reflect != (t_.ctrlpf & 1)) {
        t_.pf_reflect = t_.ctrlpf & 1;
        touch(bit_of(kPF));
    }
    for (unsigned player : {0u, 1u}) {
        if (!t_.skip_first[player]) continue;
        t_.skip_first[player] = false;
        touch(bit_of(player));
    }
    if (t_.cosmic_ark) {
        static constexpr uint8_t kStep[4] = {18, 33, 0, 17};
        t_.ark_counter = (t_.ark_counter + 1) & 3;
        t_.pos[kM0] = static_cast<uint8_t>((t_.pos[kM0] + 160 - kStep[t_.ark_counter]) % 160);
        t_.m0_variant = t_.ark_counter == 1 ? kWide : t_.ark_counter == 2 ? kOff : kPlain;
        touch(bit_of(kM0));
    }
}

bool TiaRenderer::enabled(int object) const {
    switch (object) {
        case kP0:
        case kP1: return shown_graphics(t_, object) != 0;
        case kM0:
        case kM1: return t_.enam[object - kM0] && !t_.resmp[object - kM0];
        case kBL: return t_.vdelbl ? t_.old_enabl : t_.enabl;
        default: return t_.playfield != 0;
    }
}

const Mask& TiaRenderer::mask(int object) {
    if (stale_ & 1u << object) {
        stale_ &= ~(1u << object);
        make_mask(masks_[object], t_, object);
    }
    return masks_[object];
}

// Renders pixels x .. x+count-1 of the current line and latches their collisions.
void TiaRenderer::render_span(int x, int count) {
    uint8_t* pixels = next_pixels(count);
    if (t_.vblank & 2) {
        std::memset(pixels, 0, static_cast<size_t>(count));
        return;
    }
    const Mask span = Mask::range(x, x + count);
    Mask lit[6];
    unsigned enabled_objects = 0;
    for (int object = kP0; object <= kPF; ++object) {
        if (!enabled(object)) continue;
        enabled_objects |= 1u << object;
        lit[object] = mask(object) & span;
    }
    if (!enabled_objects) {
        std::memset(pixels, t_.colour[3], static_cast<size_t>(count));
        return;
    }
    Mask once, twice;  // pixels of at least one object, of at least two
    for (const Mask& mask : lit) {
        twice = twice | (once & mask);
        once = once | mask;
    }
    if (twice.any())
        for (const Pair& pair : kPairs)
            if (meets(lit[pair.a], lit[pair.b])) t_.collisions |= pair.latch;

    // The pixels that take the colours of player 0, of player 1 and of the playfield. The rest is background.
    static constexpr Mask kLeft = Mask::range(0, 80);
    const bool score = t_.ctrlpf & 2, playfield_first = t_.ctrlpf & 4;
    const Mask side0 = lit[kP0] | lit[kM0], side1 = lit[kP1] | lit[kM1];
    Mask colour0, colour1, colour_pf;
    if (playfield_first) {
        colour_pf = lit[kPF] | lit[kBL];
        colour0 = without(side0, colour_pf);
        colour1 = without(side1, colour_pf | side0);
        if (score && enabled_objects == 1u << kPF) {
            colour0 = lit[kPF] & kLeft;
            colour1 = without(lit[kPF], kLeft);
            colour_pf = {};
        }
    } else {
        colour0 = score ? side0 | (lit[kPF] & kLeft) : side0;
        colour1 = without(score ? side1 | without(lit[kPF], kLeft) : side1, colour0);
        colour_pf = without(lit[kPF] | lit[kBL], colour0 | colour1);
    }
    paint(colour0, colour1, colour_pf, x, count);
}

void TiaRenderer::paint(const Mask& p0, const Mask& p1, const Mask& pf, int x, int count) {
    uint8_t* pixels = next_pixels(count);
    if (!(p0 | p1 | pf).any()) {
        std::memset(pixels, t_.colour[3], static_cast<size_t>(count));
        return;
    }
    uint64_t line[20];
    const uint64_t c0 = repeated(t_.colour[0]), c1 = repeated(t_.colour[1]);
    const uint64_t cf = repeated(t_.colour[2]), cb = repeated(t_.colour[3]);
    for (int group = x / 8; group <= (x + count - 1) / 8; ++group) {
        const auto eight = [&](const Mask& mask) { return kByteMasks[mask.word[group / 8] >> (group % 8 * 8) & 0xff]; };
        const uint64_t m0 = eight(p0), m1 = eight(p1), mf = eight(pf);
        line[group] = (m0 & c0) | (m1 & c1) | (mf & cf) | (~(m0 | m1 | mf) & cb);
    }
    std::memcpy(pixels, reinterpret_cast<const uint8_t*>(line) + x, static_cast<size_t>(count));
}

void TiaRenderer::grey_from(int scan_line) {
    uint8_t* pixels = framebuffers_.use(t_.current, config_.framebuffer_bytes());
    // A restored state may be in any line; after the framebuffer's end nothing is left.
    const int first = std::clamp(scan_line - config_.first_line, 0, config_.height);
    for (int i = first * kScreenWidth; i < config_.height * kScreenWidth; ++i)
        pixels[i] = static_cast<uint8_t>((pixels[i] & 15) >> 1);
}

}  // namespace atari
