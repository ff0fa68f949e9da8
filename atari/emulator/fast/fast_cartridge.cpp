#include "fast_cartridge.hpp"

#include <stdexcept>
#include <utility>

#include "fast/jit/switch.hpp"
#include "fast/jit/target.hpp"

namespace atari {

FastCartridge::FastCartridge(std::vector<uint8_t> image, const std::string& type, bool translated)
    : Cartridge(std::move(image), type), code_(decode_image(*this)) {
    const TranslatorUse use = translated ? translator_use() : TranslatorUse::kOff;
    if constexpr (kTranslates)  // WebAssembly is linked without the translator
        if (use != TranslatorUse::kOff) translated_code_.make(this->image(), code_);
    if (use == TranslatorUse::kDemanded && !translated_code_.any())
        throw std::runtime_error(
            "the environment variable ATARI_JIT is 1, but the system does not allow this process to make memory "
            "executable; remove the variable or set it to 0");
    for (size_t place = 0; place < code_.size(); ++place)
        if (translated_code_.has(place)) code_[place].code = code_of(kTranslated);
    for (size_t at = 0; at + 64 <= size(); at += 64) pages_.push_back(this->image() + at);
}

}  // namespace atari
