#include "json.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "hashes.hpp"

namespace atari::web {
namespace {

// The characters after a backslash, and what they stand for.
constexpr std::string_view kNames = "\"\\bfnrt/", kMeanings = "\"\\\b\f\n\r\t/";
constexpr int kMostDepth = 32;
constexpr size_t kMostDigits = 1000;

[[noreturn]] void damaged(const char* what) { throw Refused(std::string("the JSON is damaged: ") + what); }

// Appends a code point in UTF-8.
void append_utf8(std::string& out, uint32_t code) {
    if (code < 0x80) {
        out += static_cast<char>(code);
        return;
    }
    const int more = code < 0x800 ? 1 : code < 0x10000 ? 2 : 3;
    static constexpr uint32_t kLead[] = {0, 0xc0, 0xe0, 0xf0};
    out += static_cast<char>(kLead[more] | code >> (6 * more));
    for (int i = more; i-- > 0;) out += static_cast<char>(0x80 | (code >> (6 * i) & 0x3f));
}

// Returns the code point at `at`, and moves `at` after it. Throws Refused if the text is no UTF-8.
uint32_t next_code_point(std::string_view text, size_t& at) {
    const auto byte = [&](size_t i) { return i < text.size() ? static_cast<uint8_t>(text[i]) : uint8_t{0}; };
    const uint8_t lead = byte(at);
    const int more = lead < 0x80                   ? 0
                     : lead >= 0xc2 && lead < 0xe0 ? 1
                     : lead >= 0xe0 && lead < 0xf0 ? 2
                     : lead >= 0xf0 && lead < 0xf5 ? 3
                                                   : -1;
    if (more < 0) damaged("it is no UTF-8");
    uint32_t code = more == 0 ? lead : lead & (0x3fu >> more);
    for (int i = 1; i <= more; ++i) {
        const uint8_t next = byte(at + static_cast<size_t>(i));
        if ((next & 0xc0) != 0x80) damaged("it is no UTF-8");
        code = code << 6 | (next & 0x3f);
    }
    static constexpr uint32_t kLeast[] = {0, 0x80, 0x800, 0x10000};
    if (code < kLeast[more] || code > 0x10ffff || (code >= 0xd800 && code < 0xe000)) damaged("it is no UTF-8");
    at += static_cast<size_t>(more) + 1;
    return code;
}

class Parser {
  public:
    explicit Parser(std::string_view text) : text_(text) {}

    Json all() {
        Json found = value(0);
        skip_spaces();
        if (at_ != text_.size()) damaged("there is more after its end");
        return found;
    }

  private:
    char peek() const { return at_ < text_.size() ? text_[at_] : '\0'; }
    void skip_spaces() {
        while (peek() == ' ' || peek() == '\n' || peek() == '\r' || peek() == '\t') ++at_;
    }
    bool accept(std::string_view word) {
        if (text_.substr(at_, word.size()) != word) return false;
        at_ += word.size();
        return true;
    }

    Json value(int depth) {
        skip_spaces();
        Json found;
        switch (peek()) {
            case '{':
            case '[':
                if (depth == kMostDepth) damaged("its lists and objects are nested too deep");
                parse_items(found, depth);
                return found;
            case '"':
                found.kind = Json::Kind::kText;
                found.text = parse_text();
                return found;
            case 'n': found.kind = Json::Kind::kNull; break;
            case 't': found.kind = Json::Kind::kTrue; break;
            case 'f': found.kind = Json::Kind::kFalse; break;
            default: parse_number(found); return found;
        }
        if (!accept("null") && !accept("true") && !accept("false")) damaged("it has an unknown word");
        return found;
    }

    void parse_items(Json& found, int depth) {
        const bool object = text_[at_++] == '{';
        found.kind = object ? Json::Kind::kObject : Json::Kind::kList;
        const std::string_view end = object ? "}" : "]";
        skip_spaces();
        if (accept(end)) return;
        do {
            std::string name;
            skip_spaces();
            if (object) {
                name = parse_text();
                if (found.find(name)) damaged("a key is there twice");
                skip_spaces();
                if (!accept(":")) damaged("a key has no value");
            }
            found.items.emplace_back(std::move(name), value(depth + 1));
            skip_spaces();
        } while (accept(","));
        if (!accept(end)) damaged("a list or an object does not end");
    }

    uint32_t four_digits() {
        uint32_t code = 0;
        for (int i = 0; i < 4; ++i) {
            const char c = peek();
            const int digit = c >= '0' && c <= '9'                 ? c - '0'
                              : (c | 32) >= 'a' && (c | 32) <= 'f' ? (c | 32) - 'a' + 10
                                                                   : -1;
            if (digit < 0) damaged("a string has a wrong escape");
            code = code << 4 | static_cast<uint32_t>(digit);
            ++at_;
        }
        return code;
    }

