// The fuzz target of the page's readers (web/core/): JSON, DEFLATE, snapshots, replays and the text of a game, as an input
// describes them. They must not crash, hang, execute undefined behaviour, or throw anything but the two documented
// exceptions. What a reader accepts is written and read again, and a replay is played for some frames.
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <stdexcept>
#include <string>

#include "deflate.hpp"
#include "input.hpp"
#include "json.hpp"
#include "replay_file.hpp"
#include "replay_player.hpp"
#include "seeds.hpp"
#include "snapshot.hpp"

namespace atari {
namespace {

using web::Bytes;
using web::View;

constexpr size_t kMost = 1 << 16;
constexpr int kAdvances = 300;

void expect(bool good, const char* what) {
    if (good) return;
    std::fprintf(stderr, "expected: %s\n", what);
    std::abort();
}

enum class What : uint8_t { kJson, kInflate, kSnapshot, kReplay, kRawReplay, kGame, kWrite, kCount };

// A game whose processor stops at once, so that its frames take little time.
constexpr std::string_view kGame =
    "table 1\nid game\nmodes 0 1\ndifficulties 0\nvariables 4\ninitial\nkept\noutputs 1 3 0 2\nstep 40 0\n"
    "select_mode 40 0\nlabel ball 3 255 0 6 1 0 2 1 40 0 0 6 1 3 2 0 40 0 0\n";

const std::shared_ptr<const web::PageGame>& stopped_game() {
    static const auto game = web::read_game(kGame, Bytes(4096, 0x02));
    return game;
}

std::string header_of_game() {
    return "{\"format\": 1, \"game\": \"game\", \"rom\": \"" + stopped_game()->rom_md5 +
           "\", \"options\": {\"mode\": null, \"repeat_action_probability\": 0.25, \"frameskip\": 4}}";
}

// A chunk of play of events from the input, with hashes from it, whose sizes fit.
Bytes play_chunk(Reader& in, uint32_t& frames) {
    web::PlayChunk play{frames, {}, {}, {}};
    play.short_hashes.assign(in.byte(), static_cast<uint8_t>(in.byte() & 3));
    frames += static_cast<uint32_t>(play.short_hashes.size());
    play.full_hashes.resize(frames / web::kFramesPerFullHash - play.first / web::kFramesPerFullHash);
    const Bytes events = in.chunk();
    play.events = in.byte() & 1 ? events : web::deflate(events);
    return play.payload();
}

Bytes read_file(Reader& in) {
    Bytes file = web::begin_replay(in.byte() & 1 ? header_of_game() : std::string(web::text_of(in.chunk())));
    uint32_t frames = 0;
    while (!in.empty()) {
        const char kind = "PPSWEHQ"[in.byte() % 7];
        web::append_chunk(file, kind, kind == 'P' ? play_chunk(in, frames) : in.chunk());
    }
    return file;
}

void play(const web::ReplayContent& content) {
    web::ReplayPlayer player(stopped_game(), std::make_shared<const web::ReplayContent>(content));
    for (int i = 0; i < kAdvances; ++i)
        if (player.advance(50) == web::ReplayPlayer::Outcome::kEnd) break;
    const uint32_t frame = player.frame();
    player.seek(frame / 2, 1000);
    const auto recorded = player.recorded("1");
    if (!recorded->seek(frame / 2, 3000)) return;
    const Bytes file = recorded->take_session()->replay();
    web::ReplayPlayer again(stopped_game(), std::make_shared<const web::ReplayContent>(web::read_replay(file)));
    for (int i = 0; i < kAdvances; ++i)
        if (again.advance(1000) == web::ReplayPlayer::Outcome::kEnd) {
            expect(again.difference().empty(), "a recording of the page is verified");
            break;
        }
}

void read_replay(View file) {
    const web::ReplayContent content = web::read_replay(file);
    Bytes copy = web::begin_replay(content.header_text);
    for (const web::PlayChunk& chunk : content.plays) {
        const std::vector<web::Event> events = web::unpack_events(chunk.events);
        web::PlayChunk packed = chunk;
        packed.events = web::pack_events(events);
        if (packed.events.size() < kMost) web::append_chunk(copy, 'P', packed.payload());
    }
    if (content.header.canonical().find("\"game\": \"game\"") != std::string::npos) play(content);
    expect(web::read_replay(copy).header_text == content.header_text, "a written replay is read");
}

void read_snapshot(Reader& in) {
    const uint8_t flags = in.byte();
    const Bytes content = in.chunk();
    if (flags & 1) {
        web::unpack_snapshot(content, "{}");
        return;
    }
    const Bytes packed = web::pack_snapshot("{\"game\": \"game\"}", content);
    expect(web::unpack_snapshot(packed, "{\"game\": \"game\"}") == content, "a packed snapshot is unpacked");
    web::PlaySession session(stopped_game(), web::Options{});
    const Bytes before = session.snapshot();
    try {
        session.restore(
            web::pack_snapshot(web::facts_of(session.game(), web::Options{}, session.environment().mode()), content));
    } catch (const web::Refused&) {
        expect(session.snapshot() == before, "a refused snapshot changes nothing");
    }
}

void run(Reader& in) {
    switch (static_cast<What>(in.byte() % static_cast<uint8_t>(What::kCount))) {
        case What::kJson: {
            const Bytes text = in.chunk();
            const std::string canonical = web::parse_json(web::text_of(text)).canonical();
            expect(web::parse_json(canonical).canonical() == canonical, "canonical JSON is JSON");
            return;
        }
        case What::kInflate: {
            const uint8_t flags = in.byte();
            const Bytes data = in.chunk();
            expect(web::inflate(web::deflate(data), data.size()) == data, "deflated bytes are inflated");
            if (flags & 1) web::inflate_zlib(data, kMost);
            else web::inflate(data, kMost);
            return;
        }
        case What::kSnapshot: read_snapshot(in); return;
        case What::kReplay: read_replay(read_file(in)); return;
        case What::kRawReplay: read_replay(in.chunk()); return;
        case What::kGame: {
            const Bytes text = in.chunk();
            std::string all(in.byte() & 1 ? kGame : "");
            all += web::text_of(text);
            const auto game = web::read_game(all, Bytes(in.byte() & 1 ? 4096 : 2048, 0x02));
            uint8_t ram[128]{};
            std::vector<int32_t> values(game->labels.size());
            std::vector<uint8_t> visible(game->labels.size());
            game->labels.evaluate(ram, 1, values.data(), visible.data());
            return;
        }
        default: {
            const Bytes definition = in.chunk();
            web::PlaySession session(stopped_game(), web::Options{});
            session.add_write(std::string(web::text_of(definition)), true);
            session.reset();
            session.act({1, 0});
        }
    }
}

Bytes bytes_of(std::string_view text) { return Bytes(text.begin(), text.end()); }
Writer input(What what) { return std::move(Writer().byte(static_cast<uint8_t>(what))); }

// A chunk of play for `read_file`.
Writer& play_of(Writer& out, uint8_t frames, const Bytes& events) {
    return out.byte(0).byte(frames).byte(0).chunk(events).byte(0);
}

}  // namespace

std::vector<std::pair<std::string, std::vector<uint8_t>>> fuzzing_seeds() {
    std::vector<std::pair<std::string, std::vector<uint8_t>>> seeds;
    const auto add = [&](const char* name, const Writer& input) { seeds.emplace_back(name, input.bytes()); };
    add("json", input(What::kJson).chunk(bytes_of("{\"a\": [1, -2.5e3, null, true], \"b\": \"\\u00e9\\n\"}")));
    add("inflate", input(What::kInflate).byte(0).chunk(web::deflate(bytes_of("abcabcabcabc"))));
    add("inflate_zlib", input(What::kInflate).byte(1).chunk(web::deflate_zlib(bytes_of("abcabcabcabc"))));
    // Dynamic codes, which the writer does not use: zlib's for 200 letters.
    add("inflate_dynamic",
        input(What::kInflate).byte(0).chunk({0x05, 0xc1, 0x01, 0x61, 0x04, 0x41, 0x10, 0x04, 0x21, 0xad, 0x54, 0xcf,
                                             0xed, 0xc7, 0xbf, 0x82, 0x80, 0x4d, 0x1a, 0x33, 0xf2, 0x1d, 0x7d, 0x40,
                                             0xc0, 0xca, 0xdf, 0x51, 0x9f, 0xa5, 0x5b, 0x31, 0x2a, 0x5a, 0xa2, 0x5f,
                                             0xf4, 0x5b, 0xa7, 0x17, 0x3d, 0xdb, 0x6d, 0xc5, 0x25, 0x54, 0xd0, 0x6d,
                                             0xb3, 0x30, 0x42, 0x04, 0x70, 0x69, 0x48, 0xe5, 0x2d, 0x49, 0xbc, 0x73,
                                             0xbe, 0xe1, 0xec, 0xe5, 0x5e, 0x21, 0xa4, 0x7f}));
    add("snapshot", input(What::kSnapshot).byte(0).chunk(Bytes(100, 7)));
    add("raw_snapshot",
        input(What::kSnapshot).byte(1).chunk(web::pack_snapshot("{\"game\": \"game\"}", Bytes(100, 7))));
    Writer replay = input(What::kReplay);
    replay.byte(1);
    play_of(replay, 5, {3, 0x81, 0x80, 0x01, 7, 5});
    play_of(replay, 9, {5, 0x83, 0x02, 0x84, 0x41, 0x82, 6, 0, 3, 0, 0, 0x40, 0x3f, 9, 100});
    add("replay", replay);
    Writer writes = input(What::kReplay);
    writes.byte(1).byte(3).chunk(bytes_of("{\"to\": \"ball\", \"value\": 3, \"when\": \"held\"}"));
    play_of(writes, 4, {5, 0x8a, 0x80, 0x22, 0x8b, 0x03, 0, 1, 2, 0, 2});
    add("writes", writes);
    add("raw_replay", input(What::kRawReplay).chunk(web::begin_replay(header_of_game())));
    add("game", input(What::kGame).chunk(bytes_of(kGame)).byte(0).byte(1));
    add("more_of_a_game",
        input(What::kGame)
            .chunk(bytes_of("object label 0 at 9\nintervention {\"name\": \"x\"}\nwrite 3 255 1 0 0 1 0 1 5 0 6 "
                            "0 9 2 0 40 0 0\ndefinition {}\n"))
            .byte(1)
            .byte(1));
    add("write", input(What::kWrite).chunk(bytes_of("{\"to\": 12, \"value\": 3, \"mask\": 15, \"when\": [0, 4]}")));
    return seeds;
}

}  // namespace atari

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    atari::Reader in(data, size);
    try {
        atari::run(in);
    } catch (const atari::web::Refused&) {
    } catch (const std::invalid_argument&) {  // an invalid program or image
    }
    return 0;
}
