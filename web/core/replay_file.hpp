// Replay files (atari/recording/replay/file_format.py and events.py have the format): a bounded reader, and a writer.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "bytes.hpp"
#include "json.hpp"

namespace atari::web {

inline constexpr uint32_t kFramesPerFullHash = 60, kFramesPerChunk = 240, kActsPerChunk = 4096;
inline constexpr size_t kMostReplay = size_t{1} << 24;  // bytes of a file that the page opens

// The kinds of events. The values are codes, except that kAct has many codes.
enum class EventKind : uint8_t {
    kAct = 0x00,
    kReset = 0x80,
    kSeed,
    kPoke,
    kSave,
    kRestore,
    kLoad,
    kMode,
    kDifficulty,
    kContinuousAction,
    kStep,
    kAddWrite,
    kRemoveWrite,
    kActions = 0x90,
};

// An event. kAct and kActions have the action and its number of frames in `numbers`; kAct has the strength in `floats`,
// if it is not 1.
struct Event {
    EventKind kind;
    std::array<uint64_t, 2> numbers{};
    std::vector<float> floats{};
    bool ends_step = false;

    bool acts() const { return kind == EventKind::kAct || kind == EventKind::kActions; }
    bool operator==(const Event&) const = default;
};

Bytes pack_events(std::span<const Event> events);
std::vector<Event> unpack_events(View packed);  // throws Refused

struct PlayChunk {
    uint32_t first = 0;                 // frames before this chunk
    Bytes short_hashes;                 // two bits of each frame
    std::vector<uint32_t> full_hashes;  // of each frame whose number, from 1, is a multiple of kFramesPerFullHash
    Bytes events;                       // packed
    size_t offset = 0;                  // in the file

    Bytes payload() const;
};

struct ReplayContent {
    Json header;
    std::string header_text;
    std::vector<PlayChunk> plays;
    std::vector<Bytes> snapshots;
    std::vector<std::string> writes;
    std::optional<Json> end;  // none if the recording was cut

    uint32_t frames() const {
        return plays.empty() ? 0 : plays.back().first + static_cast<uint32_t>(plays.back().short_hashes.size());
    }
    int64_t players() const;
};

// Reads a file, with its events. Throws Refused with the offset of the damage.
ReplayContent read_replay(View file);

// The bytes of a file that begins with this header.
Bytes begin_replay(std::string_view header);
// Appends a chunk.
void append_chunk(Bytes& file, char kind, View payload);

}  // namespace atari::web
