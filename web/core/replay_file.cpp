#include "replay_file.hpp"

#include <algorithm>
#include <cstring>

#include "crc32.hpp"
#include "deflate.hpp"
#include "hashes.hpp"

namespace atari::web {
namespace {

constexpr std::string_view kMagic = "ATARIRPL";
constexpr size_t kMostPayload = size_t{1} << 24, kMostEvents = size_t{1} << 20, kHead = 11;
constexpr size_t kMostUnpacked = size_t{1} << 26;  // the events of all chunks: hours of play have a tenth of it
constexpr uint8_t kGoesOn = 0x20, kStrength = 0x40;
constexpr uint64_t kPlayerActions = 18;

[[noreturn]] void damaged(size_t offset, const std::string& what) {
    throw Refused("the replay is damaged at offset " + std::to_string(offset) + ": " + what);
}

size_t numbers_of(EventKind kind) {
    switch (kind) {
        case EventKind::kReset:
        case EventKind::kSave:
        case EventKind::kContinuousAction:
        case EventKind::kStep: return 0;
        case EventKind::kAct:
        case EventKind::kPoke:
        case EventKind::kAddWrite:
        case EventKind::kActions: return 2;
        default: return 1;
    }
}

void append_varint(Bytes& out, uint64_t number) {
    for (; number >= 0x80; number >>= 7) out.push_back(static_cast<uint8_t>(number | 0x80));
    out.push_back(static_cast<uint8_t>(number));
}

uint64_t varint(ByteReader& in) {
    uint64_t value = 0;
    for (int shift = 0; shift <= 28; shift += 7) {
        const uint8_t digit = in.byte();
        value |= uint64_t{digit & 0x7fu} << shift;
        if (digit < 0x80) return value;
    }
    throw Refused("a number is larger than 32 bits");
}

void append_float(Bytes& out, float value) {
    uint32_t word;
    std::memcpy(&word, &value, sizeof word);
    append_number(out, word, 4);
}

float read_float(ByteReader& in) {
    const uint32_t word = in.dword();
    float value;
    std::memcpy(&value, &word, sizeof value);
    return value;
}

Event event_of(uint8_t code, ByteReader& arguments) {
    if (code < 0x80) {
        Event event{EventKind::kAct, {code & 0x1fu, varint(arguments)}, {}, !(code & kGoesOn)};
        if (event.numbers[0] >= kPlayerActions) throw Refused("there is an action " + std::to_string(event.numbers[0]));
        if (code & kStrength) event.floats.push_back(read_float(arguments));
        return event;
    }
    if (code > static_cast<uint8_t>(EventKind::kRemoveWrite) && code != static_cast<uint8_t>(EventKind::kActions))
        throw Refused("there is no event of code " + std::to_string(code));
    Event event{static_cast<EventKind>(code)};
    for (size_t i = 0; i < numbers_of(event.kind); ++i) event.numbers[i] = varint(arguments);
    if (event.kind == EventKind::kContinuousAction)
        for (int i = 0; i < 3; ++i) event.floats.push_back(read_float(arguments));
    return event;
}

std::vector<Event> parse_events(View text) {
    ByteReader in(text);
    const View codes = in.take(varint(in));
    std::vector<Event> events;
    uint64_t acts = 0;
    for (const uint8_t code : codes) {
        events.push_back(event_of(code, in));
        if (events.back().acts()) acts += events.back().numbers[1];
        if (acts > kActsPerChunk) throw Refused("there are more than 4096 actions");
    }
    if (in.left() > 0) throw Refused("the events end before their arguments");
    return events;
}

PlayChunk parse_play(View payload, size_t offset, uint32_t first) {
    ByteReader in(payload);
    if (payload.size() < 8) damaged(offset, "a chunk of play is too short");
    PlayChunk play{in.dword(), {}, {}, {}, offset};
    const uint32_t frames = in.word(), size = in.word();
    const size_t full = (first + frames) / kFramesPerFullHash - first / kFramesPerFullHash;
    if (play.first != first || in.left() != size + (frames + 3) / 4 + 4 * full)
        damaged(offset, "a chunk of play does not fit the chunk before, or its own size");
    const View events = in.take(size), bits = in.take((frames + 3) / 4);
    play.events.assign(events.begin(), events.end());
    for (uint32_t frame = 0; frame < frames; ++frame)
        play.short_hashes.push_back(bits[frame / 4] >> (2 * (frame % 4)) & 3);
    for (size_t i = 0; i < full; ++i) play.full_hashes.push_back(in.dword());
    return play;
}

Json parse_object(View payload, size_t offset) {
    try {
        Json found = parse_json(text_of(payload), kMostPayload);
        if (found.kind != Json::Kind::kObject) damaged(offset, "the chunk is no JSON object");
        return found;
    } catch (const Refused& error) {
        damaged(offset, error.what());
    }
}

// The chunks of a file, added one after another.
class ContentReader {
  public:
    void add(char kind, View payload, size_t offset) {
        if ((kind == 'H') != !has_header_)
            damaged(offset, "the header must be the first chunk, and the only one of its kind");
        if (content_.end) damaged(offset, "a chunk comes after the end");
        switch (kind) {
            case 'H': add_header(payload, offset); break;
            case 'P': content_.plays.push_back(parse_play(payload, offset, content_.frames())); break;
            case 'S': content_.snapshots.emplace_back(payload.begin(), payload.end()); break;
            case 'W': content_.writes.emplace_back(text_of(payload)); break;
            case 'E': content_.end = parse_object(payload, offset); break;
            default: damaged(offset, "there is no such kind of chunk");
        }
    }

