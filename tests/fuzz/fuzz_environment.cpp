// The fuzz target: runs what an input describes, and checks the properties that hold for every input.
//
// An input is a cartridge, the options of a console, and one of two scenarios. One is the bare console, whose frames
// take little time. The other is a whole environment with rules, whose construction alone takes 68 frames. Both end
// with a sequence of steps. Some steps load damaged states. The emulator must not crash, hang, execute undefined
// behaviour, or throw anything but the two documented exceptions. Every input runs on the fast core and on the
// reference core, whose results must be equal. seeds.cpp describes inputs and writes the seeds.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "ale/environment_parts.hpp"
#include "fast/fast_console.hpp"
#include "input.hpp"
#include "observations/resizer.hpp"
#include "observations/pooling.hpp"

namespace atari {
namespace {

using Bytes = std::vector<uint8_t>;

void expect(bool good, const char* what) {
    if (good) return;
    std::fprintf(stderr, "expected: %s\n", what);
    std::abort();
}

// Rejects input that the binding rejects before it reaches the emulator. The run of the input ends.
[[noreturn]] void refuse() { throw std::invalid_argument("the binding rejects this"); }

// Limits that reach every state of interest. With them most inputs take milliseconds.
constexpr int kSteps = 64, kFrames = 6, kActs = 6, kResets = 2;
constexpr size_t kInstructions = 80;  // in a rule program

std::shared_ptr<const FastCartridge> read_cartridge(Reader& in) {
    static const char* const kTypes[] = {"",     "2K", "4K", "F8", "F8 SWAPPED", "F6", "F4", "F8SC", "F6SC", "F4SC",
                                         "FASC", "E0", "E7", "FE", "DPC",        "3F", "3E", "UA",   "CV",   "MB"};
    static constexpr size_t kSizes[] = {0,     2048, 4096,  8192, 10240, 12288, 16384,  32768,
                                        65536, 8448, 10495, 3000, 6144,  10496, 524288, 524289};
    const std::string type = kTypes[in.byte() % std::size(kTypes)];
    const size_t size = kSizes[in.byte() % std::size(kSizes)];
    const uint8_t layout = in.byte(), fill = in.byte();
    const Bytes code = in.chunk();
    if (size == 0) return std::make_shared<const FastCartridge>(code, type);

    // Repeats the code every `every` bytes. If the layout says so, each KiB ends with a vector to the code.
    const size_t every = size_t{1024} << (layout & 7);
    Bytes image(size, fill);
    for (size_t at = 0; at < size; at += every)
        std::copy_n(code.begin(), std::min({code.size(), every, size - at}),
                    image.begin() + static_cast<ptrdiff_t>(at));
    if (layout & 8)
        for (size_t at = 1020; at < size; at += 1024)
            for (size_t k = 0; k < 4; ++k) image[at + k] = k & 1 ? 0xf0 : 0x00;
    return std::make_shared<const FastCartridge>(image, type);
}

ConsoleConfig read_config(Reader& in) {
    ConsoleConfig config;
    const uint8_t flags = in.byte();
    config.pal = flags & 1;
    config.hmove_blanks = flags & 2;
    config.paddles[0] = flags & 4;
    config.paddles[1] = flags & 8;
    config.swap_ports = flags & 16;
    config.swap_paddles = flags & 32;
    config.first_line = in.number();
    config.height = in.number();
    return config;
}

// Reads a rule program. A repaired program gets constants where the stack would be too shallow.
Program read_program(Reader& in, int variables, bool may_act, bool& presses) {
    std::vector<int32_t> words;
    const bool repaired = in.byte() & 1;
    const size_t count = std::min<size_t>(in.byte(), kInstructions);
    for (size_t i = 0; i < count; ++i) {
        const auto op = static_cast<Op>(in.byte() % (kOpCount + 1));  // one operation more than exist
        const int32_t argument = in.number();
        if (repaired && op > Op::kXram && op < Op::kJump)
            for (int k = 0; k < 2; ++k) words.insert(words.end(), {static_cast<int32_t>(Op::kPush), argument});
        words.insert(words.end(), {static_cast<int32_t>(op), argument});
        presses |= op >= Op::kPressSelect && op <= Op::kFail;
    }
    if (repaired) words.insert(words.end(), {static_cast<int32_t>(Op::kEnd), 0});
    return Program(words, variables, may_act);
}

std::shared_ptr<Game> read_game(Reader& in) {
    auto game = std::make_shared<Game>();
    game->cartridge = read_cartridge(in);
    game->console = read_config(in);
    const uint8_t flags = in.byte();
    game->palette = flags & 1 ? &PAL : flags & 2 ? &SECAM : &NTSC;
    game->detect_format = flags & 4;
    game->power_on_switches = in.byte();
    if (flags & 8) {
        game->paddle_min = in.number();
        game->paddle_max = in.number();
    }
    if (flags & 16) game->legal_actions = static_cast<uint32_t>(in.number());
    game->default_mode = in.number();
    game->variables = in.number();
    for (int i = in.byte() & 7; i > 0; --i) {
        game->initial.push_back(in.number());
        game->kept.push_back(in.byte() & 1);
    }
    for (int i = in.byte() & 3; i > 0; --i) game->starting_actions.push_back(in.number());
    if (flags & 32) {
        for (int* variable : {&game->rewards[0], &game->terminal, &game->lives[0], &game->mode_variable})
            *variable = in.number();
    }
    bool presses = false;
    game->step = read_program(in, game->variables, false, presses);
    game->select_mode = read_program(in, game->variables, true, presses);
    game->check();
    // Selecting a mode may take 20000 frames, or minutes for an input. The image therefore stops the processor at once.
    if (presses) game->cartridge = std::make_shared<const FastCartridge>(Bytes(4096, 0x02), "4K");
    return game;
}

Settings read_settings(Reader& in) {
    Settings settings;
    const uint8_t flags = in.byte();
    settings.sound = flags & 1;
    settings.color_averaging = flags & 2;
    settings.frame_skip = 1 + (flags >> 2 & 3);
    settings.repeat_action_probability = in.byte() / 255.0;
    settings.max_frames_per_episode = in.number();
    return settings;
}

template <typename Saved>
Bytes saved(Saved& from) {
    Bytes state(from.state_size());
    from.save(state.data());
    return state;
}

// Returns a state with some bytes replaced, or made from bytes of the input. Most bytes of a state are framebuffers and
// random words, which are harmless; `parts` are the offsets of the other parts.
constexpr size_t kNumbers = offsetof(EnvironmentState, paddle) - sizeof(uint32_t);
Bytes damaged(Reader& in, Bytes state, std::initializer_list<size_t> parts) {
    const uint8_t flags = in.byte();
    if (flags & 0x80) {
        const Bytes pattern = in.chunk();
        for (size_t i = 0; i < state.size() && !pattern.empty(); ++i) state[i] = pattern[i % pattern.size()];
    }
    for (int i = flags & 7; i >= 0; --i) {
        const uint8_t place = in.byte();
        const size_t part = parts.begin()[place / 2 % parts.size()];
        const size_t at = (part + static_cast<uint32_t>(in.number())) % state.size();
        const auto value = static_cast<uint32_t>(in.number());
        const size_t width = place & 1 ? 1 : 4;
        for (size_t k = 0; k < width && at + k < state.size(); ++k)
            state[at + k] = static_cast<uint8_t>(value >> (8 * k));
    }
    // A reset may skip up to 2^32 random words. That takes two seconds, but minutes with sanitizers.
    uint8_t* const words_field = state.data() + *parts.begin() + offsetof(Machine, random_words);
    uint64_t words;
    std::memcpy(&words, words_field, sizeof words);
    if (words < MachineRandom::kFurthest) words &= 0xfffff;
    std::memcpy(words_field, &words, sizeof words);
    return state;
}

// Loads a state. `load` must take all of it or nothing, and a taken state must be saved as the same bytes.
template <typename Saved>
bool offer(Saved& to, const Bytes& state) {
    const Bytes before = saved(to);
    const bool taken = to.load(state.data());
    expect(saved(to) == (taken ? state : before), "load takes all of a state or nothing");
    return taken;
}

// A machine on the fast core and one on the reference core. Both get the same calls and must give the same results.
template <typename Machines>
struct Twins {
    Machines &fast, &plain;
    bool comparable = true;  // no state that a machine could not have saved has been taken since the last reset

