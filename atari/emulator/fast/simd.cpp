#include "simd.hpp"

#include <cstdlib>
#include <stdexcept>
#include <string>

namespace atari {

const char* name_of(SimdLevel level) {
    static constexpr const char* kNames[] = {"scalar", "simd128", "avx2", "avx512"};
    return kNames[static_cast<int>(level)];
}

namespace {

struct Choice {
    SimdLevel level = best_simd_level();
    std::string fault;
};

const Choice& choice() {
    static const Choice chosen = [] {
        Choice result;
        const char* const name = std::getenv("ATARI_SIMD");
        if (!name || !*name) return result;
        std::string supported;
        for (int number = 0; number <= static_cast<int>(best_simd_level()); ++number) {
            const auto level = static_cast<SimdLevel>(number);
            if (std::string(name_of(level)) == name) return Choice{level, ""};
            supported += std::string(number ? ", " : "") + name_of(level);
        }
        result.fault =
            "the environment variable ATARI_SIMD is '" + std::string(name) + "'; this processor supports " + supported;
        return result;
    }();
    return chosen;
}

}  // namespace

SimdLevel simd_level() { return choice().level; }

void check_simd_level() {
    if (!choice().fault.empty()) throw std::invalid_argument(choice().fault);
}

}  // namespace atari
