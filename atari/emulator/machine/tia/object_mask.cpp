#include "object_mask.hpp"

namespace atari {

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

}  // namespace atari
