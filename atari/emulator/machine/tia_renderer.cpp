// The reference TIA's renderer. It updates framebuffer and collisions before the state that they depend on changes.
// Deferred rendering and deferred collisions are tested against it.
#include "console.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

namespace atari {
namespace {

static_assert(std::endian::native == std::endian::little, "eight pixels are handled as one little-endian word");

// Eight bits as eight bytes of 0x00 or 0xff, lowest bit first.
constexpr auto kByteMasks = [] {
    std::array<uint64_t, 256> table{};
    for (uint64_t byte = 0; byte < 256; ++byte)
        for (int bit = 0; bit < 8; ++bit)
            if (byte & (1u << bit)) table[byte] |= uint64_t{0xff} << (8 * bit);
    return table;
}();

constexpr uint64_t repeated(uint8_t byte) { return byte * 0x0101010101010101ull; }

}  // namespace

void Console::render_to(int32_t target) {
    Tia& t = m_.tia;
    if (target < t.draw_start || t.drawn_to >= t.draw_stop || t.drawn_to >= target) return;
    target = std::min(target, t.draw_stop);
    do {
        int from = kClocksPerLine - t.to_line_end;  // the clock of the line at which rendering continues
        int count;
        if (target > t.drawn_to + t.to_line_end) {
            count = t.to_line_end;
            t.to_line_end = kClocksPerLine;
            t.drawn_to += count;
        } else {
            count = target - t.drawn_to;
            t.to_line_end -= count;
            t.drawn_to = target;
        }
        if (from < kHblankClocks) {
            const int blank = std::min(kHblankClocks - from, count);
            from += blank;
            count -= blank;
        }
        uint8_t* pixels = next_pixels(std::max(count, 0));
        if (count > 0) {
            render_span(from - kHblankClocks, count);
            t.write_pos += count;
        }
        if (t.hmove_blank && from < kHblankClocks + kHmoveBlank) {
            std::memset(pixels, 0, static_cast<size_t>(kHblankClocks + kHmoveBlank - from));
            if (count + from >= kHblankClocks + kHmoveBlank) t.hmove_blank = false;
        }
        if (t.to_line_end == kClocksPerLine) end_line();
    } while (t.drawn_to < target);
}

// Called only if rendering continues strictly after the end of a visible line.
void Console::end_line() {
    Tia& t = m_.tia;
    if (t.pf_reflect != (t.ctrlpf & 1)) {
        t.pf_reflect = t.ctrlpf & 1;
        touch(kPF);
    }
    for (int player : {0, 1}) {
        if (!t.skip_first[player]) continue;
        t.skip_first[player] = false;
        touch(kP0 + player);
    }
    if (t.cosmic_ark) {
        static constexpr uint8_t kStep[4] = {18, 33, 0, 17};
        t.ark_counter = (t.ark_counter + 1) & 3;
        t.pos[kM0] = static_cast<uint8_t>((t.pos[kM0] + 160 - kStep[t.ark_counter]) % 160);
        t.m0_variant = t.ark_counter == 1 ? kWide : t.ark_counter == 2 ? kOff : kPlain;
        touch(kM0);
    }
}

namespace {

uint8_t shown_graphics(const Tia& t, int player) { return t.vdelp[player] ? t.old_grp[player] : t.grp[player]; }

}  // namespace

Mask object_mask(const Tia& t, int object) {
    switch (object) {
        case kP0:
        case kP1: {
            const uint8_t graphics = shown_graphics(t, object);  // its high bit is rendered first, unless reflected
            return player_mask(t.refp[object] ? graphics : kReversed[graphics], t.pos[object], t.nusiz[object] & 7,
                               t.skip_first[object]);
        }
        case kM0:
        case kM1: {
            const uint8_t nusiz = t.nusiz[object - kM0];
            const MissileVariant variant = object == kM0 ? t.m0_variant : kPlain;
            const int size = (nusiz >> 4 & 3) | (variant == kWide ? 1 : 0);
            return variant == kOff ? Mask{} : missile_mask(t.pos[object], nusiz & 7, size);
        }
        case kBL: return ball_mask(t.pos[kBL], t.ctrlpf >> 4 & 3);
        default: return playfield_mask(t.playfield, t.pf_reflect);
    }
}

bool Console::enabled(int object) const {
    const Tia& t = m_.tia;
    switch (object) {
        case kP0:
        case kP1: return shown_graphics(t, object) != 0;
        case kM0:
        case kM1: return t.enam[object - kM0] && !t.resmp[object - kM0];
        case kBL: return t.vdelbl ? t.old_enabl : t.enabl;
        default: return t.playfield != 0;
    }
}

const Mask& Console::mask(int object) {
    if (stale_ & 1u << object) {
        stale_ &= ~(1u << object);
        make_mask(masks_[object], m_.tia, object);
    }
    return masks_[object];
}

// Renders pixels x .. x+count-1 of the current line and latches their collisions.
void Console::render_span(int x, int count) {
    Tia& t = m_.tia;
    uint8_t* pixels = next_pixels(count);
    if (t.vblank & 2) {
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
        std::memset(pixels, t.colour[3], static_cast<size_t>(count));
        return;
    }
    Mask once, twice;  // pixels of at least one object, of at least two
    for (const Mask& mask : lit) {
        twice = twice | (once & mask);
        once = once | mask;
    }
    if (twice.any())
        for (const Pair& pair : kPairs)
            if (meets(lit[pair.a], lit[pair.b])) t.collisions |= pair.latch;

    // Which pixels take the colour of player 0, of player 1, of the playfield; the rest is background.
    static constexpr Mask kLeft = Mask::range(0, 80);
    const bool score = t.ctrlpf & 2, playfield_first = t.ctrlpf & 4;
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

void Console::paint(const Mask& p0, const Mask& p1, const Mask& pf, int x, int count) {
    const Tia& t = m_.tia;
    uint8_t* pixels = next_pixels(count);
    if (!(p0 | p1 | pf).any()) {
        std::memset(pixels, t.colour[3], static_cast<size_t>(count));
        return;
    }
    uint64_t line[20];
    const uint64_t c0 = repeated(t.colour[0]), c1 = repeated(t.colour[1]);
    const uint64_t cf = repeated(t.colour[2]), cb = repeated(t.colour[3]);
    for (int group = x / 8; group <= (x + count - 1) / 8; ++group) {
        const auto eight = [&](const Mask& mask) { return kByteMasks[mask.word[group / 8] >> (group % 8 * 8) & 0xff]; };
        const uint64_t m0 = eight(p0), m1 = eight(p1), mf = eight(pf);
        line[group] = (m0 & c0) | (m1 & c1) | (mf & cf) | (~(m0 | m1 | mf) & cb);
    }
    std::memcpy(pixels, reinterpret_cast<const uint8_t*>(line) + x, static_cast<size_t>(count));
}

}  // namespace atari