    void alike(bool same, const char* what) const { expect(same || !comparable, what); }

    // Compares whole states. The fast core must render all deferred frames and find all deferred collisions for this.
    void compare_states() const { alike(saved(fast) == saved(plain), "the whole states of fast and plain are equal"); }

    // Each machine continues from the state that the other has saved.
    void change_places() const {
        const Bytes state = saved(fast), other = saved(plain);
        alike(state == other, "fast and plain save the same");
        expect(offer(plain, state) && offer(fast, other), "load takes what save made");
    }

    void damage(Reader& in, std::initializer_list<size_t> parts) {
        const Bytes state = damaged(in, saved(plain), parts);
        const bool taken = offer(plain, state);
        expect(offer(fast, state) == taken, "fast and plain take the same states");
        if (taken) comparable = false;
    }
};

// Compares the state that needs neither deferred rendering nor deferred collisions.
void compare_quickly(const Twins<Console>& twins) {
    const auto equal = [](const auto& a, const auto& b) { return std::memcmp(&a, &b, sizeof a) == 0; };
    const Machine &a = twins.fast.machine(), &b = twins.plain.machine();
    const bool same =
        a.cycles == b.cycles && equal(a.cpu, b.cpu) && equal(a.riot, b.riot) && equal(a.tia.pos, b.tia.pos) &&
        a.tia.write_pos == b.tia.write_pos && a.tia.current_line == b.tia.current_line &&
        std::equal(twins.fast.cartridge_ram(), twins.fast.cartridge_ram() + twins.fast.cartridge_ram_size(),
                   twins.plain.cartridge_ram());
    twins.alike(same, "fast and plain frames end alike");
}

void press(Reader& in, Inputs& inputs) {
    inputs.switches = in.byte();
    for (uint8_t& stick : inputs.stick) stick = in.byte() & 15;
    const uint8_t fire = in.byte();
    for (int i = 0; i < 2; ++i) inputs.fire[i] = fire >> i & 1;
    for (int i = 0; i < 4; ++i) inputs.paddle_fire[i] = fire >> (2 + i) & 1;
    for (int32_t& resistance : inputs.resistance) resistance = in.number() & 0xffffff;
}

void play_console(Reader& in) {
    Game game;
    game.cartridge = read_cartridge(in);
    game.console = read_config(in);
    game.check();
    FastConsole fast(game.cartridge, game.console);
    Console plain(game.cartridge, game.console);
    Twins<Console> twins{fast, plain};
    const auto both = [&](auto&& work) {
        work(fast);
        work(plain);
    };
    both([](Console& console) {
        console.construct();
        console.reset();
    });
    Bytes samples(kAudioSamples), others(kAudioSamples);
    int frames = 0;
    for (int steps = 0; steps < kSteps && !in.empty(); ++steps) {
        const auto step = static_cast<ConsoleStep>(in.byte() % static_cast<int>(ConsoleStep::kCount));
        // The next steps run single instructions or accesses, in which nothing is deferred.
        if (step == ConsoleStep::kInstructions || step == ConsoleStep::kRead || step == ConsoleStep::kWrite)
            expect(offer(fast, saved(fast)), "load takes what save made");
        switch (step) {
            case ConsoleStep::kFrame:
                if (++frames > kFrames) return;
                both([](Console& console) { console.run_frame(); });
                compare_quickly(twins);
                break;
            case ConsoleStep::kInstructions: {
                const int count = in.byte();
                both([&](Console& console) {
                    for (int i = count; i > 0; --i) console.run_instruction();
                });
                break;
            }
            case ConsoleStep::kPress:
                press(in, fast.inputs());
                plain.inputs() = fast.inputs();
                break;
            case ConsoleStep::kLook: {
                const size_t shown = static_cast<size_t>(game.console.height) * kScreenWidth;
                twins.alike(std::equal(fast.framebuffer(), fast.framebuffer() + shown, plain.framebuffer()),
                            "fast and plain framebuffers are equal");
                break;
            }
            case ConsoleStep::kCompare: twins.compare_states(); break;
            case ConsoleStep::kChangePlaces: twins.change_places(); break;
            case ConsoleStep::kDamage: twins.damage(in, {0, 200}); break;
            case ConsoleStep::kReset:
                both([](Console& console) { console.reset(); });
                twins.comparable = true;
                break;
            case ConsoleStep::kSamples:
                fast.make_samples(samples.data());
                plain.make_samples(others.data());
                twins.alike(samples == others, "fast and plain sound are equal");
                break;
            case ConsoleStep::kRead: {
                const uint16_t address = in.word();
                both([&](Console& console) { console.read(address); });
                break;
            }
            case ConsoleStep::kWrite: {
                const uint16_t address = in.word();
                const uint8_t value = in.byte();
                both([&](Console& console) { console.write(address, value); });
                break;
            }
            case ConsoleStep::kCount: break;
        }
    }
}

// Checks that pooling and resizing give the same at every SIMD level of this processor, and read and write nothing
// after the last pixel. The frame decides to which size it is resized.
void scale(const Bytes& indices, int rows, const uint8_t* table) {
    size_t number = 0;
    for (const uint8_t index : indices) number = 31 * number + index;
    const size_t height = number / kScreenWidth % static_cast<size_t>(rows) + 1, width = number % kScreenWidth + 1;
    Bytes expected;
    for (SimdLevel level : {SimdLevel::kScalar, SimdLevel::kSimd128, SimdLevel::kAvx2, SimdLevel::kAvx512}) {
        if (level > best_simd_level()) break;
        Bytes pooled(indices.size()), small(height * width), whole(height * width);
        std::vector<uint32_t> changes(static_cast<size_t>(rows));
        pool_gray(indices.data(), indices.data(), rows, table, pooled.data(), changes.data(), level);
        const Resizer resize(rows, static_cast<int>(height), static_cast<int>(width), level);
        resize(pooled.data(), changes.data(), small.data());
        resize(pooled.data(), nullptr, whole.data());
        expect(small == whole, "what does not change need not be looked at");
        if (level == SimdLevel::kScalar) expected = small;
        expect(small == expected, "framebuffers are resized alike at every SIMD level");
    }
}

// Returns all screens, written to memory of exactly their sizes. Colours and greys must be those of the indices.
Bytes look(Environment& environment) {
    const size_t pixels = static_cast<size_t>(environment.height()) * kScreenWidth;
    Bytes indices(pixels), rgb(3 * pixels), gray(pixels);
    environment.screen(indices.data());
    environment.screen_rgb(rgb.data());
    environment.screen_gray(gray.data());
    const Palette& palette = *environment.parts().game->palette;
    for (size_t i = 0; i < pixels; ++i) {
        const uint32_t colour = uint32_t{rgb[3 * i]} << 16 | uint32_t{rgb[3 * i + 1]} << 8 | rgb[3 * i + 2];
        if (palette.rgb[indices[i]] != colour || palette.gray[indices[i]] != gray[i])
            expect(false, "framebuffers agree");
    }
    scale(indices, environment.height(), palette.gray);
    return indices;
}

int act(int action, float strength, Environment& environment, const Settings& settings) {
    const auto before = static_cast<uint32_t>(environment.frame_number());
    const bool over = environment.game_over() || environment.truncated();
    const int reward = environment.act({action}, 1, strength)[0];
    const uint32_t played = static_cast<uint32_t>(environment.frame_number()) - before;
    expect(played <= static_cast<uint32_t>(settings.frame_skip) && !(over && played),
           "an act plays up to frame_skip frames");
    return reward;
}

// Compares the state that does not need deferred rendering.
void compare_quickly(const Twins<Environment>& twins) {
    const Environment &a = twins.fast, &b = twins.plain;
    twins.alike(std::equal(a.ram(), a.ram() + 128, b.ram()), "fast and plain RAM are equal");
    twins.alike(std::equal(a.audio(), a.audio() + kAudioSamples, b.audio()), "fast and plain sound are equal");
    twins.alike(a.lives() == b.lives() && a.game_over() == b.game_over() && a.truncated() == b.truncated() &&
                    a.frame_number() == b.frame_number() && a.episode_frame_number() == b.episode_frame_number(),
                "fast and plain rules and counters are equal");
}

void play_environment(Reader& in) {
    const std::shared_ptr<const Game> game = read_game(in);
    const Settings settings = read_settings(in);
    Settings plainly = settings;
    plainly.plain = true;
    const auto seed = static_cast<uint32_t>(in.number());
    Environment fast(game, settings, seed), plain(game, plainly, seed);
    Twins<Environment> twins{fast, plain};
    const auto both = [&](auto&& work) {
        work(fast);
        work(plain);
        compare_quickly(twins);
    };
    const size_t machine = sizeof(EnvironmentState);
    std::optional<EnvironmentSnapshot> fast_snapshot, plain_snapshot;
    int acts = 0, resets = 0;
    for (int steps = 0; steps < kSteps && !in.empty(); ++steps) {
        switch (static_cast<EnvironmentStep>(in.byte() % static_cast<int>(EnvironmentStep::kCount))) {
            case EnvironmentStep::kAct: {
                if (++acts > kActs) return;
                const int action = in.byte() % 18;
                const float strength = static_cast<float>(in.number()) / 16.0f;
                if (!(std::abs(strength) <= 1000.0f)) refuse();
                int rewards[2], *reward = rewards;
                both([&](Environment& environment) { *reward++ = act(action, strength, environment, settings); });
                twins.alike(rewards[0] == rewards[1], "fast and plain rewards are equal");
                break;
            }
            case EnvironmentStep::kReset:
                if (++resets > kResets) return;
                both([](Environment& environment) { environment.reset(); });
                break;
            case EnvironmentStep::kLook:
                twins.alike(look(fast) == look(plain), "fast and plain framebuffers are equal");
                break;
            case EnvironmentStep::kCompare: twins.compare_states(); break;
            case EnvironmentStep::kChangePlaces: twins.change_places(); break;
            case EnvironmentStep::kRestore:  // the snapshot that the last step of this kind took
                if (!twins.comparable) break;
                if (fast_snapshot) {
                    expect(fast.restore(*fast_snapshot) && plain.restore(*plain_snapshot), "a snapshot is restored");
                    expect(!plain.restore(*fast_snapshot), "a snapshot of another kind of console is refused");
                }
                fast_snapshot = fast.snapshot();
                plain_snapshot = plain.snapshot();
                break;
            case EnvironmentStep::kDamage: twins.damage(in, {machine, machine + 200, kNumbers}); break;
            case EnvironmentStep::kSeed: {  // the result is that of a new environment with that seed
                if (++resets > kResets) return;
                const auto other = static_cast<uint32_t>(in.number());
                twins.comparable = true;
                both([&](Environment& environment) {
                    environment.set_mode(game->default_mode);
                    environment.set_difficulty(0);
                    environment.seed(other);
                });
                Environment made(game, settings, other);
                expect(saved(fast) == saved(made), "a seed starts over");
                break;
            }
            case EnvironmentStep::kSetRam: {
                const int index = in.byte() & 127, value = in.byte();
                both([&](Environment& environment) { environment.set_ram(index, value); });
                expect(fast.ram()[index] == value, "RAM holds what was set");
                break;
            }
            case EnvironmentStep::kMode: {
                const int mode = in.number();
                both([&](Environment& environment) { environment.set_mode(mode); });
                break;
            }
            case EnvironmentStep::kDifficulty: {
                const int difficulty = in.number();
                both([&](Environment& environment) { environment.set_difficulty(difficulty); });
                break;
            }
            case EnvironmentStep::kCount: break;
        }
    }
}

}  // namespace
}  // namespace atari

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    atari::Reader in(data, size);
    try {
        if (in.byte() & 1) atari::play_environment(in);
        else atari::play_console(in);
    } catch (const std::invalid_argument&) {  // an invalid image, game or program
    } catch (const std::runtime_error&) {     // a mode that cannot be selected
    }
    return 0;
}
