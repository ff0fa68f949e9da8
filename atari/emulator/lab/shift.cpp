#include "shift.hpp"

#include <cstdlib>

#include "machine/state.hpp"

namespace atari {
namespace {

constexpr int kMostPlaces = 2400;  // larger differences are not one thing that moves

// Returns the number of pixels that `distance` should explain but does not, or a number above `limit`. The background
// next to a thing counts too, so that a thing's old place is not mistaken for background that has moved. Rows and
// columns wrap, so that every pixel counts twice at every distance.
int misses(const ScreenDifference& difference, const uint8_t* old_screen, const uint8_t* new_screen, bool along_x,
           int distance, int limit, int height) {
    int count = 0;
    const int step = along_x ? 1 : kScreenWidth, end = along_x ? kScreenWidth : height;
    for (const int place : difference.places) {
        const int at = along_x ? place % kScreenWidth : place / kScreenWidth;
        const int after = at + distance, before = at - distance;
        const int next = place + step * (distance - (after >= end ? end : after < 0 ? -end : 0));
        const int last = place - step * (distance + (before >= end ? end : before < 0 ? -end : 0));
        count += old_screen[place] != new_screen[next];
        count += new_screen[place] != old_screen[last];
        if (count > limit) break;
    }
    return count;
}

}  // namespace

Shift find_shift(const ScreenDifference& difference, const uint8_t* old_screen, const uint8_t* new_screen, bool along_x,
                 int height) {
    const int size = static_cast<int>(difference.places.size());
    if (size == 0 || size > kMostPlaces) return {};
    const int span = along_x ? difference.right - difference.left : difference.bottom - difference.top;
    int best = 2 * size / 5;  // misses, in 2 * size pixels
    Shift found;
    for (int distance = 1; distance <= span; ++distance)
        for (const int signed_distance : {distance, -distance}) {
            const int missed = misses(difference, old_screen, new_screen, along_x, signed_distance, best, height);
            if (missed >= best) continue;
            best = missed;
            found = {signed_distance, 100 - 50 * missed / size};
        }
    // The same shift around the other edge. If it fits as well, the thing is smaller, and crosses no edge.
    const int end = along_x ? kScreenWidth : height;
    const int around = found.distance > 0 ? found.distance - end : found.distance + end;
    if (found.distance != 0 && std::abs(around) > std::abs(found.distance) && std::abs(around) <= span)
        found.distance = around;
    return found;
}

int unbalanced(const ScreenDifference& difference, const uint8_t* old_screen, const uint8_t* new_screen) {
    int counts[256] = {}, sum = 0;
    for (const int place : difference.places) {
        ++counts[old_screen[place]];
        --counts[new_screen[place]];
    }
    for (const int count : counts) sum += std::abs(count);
    return difference.places.empty() ? 0 : 50 * sum / static_cast<int>(difference.places.size());
}

}  // namespace atari
