// Bytes of a file: a bounded reader, and functions that append. All integers of the project's files are little-endian.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace atari::web {

using Bytes = std::vector<uint8_t>;
using View = std::span<const uint8_t>;

// What is wrong with a file, a text or a call, as a sentence for the page.
struct Refused : std::runtime_error {
    using std::runtime_error::runtime_error;
};

inline View view_of(std::string_view text) { return {reinterpret_cast<const uint8_t*>(text.data()), text.size()}; }
inline std::string_view text_of(View bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

// Reads integers and parts from the front. A read past the end throws Refused.
class ByteReader {
  public:
    explicit ByteReader(View bytes) : rest_(bytes) {}

    size_t left() const { return rest_.size(); }
    View take(size_t size) {
        if (size > rest_.size()) throw Refused("the bytes end too early");
        const View part = rest_.first(size);
        rest_ = rest_.subspan(size);
        return part;
    }
    uint8_t byte() { return take(1)[0]; }
    uint16_t word() { return static_cast<uint16_t>(number(2)); }
    uint32_t dword() { return number(4); }

  private:
    uint32_t number(size_t size) {
        const View part = take(size);
        uint32_t value = 0;
        for (size_t i = size; i-- > 0;) value = value << 8 | part[i];
        return value;
    }

    View rest_;
};

inline void append(Bytes& out, View bytes) { out.insert(out.end(), bytes.begin(), bytes.end()); }
inline void append_number(Bytes& out, uint32_t value, size_t size) {
    for (; size > 0; --size, value >>= 8) out.push_back(static_cast<uint8_t>(value));
}

}  // namespace atari::web
