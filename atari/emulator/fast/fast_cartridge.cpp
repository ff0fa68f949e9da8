#include "fast_cartridge.hpp"

#include <utility>

namespace atari {

FastCartridge::FastCartridge(std::vector<uint8_t> image, const std::string& type, bool translated)
    : Cartridge(std::move(image), type), code_(decode_image(*this)) {
    if (translated) translated_code_.make(this->image(), code_);
    for (size_t place = 0; place < code_.size(); ++place)
        if (translated_code_.has(place)) code_[place].code = code_of(kTranslated);
    for (size_t at = 0; at + 64 <= size(); at += 64) pages_.push_back(this->image() + at);
}

}  // namespace atari
