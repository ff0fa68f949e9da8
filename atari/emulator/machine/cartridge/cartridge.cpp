#include "cartridge.hpp"

#include <algorithm>
#include <array>
#include <initializer_list>
#include <stdexcept>
#include <utility>

namespace atari {
namespace {

using Bytes = std::vector<uint8_t>;

struct TypeRow {
    const char* name;
    CartridgeType type;
    size_t image_size;  // minimum, in bytes
    size_t ram_size;
    size_t random_bytes;
};

// clang-format off
constexpr std::array<TypeRow, 19> kTypes = {{
    {"2K", CartridgeType::k2K, 2048, 0, 0},
    {"4K", CartridgeType::k4K, 4096, 0, 0},
    {"F8", CartridgeType::kF8, 8192, 0, 0},
    {"F8 SWAPPED", CartridgeType::kF8Swapped, 8192, 0, 0},
    {"F6", CartridgeType::kF6, 16384, 0, 0},
    {"F4", CartridgeType::kF4, 32768, 0, 0},
    {"F8SC", CartridgeType::kF8SC, 8192, 128, 128},
    {"F6SC", CartridgeType::kF6SC, 16384, 128, 128},
    {"F4SC", CartridgeType::kF4SC, 32768, 128, 128},
    {"FASC", CartridgeType::kFASC, 12288, 256, 256},
    {"E0", CartridgeType::kE0, 8192, 0, 0},
    {"E7", CartridgeType::kE7, 16384, 2048, 2048},
    {"FE", CartridgeType::kFE, 8192, 0, 0},
    {"DPC", CartridgeType::kDPC, 10240, 0, 0},
    {"3F", CartridgeType::k3F, 2048, 0, 0},
    {"3E", CartridgeType::k3E, 2048, 32768, 32768},
    {"UA", CartridgeType::kUA, 8192, 0, 0},
    {"CV", CartridgeType::kCV, 2048, 1024, 1024},
    {"MB", CartridgeType::kMB, 65536, 0, 0},
}};
// clang-format on

const TypeRow& row(CartridgeType type) { return kTypes[static_cast<size_t>(type)]; }

// Returns how often `signature` occurs. The last possible position is not tried, as in the reference. After a match,
// the search skips one byte.
int occurrences(const Bytes& image, std::initializer_list<uint8_t> signature) {
    int found = 0;
    for (size_t at = 0; at + signature.size() < image.size(); ++at) {
        if (std::equal(signature.begin(), signature.end(), image.begin() + static_cast<ptrdiff_t>(at))) {
            ++found;
            at += signature.size();
        }
    }
    return found;
}

bool any_of(const Bytes& image, std::initializer_list<std::initializer_list<uint8_t>> signatures) {
    return std::any_of(signatures.begin(), signatures.end(),
                       [&](const auto& signature) { return occurrences(image, signature) > 0; });
}

bool halves_equal(const Bytes& image) {
    const auto middle = image.begin() + static_cast<ptrdiff_t>(image.size() / 2);
    return std::equal(image.begin(), middle, middle);
}

// Returns whether the first 256 bytes of each bank are RAM; if so, the image repeats one byte there.
bool looks_superchip(const Bytes& image) {
    for (size_t bank = 0; bank + 4096 <= image.size(); bank += 4096) {
        const auto first = image.begin() + static_cast<ptrdiff_t>(bank);
        if (!std::all_of(first, first + 256, [&](uint8_t byte) { return byte == *first; })) return false;
    }
    return true;
}

bool looks_e7(const Bytes& image) {
    const auto first = image.begin() + 0x3800, last = image.begin() + 0x3a00;
    const auto same = [&](uint8_t byte) { return byte == *first; };
    if (!std::all_of(first, last, same)) return false;
    return !std::all_of(first - 32, first, same) || !std::all_of(last, last + 32, same);
}

bool looks_cv(const Bytes& image) { return any_of(image, {{0x9d, 0xff, 0xf3}, {0x99, 0x00, 0xf4}}); }
bool looks_3e(const Bytes& image) { return any_of(image, {{0x85, 0x3e, 0xa9, 0x00}}); }
bool looks_3f(const Bytes& image) { return occurrences(image, {0x85, 0x3f}) >= 2; }
bool looks_ua(const Bytes& image) { return any_of(image, {{0x8d, 0x40, 0x02}}); }
bool looks_e0(const Bytes& image) {
    return any_of(image, {{0x8d, 0xe0, 0x1f},
                          {0x8d, 0xe0, 0x5f},
                          {0x8d, 0xe9, 0xff},
                          {0xad, 0xe9, 0xff},
                          {0xad, 0xed, 0xff},
                          {0xad, 0xf3, 0xbf}});
}
bool looks_fe(const Bytes& image) {
    return any_of(image, {{0x20, 0x00, 0xd0, 0xc6, 0xc5},
                          {0x20, 0xc3, 0xf8, 0xa5, 0x82},
                          {0xd0, 0xfb, 0x20, 0x73, 0xfe},
                          {0x20, 0x00, 0xf0, 0x84, 0xd6}});
}

CartridgeType recognise(const Bytes& image) {
    using Type = CartridgeType;
    const size_t size = image.size();
    const auto larger = [&](Type otherwise) {
        return looks_3e(image) ? Type::k3E : looks_3f(image) ? Type::k3F : otherwise;
    };
    if (size != 0 && size % 8448 == 0)
        throw std::invalid_argument("Supercharger (AR) images are not supported: the reference leaves them undefined");
    if (size == 2048 || (size == 4096 && halves_equal(image))) return looks_cv(image) ? Type::kCV : Type::k2K;
    if (size == 4096) return looks_cv(image) ? Type::kCV : Type::k4K;
    if (size == 8192) {
        if (looks_superchip(image)) return Type::kF8SC;
        if (halves_equal(image)) return Type::k4K;
        if (looks_e0(image)) return Type::kE0;
        if (looks_3e(image)) return Type::k3E;
        if (looks_3f(image)) return Type::k3F;
        if (looks_ua(image)) return Type::kUA;
        return looks_fe(image) ? Type::kFE : Type::kF8;
    }
    if (size == 10240 || size == 10495 || size == 10496) return Type::kDPC;
    if (size == 12288) return Type::kFASC;
    if (size == 16384) {
        if (looks_superchip(image)) return Type::kF6SC;
        return looks_e7(image) ? Type::kE7 : larger(Type::kF6);
    }
    if (size == 32768) return looks_superchip(image) ? Type::kF4SC : larger(Type::kF4);
    if (size == 65536) return larger(Type::kMB);
    if (looks_3e(image)) return Type::k3E;
    if (looks_3f(image)) return Type::k3F;
    throw std::invalid_argument("an image of " + std::to_string(size) + " bytes is of no supported cartridge type");
}

CartridgeType by_name(const std::string& name) {
    for (const TypeRow& type : kTypes)
        if (name == type.name) return type.type;
    std::string all;
    for (const TypeRow& type : kTypes) all += std::string(all.empty() ? "" : ", ") + type.name;
    throw std::invalid_argument("there is no cartridge type '" + name + "'; the types are " + all);
}

}  // namespace

Cartridge::Cartridge(std::vector<uint8_t> image, const std::string& type) : image_(std::move(image)) {
    if (image_.size() > (1u << 19)) throw std::invalid_argument("an image has at most 524288 bytes");
    type_ = type.empty() ? recognise(image_) : by_name(type);
    if (image_.size() < row(type_).image_size)
        throw std::invalid_argument("a cartridge of type " + type_name() + " needs an image of at least " +
                                    std::to_string(row(type_).image_size) + " bytes, this one has " +
                                    std::to_string(image_.size()));
    if (type_ == CartridgeType::k3F || type_ == CartridgeType::k3E) image_.resize(image_.size() / 2048 * 2048);
}

Window Cartridge::plain_window() const {
    const auto window = [](unsigned from, unsigned to) { return Window{from, to - from}; };
    switch (type_) {
        case CartridgeType::kE0: return window(0, 0xfe0);
        case CartridgeType::k3E:
        case CartridgeType::kCV: return window(0x800, 0x1000);
        case CartridgeType::kE7: return window(0xa00, 0xfe0);
        case CartridgeType::kF8SC:
        case CartridgeType::kF6SC: return window(0x100, 0xff6);
        case CartridgeType::kF4SC: return window(0x100, 0xff4);
        case CartridgeType::kFASC: return window(0x200, 0xff8);
        case CartridgeType::kDPC: return window(0x80, 0xfc0);
        case CartridgeType::kMB: return window(0, 0xff0);
        case CartridgeType::kF8:
        case CartridgeType::kF8Swapped:
        case CartridgeType::kF6:
        case CartridgeType::kF4: return window(0, 0xff4);
        default: return window(0, 0x1000);
    }
}

std::string Cartridge::type_name() const { return row(type_).name; }
bool Cartridge::watches_tia() const {
    return type_ == CartridgeType::k3F || type_ == CartridgeType::k3E || type_ == CartridgeType::kUA;
}

size_t Cartridge::ram_size() const { return row(type_).ram_size; }
size_t Cartridge::random_bytes() const {
    const bool cv_from_image = type_ == CartridgeType::kCV && image_.size() >= 4096;
    return cv_from_image ? 0 : row(type_).random_bytes;
}

}  // namespace atari
