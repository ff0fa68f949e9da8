#include "snapshot.hpp"

#include <string>

#include "deflate.hpp"
#include "hashes.hpp"
#include "json.hpp"

namespace atari::web {
namespace {

constexpr std::string_view kMagic = "ATARISNP";
constexpr uint16_t kVersion = 1;
constexpr size_t kDigestSize = 16, kMostState = size_t{1} << 20;

bool same(const Json* one, const Json& other) {
    if (!one || one->kind != other.kind) return false;
    if (one->kind == Json::Kind::kNumber) return one->number == other.number;
    if (one->kind == Json::Kind::kText) return one->text == other.text;
    if (one->items.size() != other.items.size()) return false;
    for (size_t i = 0; i < other.items.size(); ++i)
        if (one->items[i].first != other.items[i].first || !same(&one->items[i].second, other.items[i].second))
            return false;
    return true;
}

std::string shown(const Json* value) {
    if (!value) return "nothing";
    const std::string text =
        value->kind == Json::Kind::kList || value->kind == Json::Kind::kObject ? "..." : value->canonical();
    return text.size() > 80 ? text.substr(0, 80) + "..." : text;
}

}  // namespace

Bytes pack_snapshot(std::string_view facts, View state) {
    const Bytes packed = deflate_zlib(state);
    const std::string text = std::string(facts.substr(0, facts.size() - 1)) + ", \"blobs\": [[\"state\", " +
                             std::to_string(packed.size()) + "]]}";
    Bytes body;
    append_number(body, static_cast<uint32_t>(text.size()), 4);
    append(body, view_of(text));
    append(body, packed);
    Bytes out;
    append(out, view_of(kMagic));
    append_number(out, kVersion, 2);
    append(out, blake2b(body, kDigestSize));
    append(out, body);
    return out;
}

Bytes unpack_snapshot(View snapshot, std::string_view expected, bool any_sound) {
    if (!text_of(snapshot).starts_with(kMagic)) throw Refused("these bytes are not a snapshot of atari-envs");
    ByteReader in(snapshot.subspan(kMagic.size()));
    if (in.left() < 2 + kDigestSize + 4) throw Refused("the snapshot is truncated: it is less than its header");
    if (const uint16_t version = in.word(); version != kVersion)
        throw Refused("the snapshot has format version " + std::to_string(version) + ", this page reads version " +
                      std::to_string(kVersion));
    const View digest = in.take(kDigestSize), body = snapshot.last(in.left());
    if (blake2b(body, kDigestSize) != Bytes(digest.begin(), digest.end()))
        throw Refused("the snapshot is damaged or truncated: its checksum does not match its content");
    const uint32_t size = in.dword();
    const Json facts = parse_json(text_of(in.take(size)));
    const Json required = parse_json(expected);
    for (const auto& [name, value] : required.items)
        if (!same(facts.find(name), value) && !(any_sound && name == "sound"))
            throw Refused("the snapshot was taken with " + name + " = " + shown(facts.find(name)) +
                          ", but this game has " + shown(&value));
    const Json* const blobs = facts.find("blobs");
    if (!blobs || blobs->canonical() != "[[\"state\", " + std::to_string(in.left()) + "]]")
        throw Refused("the snapshot is damaged: its facts do not fit its blobs");
    return inflate_zlib(in.take(in.left()), kMostState);
}

}  // namespace atari::web