    std::string parse_text() {
        if (!accept("\"")) damaged("a string is missing");
        std::string decoded;
        while (peek() != '"') {
            if (at_ >= text_.size()) damaged("a string does not end");
            if (static_cast<uint8_t>(peek()) < 0x20) damaged("a string has a control character");
            if (!accept("\\")) {
                append_utf8(decoded, next_code_point(text_, at_));
                continue;
            }
            if (accept("u")) {
                uint32_t code = four_digits();
                if (code >= 0xd800 && code < 0xdc00 && accept("\\u")) {
                    const uint32_t low = four_digits();
                    if (low < 0xdc00 || low >= 0xe000) damaged("a string has half a character");
                    code = 0x10000 + ((code - 0xd800) << 10) + (low - 0xdc00);
                }
                if (code >= 0xd800 && code < 0xe000) damaged("a string has half a character");
                append_utf8(decoded, code);
            } else {
                const size_t which = kNames.find(peek());
                if (which == std::string_view::npos || at_ >= text_.size()) damaged("a string has a wrong escape");
                decoded += kMeanings[which];
                ++at_;
            }
        }
        ++at_;
        return decoded;
    }

    bool digits() {
        const size_t start = at_;
        while (peek() >= '0' && peek() <= '9') ++at_;
        return at_ > start;
    }

    void parse_number(Json& found) {
        const size_t start = at_;
        accept("-");
        if (!accept("0") && !digits()) damaged("a value is missing");
        bool whole = true;
        if (accept(".")) {
            whole = false;
            if (!digits()) damaged("a number has no digits");
        }
        if (accept("e") || accept("E")) {
            whole = false;
            if (!accept("+")) accept("-");
            if (!digits()) damaged("a number has no digits");
        }
        found.kind = Json::Kind::kNumber;
        found.token = text_.substr(start, at_ - start);
        if (found.token.size() > kMostDigits) damaged("a number is out of range");
        found.number = std::strtod(found.token.c_str(), nullptr);
        // A whole number has at most 64 bits, besides its sign.
        static constexpr std::string_view kTooLarge = "18446744073709551616";
        const std::string_view digits = std::string_view(found.token).substr(found.token[0] == '-');
        if (whole ? digits.size() > kTooLarge.size() || (digits.size() == kTooLarge.size() && digits >= kTooLarge)
                  : !std::isfinite(found.number))
            damaged("a number is out of range");
    }

    std::string_view text_;
    size_t at_ = 0;
};

}  // namespace

bool Json::is_integer() const {
    return kind == Kind::kNumber && token.find_first_of(".eE") == std::string::npos &&
           std::abs(number) <= 9007199254740992.0;
}

const Json* Json::find(std::string_view name) const {
    if (kind != Kind::kObject) return nullptr;
    const auto place = std::find_if(items.begin(), items.end(), [&](const auto& item) { return item.first == name; });
    return place == items.end() ? nullptr : &place->second;
}

const std::string& Json::text_of(std::string_view name, const std::string& what) const {
    const Json* const found = find(name);
    if (!found || found->kind != Kind::kText) throw Refused(what + " has no text \"" + std::string(name) + "\"");
    return found->text;
}

int64_t Json::integer_of(std::string_view name, const std::string& what) const {
    const Json* const found = find(name);
    if (!found || !found->is_integer()) throw Refused(what + " has no whole number \"" + std::string(name) + "\"");
    return static_cast<int64_t>(found->number);
}

std::string Json::canonical() const {
    switch (kind) {
        case Kind::kNull: return "null";
        case Kind::kTrue: return "true";
        case Kind::kFalse: return "false";
        case Kind::kNumber: return token;
        case Kind::kText: return quoted(text);
        default: break;
    }
    const bool object = kind == Kind::kObject;
    std::vector<std::string> parts;
    for (const auto& [name, value] : items) parts.push_back((object ? quoted(name) + ": " : "") + value.canonical());
    if (object) std::sort(parts.begin(), parts.end());
    std::string joined(object ? "{" : "[");
    for (const std::string& part : parts) joined += (joined.size() > 1 ? ", " : "") + part;
    return joined + (object ? "}" : "]");
}

Json parse_json(std::string_view text, size_t most) {
    if (text.size() > most) damaged("it is too long");
    return Parser(text).all();
}

std::string quoted(std::string_view text) {
    std::string out = "\"";
    for (size_t at = 0; at < text.size();) {
        const uint32_t code = next_code_point(text, at);
        const size_t which = code < 0x80 ? kMeanings.find(static_cast<char>(code)) : std::string_view::npos;
        if (which != std::string_view::npos && code != '/') {
            out += '\\';
            out += kNames[which];
            continue;
        }
        if (code >= 0x20 && code < 0x7f) {
            out += static_cast<char>(code);
            continue;
        }
        const auto escape = [&](uint32_t unit) {
            const uint8_t bytes[] = {static_cast<uint8_t>(unit >> 8), static_cast<uint8_t>(unit)};
            out += "\\u" + hex(bytes);
        };
        if (code >= 0x10000) escape(0xd800 + ((code - 0x10000) >> 10));
        escape(code >= 0x10000 ? 0xdc00 + (code & 0x3ff) : code);
    }
    return out + '"';
}

}  // namespace atari::web
