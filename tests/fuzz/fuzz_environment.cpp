// The fuzz target: plays what an input says, and checks what must hold whatever it says.
//
// An input is a cartridge, the options of a console, and then one of two scenarios: the bare console, whose frames are
// cheap, or a whole environment with rules, where a construction alone takes 68 frames. Both end with a row of steps,
// among them snapshots that were damaged. Nothing may crash, hang, leave defined behaviour, or throw anything but the
// two documented exceptions. Inputs are described in seeds.cpp, which writes the ones to start from.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "environment.hpp"
#include "input.hpp"

namespace atari {
namespace {

using Bytes = std::vector<uint8_t>;

void expect(bool good, const char* what) {
    if (good) return;
    std::fprintf(stderr, "expected: %s\n", what);
    std::abort();
}

// Refuses what the binding refuses before it reaches the emulator; here a refused input is simply over.
[[noreturn]] void refuse() { throw std::invalid_argument("refused at the door"); }

// Enough to reach every state of interest, and few enough that most inputs take milliseconds.
constexpr int kSteps = 64, kFrames = 6, kActs = 6, kResets = 2;
constexpr size_t kInstructions = 80;  // of a rule program

std::shared_ptr<const Cartridge> read_cartridge(Reader& in) {
    static const char* const kTypes[] = {"",     "2K",   "4K",   "F8", "F8 SWAPPED", "F6", "F4",  "F8SC", "F6SC", "F4SC",
                                         "FASC", "E0", "E7", "FE", "DPC",        "3F", "3E",  "UA",   "CV",   "MB"};
    static constexpr size_t kSizes[] = {0,     2048,  4096,  8192,  10240, 12288,  16384,  32768,
                                        65536, 8448, 10495, 3000, 6144,  10496, 524288, 524289};
    const std::string type = kTypes[in.byte() % std::size(kTypes)];
    const size_t size = kSizes[in.byte() % std::size(kSizes)];
    const uint8_t layout = in.byte(), fill = in.byte();
    const Bytes code = in.chunk();
    if (size == 0) return std::make_shared<const Cartridge>(code, type);

    // The code at the beginning of every so many bytes, and a vector that starts it at the end of every KiB.
    const size_t every = size_t{1024} << (layout & 7);
    Bytes image(size, fill);
    for (size_t at = 0; at < size; at += every)
        std::copy_n(code.begin(), std::min({code.size(), every, size - at}), image.begin() + static_cast<ptrdiff_t>(at));
    if (layout & 8)
        for (size_t at = 1020; at < size; at += 1024)
            for (size_t k = 0; k < 4; ++k) image[at + k] = k & 1 ? 0xf0 : 0x00;
    return std::make_shared<const Cartridge>(image, type);
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

// A rule program as it stands in the input, or with constants put in where the stack would be too shallow.
Program read_program(Reader& in, int variables, bool may_act, bool& presses) {
    std::vector<int32_t> words;
    const bool repaired = in.byte() & 1;
    const size_t count = std::min<size_t>(in.byte(), kInstructions);
    for (size_t i = 0; i < count; ++i) {
        const auto op = static_cast<Op>(in.byte() % (kOpCount + 1));  // one of them does not exist
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
        for (int* variable : {&game->reward, &game->terminal, &game->lives, &game->mode_variable}) *variable = in.number();
    }
    bool presses = false;
    game->step = read_program(in, game->variables, false, presses);
    game->select_mode = read_program(in, game->variables, true, presses);
    game->check();
    // Selecting a mode may take 20000 frames: of a game whose processor stops at once, or an input takes minutes.
    if (presses) game->cartridge = std::make_shared<const Cartridge>(Bytes(4096, 0x02), "4K");
    return game;
}

Settings read_settings(Reader& in) {
    Settings settings;
    const uint8_t flags = in.byte();
    settings.sound = flags & 1;
    settings.colour_averaging = flags & 2;
    settings.frame_skip = 1 + (flags >> 2 & 3);
    settings.repeat_action_probability = in.byte() / 255.0;
    settings.max_frames_per_episode = in.number();
    return settings;
}

template <typename Saved>
Bytes saved(const Saved& from) {
    Bytes state(from.state_size());
    from.save(state.data());
    return state;
}

// A state with some of its bytes replaced, or made of bytes of the input altogether. Pictures and random words are most
// of a state and harmless; `parts` are where the rest begins.
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
        for (size_t k = 0; k < width && at + k < state.size(); ++k) state[at + k] = static_cast<uint8_t>(value >> (8 * k));
    }
    // Up to 2^32 random words may be skipped in a reset: two seconds, but minutes under sanitizers.
    uint8_t* const words_field = state.data() + *parts.begin() + offsetof(Machine, random_words);
    uint64_t words;
    std::memcpy(&words, words_field, sizeof words);
    if (words < MachineRandom::kFurthest) words &= 0xfffff;
    std::memcpy(words_field, &words, sizeof words);
    return state;
}

// A state is taken as a whole or not at all, and what was taken is what is saved again.
template <typename Saved>
bool offer(Saved& to, const Bytes& state) {
    const Bytes before = saved(to);
    const bool taken = to.load(state.data());
    expect(saved(to) == (taken ? state : before), "load takes all of a state or nothing");
    return taken;
}

template <typename Saved>
void save_and_load(Saved& from) {
    expect(offer(from, saved(from)), "load takes what save made");
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
    Console console(game.cartridge, game.console), other(game.cartridge, game.console);
    console.construct();
    console.reset();
    Bytes samples(kAudioSamples);
    int frames = 0;
    for (int steps = 0; steps < kSteps && !in.empty(); ++steps) {
        switch (static_cast<ConsoleStep>(in.byte() % static_cast<int>(ConsoleStep::kCount))) {
            case ConsoleStep::kFrame:
                if (++frames > kFrames) return;
                console.run_frame();
                break;
            case ConsoleStep::kInstructions:
                for (int i = in.byte(); i > 0; --i) console.run_instruction();
                break;
            case ConsoleStep::kPress: press(in, console.inputs()); break;
            case ConsoleStep::kSaveAndLoad: save_and_load(console); break;
            case ConsoleStep::kDamage: offer(console, damaged(in, saved(console), {0, 200})); break;
            case ConsoleStep::kReset: console.reset(); break;
            case ConsoleStep::kSamples: console.make_samples(samples.data()); break;
            case ConsoleStep::kRead: console.read(in.word()); break;
            case ConsoleStep::kWrite: {
                const uint16_t address = in.word();
                console.write(address, in.byte());
                break;
            }
            case ConsoleStep::kTwin:  // another console goes on from the same state in the same way
                if (++frames > kFrames) return;
                expect(other.load(saved(console).data()), "load takes what another console saved");
                console.run_frame();
                other.run_frame();
                expect(saved(console) == saved(other), "equal states have equal next frames");
                break;
            case ConsoleStep::kCount: break;
        }
    }
}

// All pictures, into memory of exactly their sizes; colours and greys are those of the indices.
void look(const Environment& environment) {
    const size_t pixels = static_cast<size_t>(environment.height()) * kScreenWidth;
    Bytes indices(pixels), rgb(3 * pixels), gray(pixels);
    environment.screen(indices.data());
    environment.screen_rgb(rgb.data());
    environment.screen_gray(gray.data());
    const Palette& palette = *environment.game()->palette;
    for (size_t i = 0; i < pixels; ++i) {
        const uint32_t colour = uint32_t{rgb[3 * i]} << 16 | uint32_t{rgb[3 * i + 1]} << 8 | rgb[3 * i + 2];
        if (palette.rgb[indices[i]] != colour || palette.gray[indices[i]] != gray[i]) expect(false, "pictures agree");
    }
}

void act(Reader& in, Environment& environment, const Settings& settings) {
    const auto before = static_cast<uint32_t>(environment.frame_number());
    const int action = in.byte() % 18;
    const float strength = static_cast<float>(in.number()) / 16.0f;
    if (!(std::abs(strength) <= 1000.0f)) refuse();
    const bool over = environment.game_over() || environment.truncated();
    environment.act(action, strength);
    const uint32_t played = static_cast<uint32_t>(environment.frame_number()) - before;
    expect(played <= static_cast<uint32_t>(settings.frame_skip) && !(over && played), "an act plays up to frame_skip frames");
}

void play_environment(Reader& in) {
    const std::shared_ptr<const Game> game = read_game(in);
    const Settings settings = read_settings(in);
    Environment environment(game, settings, static_cast<uint32_t>(in.number()));
    const size_t machine = sizeof(EnvironmentState);
    int acts = 0, resets = 0;
    for (int steps = 0; steps < kSteps && !in.empty(); ++steps) {
        switch (static_cast<EnvironmentStep>(in.byte() % static_cast<int>(EnvironmentStep::kCount))) {
            case EnvironmentStep::kAct:
                if (++acts > kActs) return;
                act(in, environment, settings);
                break;
            case EnvironmentStep::kReset:
                if (++resets > kResets) return;
                environment.reset();
                break;
            case EnvironmentStep::kLook: look(environment); break;
            case EnvironmentStep::kSaveAndLoad: save_and_load(environment); break;
            case EnvironmentStep::kDamage:
                offer(environment, damaged(in, saved(environment), {machine, machine + 200, kNumbers}));
                break;
            case EnvironmentStep::kSeed: {  // the same as a new environment with that seed
                if (++resets > kResets) return;
                const auto seed = static_cast<uint32_t>(in.number());
                environment.set_mode(game->default_mode);
                environment.set_difficulty(0);
                environment.seed(seed);
                expect(saved(environment) == saved(Environment(game, settings, seed)), "a seed starts over");
                break;
            }
            case EnvironmentStep::kSetRam: {
                const int index = in.byte() & 127, value = in.byte();
                environment.set_ram(index, value);
                expect(environment.ram()[index] == value, "RAM holds what was set");
                break;
            }
            case EnvironmentStep::kMode: environment.set_mode(in.number()); break;
            case EnvironmentStep::kDifficulty: environment.set_difficulty(in.number()); break;
            case EnvironmentStep::kTwin: {  // a copy goes on in the same way
                if (++acts > kActs) return;
                Environment other(environment);
                const Reader same = in;
                act(in, environment, settings);
                Reader again = same;
                act(again, other, settings);
                expect(saved(environment) == saved(other), "equal states have equal next frames");
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
        if (in.byte() & 1)
            atari::play_environment(in);
        else
            atari::play_console(in);
    } catch (const std::invalid_argument&) {  // an unsound image, game or program
    } catch (const std::runtime_error&) {     // a mode that cannot be selected
    }
    return 0;
}
