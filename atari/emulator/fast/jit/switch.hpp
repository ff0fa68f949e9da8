// The environment variable ATARI_JIT, which chooses between translated code and handlers.
#pragma once

namespace atari {

enum class TranslatorUse {
    kOff,
    kOn,        // if the system allows memory to be made executable
    kDemanded,  // or the cartridge is refused
};

// Returns the choice of ATARI_JIT: 0 for handlers, 1 to demand translated code. If it is not set or empty, the
// default of the platform counts. Throws std::invalid_argument for any other value, and for 1 if this build has no translator.
TranslatorUse translator_use();

// Returns the processor for which code is translated, or null if handlers run all code. Throws as `translator_use`.
const char* translator();

}  // namespace atari
