// JSON that may come from a stranger: bounded in size, depth and numbers. Values are compared by their canonical text.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bytes.hpp"

namespace atari::web {

struct Json {
    enum class Kind { kNull, kFalse, kTrue, kNumber, kText, kList, kObject };

    Kind kind = Kind::kNull;
    std::string token;  // of a number or a text, as in the source
    std::string text;   // decoded
    double number = 0;
    std::vector<std::pair<std::string, Json>> items;  // of a list, without names; of an object, by decoded name

    bool is_null() const { return kind == Kind::kNull; }
    bool is_true() const { return kind == Kind::kTrue; }
    bool is_integer() const;                        // a whole number of at most 53 bits
    const Json* find(std::string_view name) const;  // null if this is no object, or has no such key
    // Throw Refused if there is no such key, or it has another type. `what` is the subject of the message.
    const std::string& text_of(std::string_view name, const std::string& what) const;
    int64_t integer_of(std::string_view name, const std::string& what) const;

    // The text that Python's `json.dumps(value, sort_keys=True)` returns for a value that it wrote.
    std::string canonical() const;
};

inline constexpr size_t kMostJson = size_t{1} << 24;

// Throws Refused if the text is no JSON in UTF-8, nested more than 32 deep, or a key is there twice.
Json parse_json(std::string_view text, size_t most = kMostJson);

// A string of JSON, with escapes for all characters but ASCII's. `text` must be UTF-8.
std::string quoted(std::string_view text);

}  // namespace atari::web
