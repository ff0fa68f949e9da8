#include "line_difference.hpp"

namespace atari {

int agreeing(const Write* a, const Write* b, int count) {
    int i = 0;
    while (i <= count - 8 && agree<8 * sizeof(Write)>(a + i, b + i)) i += 8;
    while (i < count && agree<sizeof(Write)>(a + i, b + i)) ++i;
    return i;
}

Difference difference(const TiaPlaces& now, const TiaPlaces& before) {
    Difference d{};
    if (agree<sizeof now>(&now, &before)) return d;
    for (unsigned object = kP0; object <= kBL; ++object) {
        const int by = now.pos[object] - before.pos[object];
        d.pos[object] = static_cast<uint8_t>(by < 0 ? by + kScreenWidth : by);
        if (by != 0) d.objects |= 1u << object;
    }
    for (unsigned player : {0u, 1u}) {
        d.refp[player] = before.refp[player].value ^ now.refp[player].value;
        if (d.refp[player]) d.objects |= 1u << (kP0 + player);
    }
    d.vdelbl = before.vdelbl.value ^ now.vdelbl.value;
    if (d.vdelbl) d.objects |= 1u << kBL;
    d.last_hmove = now.last_hmove;
    if (before.last_hmove != now.last_hmove) d.objects |= kPlacing;
    return d;
}

void carry(const Difference& by, TiaPlaces* first, TiaPlaces* last) {
    const auto each = [&](auto change) {
        for (TiaPlaces* line = first; line < last; ++line) change(*line);
    };
    for (int object = kP0; object <= kBL; ++object)
        if (const int distance = by.pos[object])
            each([&](TiaPlaces& line) {
                const int position = line.pos[object] + distance;
                line.pos[object] = static_cast<uint8_t>(position >= kScreenWidth ? position - kScreenWidth : position);
            });
    for (int player : {0, 1})
        if (by.refp[player]) each([&](TiaPlaces& line) { line.refp[player].value ^= by.refp[player]; });
    if (by.vdelbl) each([&](TiaPlaces& line) { line.vdelbl.value ^= by.vdelbl; });
    if (by.objects & kPlacing) each([&](TiaPlaces& line) { line.last_hmove = by.last_hmove; });
}

}  // namespace atari
