// The functions that the page calls. A handle is the address of an object; 0 is an error. A function that can fail returns
// 0, or -1 where 0 has a meaning, and then `error_text` has the sentence. Bytes and texts are returned in one buffer,
// which the next such function replaces.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>
#include <string>
#include <type_traits>

#include "ale/environment_parts.hpp"
#include "hashes.hpp"
#include "replay_player.hpp"
#include "session.hpp"

#ifdef __wasm__
#define EXPORT(name) extern "C" __attribute__((export_name(#name)))
#else
#define EXPORT(name) extern "C"
#endif

namespace atari::web {
namespace {

using SharedGame = std::shared_ptr<const PageGame>;
using SharedReplay = std::shared_ptr<const ReplayContent>;

std::string last_error;
Bytes result;

// Returns the result of a call, or `failed` if it throws.
template <typename Call>
auto guarded(Call&& call, std::type_identity_t<decltype(call())> failed = {}) -> decltype(call()) {
    try {
        return call();
    } catch (const std::bad_alloc&) {
        last_error = "there is not enough memory";
    } catch (const std::exception& error) {
        last_error = error.what();
    }
    return failed;
}

template <typename Call>
int succeeds(Call&& call) {
    return guarded([&] { return call(), 1; });
}

// Keeps the result for the page, and returns its size; 0 is an error.
template <typename Call>
size_t returned(Call&& call) {
    return guarded([&] {
        const auto found = call();
        result.assign(found.begin(), found.end());
        return result.size();
    });
}

std::string text(const uint8_t* data, size_t size) { return std::string(text_of({data, size})); }
int32_t clamped(int64_t value) { return static_cast<int32_t>(std::clamp<int64_t>(value, INT32_MIN, INT32_MAX)); }

}  // namespace

EXPORT(allocate) void* allocate(size_t size) { return std::malloc(size); }
EXPORT(release) void release(void* memory) { std::free(memory); }
EXPORT(result_data) const uint8_t* result_data() { return result.data(); }
EXPORT(error_text) size_t error_text() {
    return returned([] { return last_error; });
}
EXPORT(state_version) int state_version() { return kStateVersion; }
EXPORT(table_format) int table_format() { return kTableFormat; }
EXPORT(md5_of) size_t md5_of(const uint8_t* data, size_t size) {
    return returned([&] { return hex(md5({data, size})); });
}

// Games

EXPORT(game_open)
SharedGame* game_open(const uint8_t* definition, size_t definition_size, const uint8_t* image, size_t image_size) {
    return guarded(
        [&] { return new SharedGame(read_game(text_of({definition, definition_size}), {image, image_size})); });
}
EXPORT(game_close) void game_close(SharedGame* game) { delete game; }

// Sessions

EXPORT(session_open) PlaySession* session_open(const SharedGame* game, const uint8_t* options, size_t size) {
    return guarded([&] { return new PlaySession(*game, read_options(parse_json(text_of({options, size})), **game)); });
}
EXPORT(session_close) void session_close(PlaySession* session) { delete session; }
EXPORT(session_seed) int session_seed(PlaySession* session, uint32_t seed) {
    return succeeds([&] { session->seed(seed); });
}
EXPORT(session_reset) int session_reset(PlaySession* session) {
    return succeeds([&] { session->reset(); });
}
// Returns whether a frame was played; -1 is an error.
EXPORT(session_act) int session_act(PlaySession* session, int first, int second, float strength) {
    return guarded([&] { return int{session->act({first, second}, strength)}; }, -1);
}
EXPORT(session_mode) int session_mode(PlaySession* session, int mode) {
    return succeeds([&] { session->choose(EventKind::kMode, mode); });
}
EXPORT(session_difficulty) int session_difficulty(PlaySession* session, int difficulty) {
    return succeeds([&] { session->choose(EventKind::kDifficulty, difficulty); });
}
EXPORT(session_poke) int session_poke(PlaySession* session, int index, int value) {
    return succeeds([&] { session->poke(index, value); });
}
// Returns the slot of the write; -1 is an error.
EXPORT(session_add_write) int session_add_write(PlaySession* session, const uint8_t* definition, size_t size, int now) {
    return guarded([&] { return session->add_write(text(definition, size), now != 0); }, -1);
}
EXPORT(session_remove_write) int session_remove_write(PlaySession* session, int slot) {
    return succeeds([&] { session->remove_write(static_cast<uint64_t>(slot)); });
}
EXPORT(session_height) int session_height(PlaySession* session) { return session->environment().height(); }
EXPORT(session_screen) void session_screen(PlaySession* session, uint8_t* rgba) { session->screen_rgba(rgba); }
EXPORT(session_screen_ahead)
int session_screen_ahead(PlaySession* session, int first, int second, int frames, uint8_t* rgba) {
    return succeeds([&] { session->screen_ahead({first, second}, frames, rgba); });
}
EXPORT(session_framebuffer) void session_framebuffer(PlaySession* session, uint8_t* indices) {
    session->environment().screen(indices);
}
EXPORT(session_ram) const uint8_t* session_ram(PlaySession* session) { return session->environment().ram(); }
EXPORT(session_audio) const uint8_t* session_audio(PlaySession* session) { return session->environment().audio(); }
// Writes the numbers that core.js names in `FACTS`.
EXPORT(session_facts) void session_facts(PlaySession* session, int32_t* facts) {
    Environment& environment = session->environment();
    const int32_t all[] = {environment.frame_number(),
                           environment.episode_frame_number(),
                           session->game_over(),
                           session->truncated(),
                           environment.mode(),
                           environment.difficulty(),
                           session->reward(0),
                           session->reward(1),
                           environment.lives(0),
                           environment.lives(1),
                           clamped(session->score(0)),
                           clamped(session->score(1)),
                           clamped(static_cast<int64_t>(session->remembered()))};
    std::copy(std::begin(all), std::end(all), facts);
}
// Writes the value of each label, and whether it is visible.
EXPORT(session_labels) void session_labels(PlaySession* session, int32_t* values, uint8_t* visible) {
    session->game().labels.evaluate(session->environment().ram(), 1, values, visible);
}
// Writes for each object whether it is visible, its column and its row; INT32_MIN where it has none.
EXPORT(session_objects) void session_objects(PlaySession* session, int32_t* out) {
    const PageGame& game = session->game();
    const uint8_t* const ram = session->environment().ram();
    const auto is_label = [](const Coordinate& one) { return one.kind == Coordinate::Kind::kLabel; };
    const auto visible = [&](const Coordinate& one) {
        return !is_label(one) || game.labels.visible(static_cast<size_t>(one.number), ram);
    };
    const auto value = [&](const Coordinate& one) {
        if (one.kind == Coordinate::Kind::kNone) return INT32_MIN;
        return is_label(one) ? game.labels.value(static_cast<size_t>(one.number), ram) : one.number;
    };
    for (const auto& [x, y] : game.objects) {
        *out++ = visible(x) && visible(y);
        *out++ = value(x);
        *out++ = value(y);
    }
}
// Returns the byte that gives a label a value; -1 if none does.
EXPORT(session_byte_of) int session_byte_of(PlaySession* session, int label, int32_t value) {
    const Labels& labels = session->game().labels;
    if (label < 0 || static_cast<size_t>(label) >= labels.size()) return -1;
    return labels.byte_of(static_cast<size_t>(label), session->environment().ram(), value);
}
EXPORT(session_snapshot) size_t session_snapshot(PlaySession* session) {
    return returned([&] { return session->snapshot(); });
}
EXPORT(session_restore) int session_restore(PlaySession* session, const uint8_t* data, size_t size) {
    return succeeds([&] { session->restore({data, size}); });
}
EXPORT(session_remember) int session_remember(PlaySession* session) {
    return succeeds([&] { session->remember(); });
}
EXPORT(session_go_back) int session_go_back(PlaySession* session) {
    return guarded([&] { return int{session->go_back()}; }, -1);
}
EXPORT(session_budget) void session_budget(PlaySession* session, size_t bytes) { session->set_budget(bytes); }
EXPORT(session_record) int session_record(PlaySession* session, const uint8_t* package, size_t size) {
    return succeeds([&] { session->start_recording(text(package, size)); });
}
EXPORT(session_replay) size_t session_replay(PlaySession* session) {
    return returned([&] { return session->replay(); });
}

// Replays

EXPORT(replay_open) SharedReplay* replay_open(const uint8_t* data, size_t size) {
    return guarded([&] { return new SharedReplay(std::make_shared<const ReplayContent>(read_replay({data, size}))); });
}
EXPORT(replay_close) void replay_close(SharedReplay* replay) { delete replay; }
EXPORT(replay_header) size_t replay_header(const SharedReplay* replay) {
    return returned([&] { return (*replay)->header_text; });
}
EXPORT(replay_end) size_t replay_end(const SharedReplay* replay) {
    return returned([&] { return (*replay)->end ? (*replay)->end->canonical() : std::string("null"); });
}
EXPORT(replay_frames) uint32_t replay_frames(const SharedReplay* replay) { return (*replay)->frames(); }

EXPORT(player_open) ReplayPlayer* player_open(const SharedGame* game, const SharedReplay* replay) {
    return guarded([&] { return new ReplayPlayer(*game, *replay); });
}
EXPORT(player_close) void player_close(ReplayPlayer* player) { delete player; }
EXPORT(player_session) PlaySession* player_session(ReplayPlayer* player) { return &player->session(); }
EXPORT(player_frame) uint32_t player_frame(const ReplayPlayer* player) { return player->frame(); }
// Returns 0 after a frame, 1 if it needs more time, 2 at the end; -1 is an error.
EXPORT(player_advance) int player_advance(ReplayPlayer* player, int budget) {
    return guarded([&] { return static_cast<int>(player->advance(budget)); }, -1);
}
// Returns 1 if it is there, 0 if it needs more time; -1 is an error.
EXPORT(player_seek) int player_seek(ReplayPlayer* player, uint32_t frame, int budget) {
    return guarded([&] { return int{player->seek(frame, budget)}; }, -1);
}
// Returns the size of the text of what differs first; 0 if nothing does.
EXPORT(player_difference) size_t player_difference(const ReplayPlayer* player) {
    return returned([&] { return player->difference(); });
}
EXPORT(player_differing_frame) uint32_t player_differing_frame(const ReplayPlayer* player) {
    return player->differing_frame();
}
EXPORT(player_action) int player_action(const ReplayPlayer* player, int which) {
    return player->actions()[static_cast<size_t>(which)];
}
EXPORT(player_recorded)
ReplayPlayer* player_recorded(const ReplayPlayer* player, const uint8_t* package, size_t size, uint32_t frame) {
    return guarded([&] { return player->recorded(text(package, size), frame).release(); });
}
// Closes the player, and returns its session.
EXPORT(player_take_session) PlaySession* player_take_session(ReplayPlayer* player) {
    PlaySession* const session = player->take_session().release();
    delete player;
    return session;
}

}  // namespace atari::web
