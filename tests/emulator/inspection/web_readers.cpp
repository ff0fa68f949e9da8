// The readers of the page's core (web/core/), for tests that compare them with Python's. What the core refuses is a
// RuntimeError here.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <optional>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include "deflate.hpp"
#include "hashes.hpp"
#include "json.hpp"
#include "options.hpp"
#include "python/arrays.hpp"
#include "replay_file.hpp"
#include "snapshot.hpp"

namespace atari {
namespace {

web::View view(nb::bytes bytes) { return {static_cast<const uint8_t*>(bytes.data()), bytes.size()}; }
nb::bytes bytes_from(web::View bytes) { return nb::bytes(reinterpret_cast<const char*>(bytes.data()), bytes.size()); }

nb::list events_of(const std::vector<web::Event>& events) {
    nb::list found;
    for (const web::Event& event : events)
        found.append(nb::make_tuple(static_cast<int>(event.kind), event.numbers[0], event.numbers[1], event.floats,
                                    event.ends_step));
    return found;
}

nb::dict replay(nb::bytes file) {
    const web::ReplayContent content = web::read_replay(view(file));
    nb::list plays, snapshots, writes;
    for (const web::PlayChunk& play : content.plays) {
        const std::vector<web::Event> events = web::unpack_events(play.events);
        if (web::unpack_events(web::pack_events(events)) != events)
            throw std::logic_error("packing changes the events");
        plays.append(nb::make_tuple(play.first, bytes_from(play.short_hashes), play.full_hashes, events_of(events),
                                    bytes_from(play.payload())));
    }
    for (const web::Bytes& snapshot : content.snapshots) snapshots.append(bytes_from(snapshot));
    for (const std::string& write : content.writes) writes.append(bytes_from(web::view_of(write)));
    nb::dict found;
    found["header"] = content.header.canonical();
    found["end"] = content.end ? std::optional(content.end->canonical()) : std::nullopt;
    found["plays"] = plays;
    found["snapshots"] = snapshots;
    found["writes"] = writes;
    return found;
}

}  // namespace

void register_web_readers(nb::module_& m) {
    m.def("web_replay", &replay, "file"_a, nb::sig("def web_replay(file: bytes) -> dict[str, object]"),
          "The content of a replay file.");
    m.def(
        "web_snapshot",
        [](nb::bytes snapshot, const std::string& expected) {
            return bytes_from(web::unpack_snapshot(view(snapshot), expected));
        },
        "snapshot"_a, "expected"_a, "The state of a snapshot with these facts, in JSON.");
    m.def(
        "web_pack_snapshot",
        [](const std::string& facts, nb::bytes state) { return bytes_from(web::pack_snapshot(facts, view(state))); },
        "facts"_a, "state"_a, "A snapshot.");
    m.def(
        "web_json",
        [](nb::bytes text) { return web::parse_json(web::text_of(view(text)), size_t{1} << 20).canonical(); }, "text"_a,
        "The canonical text of JSON.");
    m.def(
        "web_inflate",
        [](nb::bytes stream, size_t most, bool zlib) {
            return bytes_from(zlib ? web::inflate_zlib(view(stream), most) : web::inflate(view(stream), most));
        },
        "stream"_a, "most"_a, nb::kw_only(), "zlib"_a, "The content of a DEFLATE stream, of at most `most` bytes.");
    m.def(
        "web_deflate",
        [](nb::bytes content, bool zlib) {
            return bytes_from(zlib ? web::deflate_zlib(view(content)) : web::deflate(view(content)));
        },
        "content"_a, nb::kw_only(), "zlib"_a, "A DEFLATE stream.");
    m.def(
        "web_hashes",
        [](nb::bytes data) {
            return std::tuple(web::crc16(view(data)), web::adler32(view(data)), web::hex(web::md5(view(data))),
                              web::hex(web::blake2b(view(data), 16)));
        },
        "data"_a, "CRC-16, Adler-32, MD5 and BLAKE2b of 16 bytes.");
    m.def("web_probability", &web::as_ale_reads, "probability"_a, "The probability that ALE uses.");
}

}  // namespace atari
