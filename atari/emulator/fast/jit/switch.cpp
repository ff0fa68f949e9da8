#include "switch.hpp"

#include <cstdlib>
#include <stdexcept>
#include <string>

#include "executable.hpp"
#include "target.hpp"

namespace atari {
namespace {

// The translator is off on systems on whose hardware it has not run yet.
#if (defined(__APPLE__) || defined(_WIN32)) && (defined(__aarch64__) || defined(_M_ARM64))
constexpr bool kOnByDefault = false;
#else
constexpr bool kOnByDefault = true;
#endif

}  // namespace

TranslatorUse translator_use() {
    const char* const variable = std::getenv("ATARI_JIT");
    const std::string value = variable ? variable : "";
    if (value.empty()) return kTranslates && kOnByDefault ? TranslatorUse::kOn : TranslatorUse::kOff;
    if (value == "0") return TranslatorUse::kOff;
    if (value != "1")
        throw std::invalid_argument("the environment variable ATARI_JIT is '" + value +
                                    "'; it must be 0 (run all code by handlers) or 1 (translate code), or not be set");
    if (!kTranslates)
        throw std::invalid_argument(
            "the environment variable ATARI_JIT is 1, but this build has no translator for this processor; remove the "
            "variable or set it to 0");
    return TranslatorUse::kDemanded;
}

const char* translator() {
    if (translator_use() == TranslatorUse::kOff) return nullptr;
    Executable probe;
    probe.fill({0});
    return probe.begin() ? kProcessor : nullptr;
}

}  // namespace atari