    ReplayContent finish() {
        if (!has_header_) damaged(kMagic.size(), "the file ends within its header, and holds nothing");
        check_events();
        return std::move(content_);
    }

  private:
    void add_header(View payload, size_t offset) {
        content_.header = parse_object(payload, offset);
        content_.header_text = text_of(payload);
        has_header_ = true;
        const int reads = content_.header.find("players") ? 2 : 1;
        const Json* const format = content_.header.find("format");
        if (!format || !format->is_integer() || format->number != reads)
            throw Refused("the replay has format " + (format ? format->canonical().substr(0, 40) : "None") +
                          ", and this page reads " + std::to_string(reads) +
                          "; use the page of the release that wrote it");
    }

    // Unpacks the events of all chunks once, so that a damaged one is an error now.
    void check_events() const {
        size_t unpacked = 0;
        for (const PlayChunk& play : content_.plays) {
            try {
                const Bytes text = inflate(play.events, kMostEvents);
                parse_events(text);
                unpacked += text.size();
            } catch (const Refused& error) {
                damaged(play.offset, error.what());
            }
            if (unpacked > kMostUnpacked) damaged(play.offset, "the events are too many");
        }
    }

    ReplayContent content_;
    bool has_header_ = false;
};

}  // namespace

Bytes pack_events(std::span<const Event> events) {
    Bytes text, arguments;
    append_varint(text, events.size());
    for (const Event& event : events) {
        auto code = static_cast<uint8_t>(event.kind);
        size_t first = 0;
        if (event.kind == EventKind::kAct) {
            code = static_cast<uint8_t>(event.numbers[0] | (event.ends_step ? 0 : kGoesOn) |
                                        (event.floats.empty() ? 0 : kStrength));
            first = 1;
        }
        text.push_back(code);
        for (size_t i = first; i < numbers_of(event.kind); ++i) append_varint(arguments, event.numbers[i]);
        for (const float value : event.floats) append_float(arguments, value);
    }
    append(text, arguments);
    return deflate(text);
}

std::vector<Event> unpack_events(View packed) { return parse_events(inflate(packed, kMostEvents)); }

Bytes PlayChunk::payload() const {
    Bytes out;
    append_number(out, first, 4);
    append_number(out, static_cast<uint32_t>(short_hashes.size()), 2);
    append_number(out, static_cast<uint32_t>(events.size()), 2);
    append(out, events);
    for (size_t frame = 0; frame < short_hashes.size(); ++frame) {
        if (frame % 4 == 0) out.push_back(0);
        out.back() |= static_cast<uint8_t>(short_hashes[frame] << (2 * (frame % 4)));
    }
    for (const uint32_t hash : full_hashes) append_number(out, hash, 4);
    return out;
}

int64_t ReplayContent::players() const {
    return header.find("players") ? header.integer_of("players", "the header") : 1;
}

ReplayContent read_replay(View file) {
    if (!text_of(file).starts_with(kMagic)) throw Refused("the file is no replay of atari-envs");
    if (file.size() > kMostReplay) throw Refused("the replay is too large for the page");
    ContentReader content;
    ByteReader in(file.subspan(kMagic.size()));
    while (in.left() >= kHead) {
        const size_t offset = file.size() - in.left();
        const View head = in.take(kHead);
        ByteReader fields(head);
        const char kind = static_cast<char>(fields.byte());
        const uint32_t size = fields.dword(), sum = fields.dword();
        if (crc16(head.first(kHead - 2)) != fields.word() || size > kMostPayload)
            damaged(offset, "the head of a chunk does not match its checksum");
        if (in.left() < size) break;  // the file was cut while it was recorded
        const View payload = in.take(size);
        if (crc32(0, payload.data(), payload.size()) != sum) damaged(offset, "a chunk does not match its checksum");
        content.add(kind, payload, offset);
    }
    return content.finish();
}

Bytes begin_replay(std::string_view header) {
    Bytes file;
    append(file, view_of(kMagic));
    append_chunk(file, 'H', view_of(header));
    return file;
}

void append_chunk(Bytes& file, char kind, View payload) {
    Bytes head{static_cast<uint8_t>(kind)};
    append_number(head, static_cast<uint32_t>(payload.size()), 4);
    append_number(head, crc32(0, payload.data(), payload.size()), 4);
    append_number(head, crc16(head), 2);
    append(file, head);
    append(file, payload);
}

}  // namespace atari::web
