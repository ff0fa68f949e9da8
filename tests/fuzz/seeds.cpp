// The seeds: small programs on every cartridge type, rules that use every operation, and all steps.
//
// An input, in order. Cartridge: type, size, layout, fill, code. Console: flags, first line, height.
// Only for an environment: flags, switches, [paddles' range], [legal actions], default mode, variables, start values,
// starting actions, [outputs], two programs; settings: flags, probability, most frames; the seed.
// Then steps to the end. fuzz_environment.cpp reads all this.
#include "seeds.hpp"

#include <cstddef>
#include <functional>

#include "ale/environment_parts.hpp"
#include "input.hpp"

namespace atari {
namespace {

using Bytes = std::vector<uint8_t>;
using Step = ConsoleStep;
using Act = EnvironmentStep;

constexpr uint8_t kTypes = 20;                                // number of types; the first means detection
constexpr uint8_t k2K = 1, k4K = 2, k64K = 8, kDpcSize = 10;  // sizes, by their number
constexpr uint8_t kWhole = 2, kVectors = 8;  // layouts: the code once in each 4 KiB; vectors to the code

// A frame of three lines and few instructions: VSYNC on, then off, and a counter in RAM.
const Bytes kShort = {0xa9, 0x02, 0x85, 0x00, 0x85, 0x02, 0x85, 0x02, 0x85, 0x02, 0xa9, 0x00, 0x85, 0x00,
                      0xe6, 0x80, 0xf8, 0xa5, 0x81, 0x69, 0x01, 0x85, 0x81, 0xd8, 0x4c, 0x00, 0xf0};

// A full frame. In each line, colours, graphics, positions and motions change with the line's number, and collisions
// and paddles are read.
const Bytes kFullFrame = {
    0xa9, 0x02, 0x85, 0x00, 0x85, 0x02, 0x85, 0x02, 0x85, 0x02, 0xa9, 0x00, 0x85, 0x00,        // vertical sync
    0xa9, 0x82, 0x85, 0x01, 0xa2, 0x20, 0x85, 0x02, 0xca, 0xd0, 0xfb, 0xa9, 0x00, 0x85, 0x01,  // blank, paddles dumped
    0xa9, 0x35, 0x85, 0x04, 0x85, 0x0a, 0xa9, 0x27, 0x85, 0x05, 0xa9, 0x02, 0x85, 0x1d, 0x85, 0x1e, 0x85,
    0x1f, 0xa2, 0xd2,  // 210 lines:
    0x85, 0x02, 0x85, 0x2a, 0x86, 0x09, 0x86, 0x08, 0x86, 0x1b, 0x86, 0x1c, 0x86, 0x0d, 0x86, 0x0e, 0x86,
    0x0f, 0x86, 0x20, 0x86, 0x21, 0x86, 0x22, 0x86, 0x24, 0x8a, 0x29, 0x3f, 0x49, 0x11, 0xd0, 0x06, 0x85,
    0x10, 0x85, 0x11, 0x85, 0x12, 0xa5, 0x02, 0x05, 0x07, 0x85, 0x90, 0xa5, 0x08, 0x85, 0x91, 0x86, 0x28,
    0xca, 0xd0, 0xc9, 0x85, 0x2c, 0xad, 0x80, 0x02, 0x85, 0x92, 0xad, 0x84, 0x02, 0x85, 0x93, 0xa9, 0x40,
    0x8d, 0x96, 0x02, 0x86, 0x15, 0xe6, 0x80, 0xa5, 0x80, 0x85, 0x17, 0x85, 0x19, 0x4c, 0x00, 0xf0};

// The starfield of Cosmic Ark: missile 0 loses its motion 21 cycles after HMOVE, and wanders through a hundred lines.
const Bytes kStarfield = {0xa9, 0x02, 0x85, 0x00, 0x85, 0x02, 0x85, 0x02, 0x85, 0x02, 0xa9, 0x00, 0x85, 0x00,
                          0xa2, 0x28, 0x85, 0x02, 0xca, 0xd0, 0xfb, 0xa9, 0x70, 0x85, 0x22, 0xa9, 0x02, 0x85,
                          0x1d, 0x85, 0x02, 0x85, 0x2a, 0xa9, 0x60, 0xea, 0xea, 0xea, 0xea, 0xea, 0xea, 0xea,
                          0xea, 0x85, 0x22, 0xa2, 0x64, 0x85, 0x02, 0xca, 0xd0, 0xfb, 0x4c, 0x00, 0xf0};

// Reads, writes and read-modify-writes all over the window, where hotspots, cartridge RAM and DPC registers are.
const Bytes kHotspots = {0xa2, 0x00, 0xbd, 0x00, 0x10, 0x9d, 0x00, 0x11, 0xfe, 0xf0, 0x1f, 0x9d,
                         0xe0, 0x1f, 0xbd, 0xe0, 0x1f, 0x86, 0x3f, 0x86, 0x3e, 0xbd, 0x00, 0x14,
                         0x9d, 0x00, 0x18, 0xbd, 0x00, 0x19, 0x8d, 0x20, 0x02, 0xad, 0x40, 0x02,
                         0x9d, 0x40, 0x10, 0x9d, 0x70, 0x10, 0xe8, 0xd0, 0xd7, 0x4c, 0x00, 0xf0};

// Every opcode once, in the order of their numbers, each with operands of 0x81.
Bytes all_opcodes() {
    Bytes code;
    for (int opcode = 0; opcode < 256; ++opcode) {
        const bool jams = (opcode & 0x1f) == 0x12 || (opcode & 0x9f) == 0x02;
        const bool leaves =
            opcode == 0x00 || opcode == 0x20 || opcode == 0x40 || opcode == 0x60 || (opcode & 0xdf) == 0x4c;
        if (!jams && !leaves && (opcode & 0x1f) != 0x10)
            code.insert(code.end(), {static_cast<uint8_t>(opcode), 0x81, 0x81});
    }
    return code;
}

Bytes noise(size_t size, uint32_t state) {
    Bytes bytes(size);
    for (uint8_t& byte : bytes) byte = static_cast<uint8_t>((state = 1664525 * state + 1013904223) >> 24);
    return bytes;
}

Writer& step(Writer& to, ConsoleStep which) { return to.byte(static_cast<uint8_t>(which)); }
Writer& step(Writer& to, EnvironmentStep which) { return to.byte(static_cast<uint8_t>(which)); }

void cartridge(Writer& to, int type, uint8_t size, uint8_t layout, const Bytes& code) {
    to.byte(static_cast<uint8_t>(type)).byte(size).byte(layout).byte(0xea).chunk(code);
}

Writer console(int type, uint8_t size, const Bytes& code, uint8_t config = 2, int first_line = 34) {
    Writer to;
    to.byte(0);
    cartridge(to, type, size, kWhole | kVectors, code);
    return to.byte(config).number(first_line).number(210);
}

// All registers of the DPC, written and read.
Bytes dpc_steps() {
    Writer to = console(14, k64K, kHotspots);
    for (uint16_t offset = 0; offset < 0x80; offset += 3) {
        step(to, offset % 2 ? Step::kWrite : Step::kRead).word(0x1000u + (offset % 2 ? 0x40 + offset / 2 : offset / 2));
        if (offset % 2) to.byte(0x17);
    }
    return step(to, Step::kFrame).bytes();
}

struct Patch {
    size_t offset;
    int32_t value;
};

// Sets four-byte numbers of the machine, or of the environment's own state from its first number on.
constexpr int kMachine = 0, kOwn = 2;

template <typename Which>
Writer& damage(Writer& to, Which which, std::initializer_list<Patch> patches, int part = kMachine) {
    step(to, which).byte(static_cast<uint8_t>(patches.size() - 1));
    for (const Patch& patch : patches)
        to.byte(static_cast<uint8_t>(2 * part)).number(static_cast<int32_t>(patch.offset)).number(patch.value);
    return to;
}

Bytes all_console_steps(Writer to) {
    step(to, Step::kPress).byte(0x3f).byte(5).byte(10).byte(0x15);
    for (int i = 0; i < 4; ++i) to.number(27450 * (i + 1));
    for (Step each : {Step::kFrame, Step::kChangePlaces, Step::kFrame, Step::kFrame, Step::kLook, Step::kSamples,
                      Step::kFrame, Step::kCompare})
        step(to, each);
    step(to, Step::kInstructions).byte(100);
    step(to, Step::kWrite).word(0x1ff8).byte(1);
    step(to, Step::kRead).word(0x1ff9);
    for (Step each : {Step::kFrame, Step::kChangePlaces, Step::kReset, Step::kFrame}) step(to, each);
    damage(to, Step::kDamage, {{offsetof(Machine, riot.ram), 0x55}});
    return step(to, Step::kFrame).bytes();
}

struct Rule {
    Op op;
    int32_t argument;
};

void program(Writer& to, const std::vector<Rule>& rules) {
    to.byte(0).byte(static_cast<uint8_t>(rules.size()));
    for (const Rule& rule : rules) to.byte(static_cast<uint8_t>(rule.op)).number(rule.argument);
}

// Variables: 0 reward, 1 terminal, 2 lives, 3 the number of the mode.
Writer environment(const Bytes& code, const std::vector<Rule>& rules, const std::vector<Rule>& select_mode,
                   uint8_t config = 2, uint8_t flags = 4 | 32, uint8_t settings = 3) {
    Writer to;
    to.byte(1);
    cartridge(to, 0, k4K, kWhole | kVectors, code);
    to.byte(config).number(34).number(210);
    to.byte(flags).byte(0x3f).number(0).number(4);  // mode 0, four variables
    to.byte(3);                                     // three of them with start values
    for (int i = 0; i < 3; ++i) to.number(i).byte(i & 1);
    to.byte(1).number(1);  // FIRE to start
    if (flags & 32)
        for (int output : {0, 1, 2, 3}) to.number(output);
    program(to, rules);
    program(to, select_mode);
    return to.byte(settings).byte(64).number(18000).number(7);
}

const std::vector<Rule> kEmpty = {{Op::kEnd, 0}};

// reward = the change of a byte; terminal = bit 6 of another; lives by `count`.
const std::vector<Rule> kUsualRules = {
    {Op::kPush, 0x80}, {Op::kRam, 0},     {Op::kLoad, 3},  {Op::kSubtract, 0}, {Op::kStore, 0},   {Op::kPush, 0x80},
    {Op::kPush, 0x81}, {Op::kPush, 0x82}, {Op::kBcd, 3},   {Op::kStore, 3},    {Op::kPush, 0x80}, {Op::kRam, 0},
    {Op::kPush, 0x40}, {Op::kAnd, 0},     {Op::kStore, 1}, {Op::kPush, 0x80},  {Op::kPush, 0x8f}, {Op::kPush, 0},
    {Op::kPush, 1},    {Op::kCount, 4},   {Op::kStore, 2}, {Op::kEnd, 0}};

std::vector<Rule> every_operation() {
    std::vector<Rule> rules;
    for (int op = static_cast<int>(Op::kAdd); op <= static_cast<int>(Op::kGreaterEqual); ++op)
        rules.insert(rules.end(), {{Op::kRandom, 0}, {Op::kPush, -3}, {static_cast<Op>(op), 0}, {Op::kStore, 0}});
    return rules.insert(rules.end(), {Op::kEnd, 0}), rules;
}

// clang-format off
const std::vector<Rule> kUnaryOperations = {
    {Op::kPush, 5}, {Op::kNegate, 0}, {Op::kInvert, 0}, {Op::kNot, 0}, {Op::kSigned8, 0}, {Op::kXram, 0},
    {Op::kStore, 3},
    {Op::kPush, 0x80}, {Op::kPush, 0xff}, {Op::kSame, 0}, {Op::kPush, 0x80}, {Op::kPush, 0xff}, {Op::kPositiveSum, 0},
    {Op::kPush, 0x80}, {Op::kPush, 0xff}, {Op::kNegativeSum, 0}, {Op::kAdd, 0}, {Op::kAdd, 0},
    {Op::kJumpIfZeroElsePop, 20}, {Op::kPush, 1}, {Op::kJumpIfNotZeroElsePop, 22}, {Op::kPush, 2},
    {Op::kJumpIfZero, 24},
    {Op::kJump, 24}, {Op::kEnd, 0}};

// SELECT three times, a soft reset, an action.
const std::vector<Rule> kSelection = {
    {Op::kPush, 0}, {Op::kStore, 3}, {Op::kLoad, 3}, {Op::kPush, 3}, {Op::kLess, 0}, {Op::kJumpIfZero, 13},
    {Op::kPush, 2}, {Op::kPressSelect, 0}, {Op::kLoad, 3}, {Op::kPush, 1}, {Op::kAdd, 0}, {Op::kStore, 3},
    {Op::kJump, 2}, {Op::kSoftReset, 0}, {Op::kAct, 1}, {Op::kEnd, 0}};
// clang-format on

Bytes all_environment_steps(Writer to) {
    for (int i = 0; i < 4; ++i)
        step(step(to, Act::kAct).byte(static_cast<uint8_t>(3 * i)).number(16 - i), Act::kRestore);
    for (Act each : {Act::kLook, Act::kChangePlaces}) step(to, each);
    step(to, Act::kSetRam).byte(3).byte(0x77);
    step(to, Act::kMode).number(2);
    step(to, Act::kDifficulty).number(3);
    step(to, Act::kAct).byte(4).number(8);
    for (Act each : {Act::kReset, Act::kLook}) step(to, each);
    step(to, Act::kSeed).number(99);
    step(to, Act::kAct).byte(3).number(16);
    return step(step(to, Act::kCompare), Act::kLook).bytes();
}

// A state that no machine could have saved, then some steps.
template <typename... Steps>
Bytes damaged_console(std::initializer_list<Patch> patches, Steps... steps) {
    Writer to = console(2, k4K, kShort);
    damage(step(to, Step::kFrame), Step::kDamage, patches);
    (step(to, steps), ...);
    return to.bytes();
}

// Inputs for errors that fuzzing, or a review of the code, has found. Each failed once.
void add_found(const std::function<void(const std::string&, const Bytes&)>& add) {
    constexpr size_t kCycles = offsetof(Machine, cycles), kWords = offsetof(Machine, random_words);
    constexpr size_t kStart = offsetof(Machine, tia.draw_start), kDrawn = offsetof(Machine, tia.drawn_to);
    constexpr int32_t kMost = INT32_MAX;

    add("found-clocks-far-apart", damaged_console({{kStart + 4, INT32_MIN}, {kDrawn, kMost}}, Step::kFrame));
    add("found-words-without-end", damaged_console({{kWords + 4, kMost}}, Step::kReset));
    // A frame that lasts until its clock is greater than a state may contain.
    Writer endless = console(2, k4K, kShort);
    damage(step(endless, Step::kFrame), Step::kDamage, {{kCycles, 1 << 29}});
    step(endless, Step::kRead).word(0);
    add("found-own-state-refused", step(endless, Step::kChangePlaces).bytes());
    // A frame that no instruction ends, in a line whose first pixel has no number.
    Writer below = console(2, k4K, {0x02});
    damage(step(below, Step::kFrame), Step::kDamage, {{kCycles, -(1 << 28)}, {offsetof(Machine, tia.partial), 1}});
    add("found-line-far-below", step(below, Step::kFrame).bytes());
    // A bank whose end the image lacks, with an operand after the end of the image.
    add("found-bank-cut-off", console(0, kDpcSize, {0xad, 0xf0, 0xff}).bytes());
    add("found-framebuffer-beyond-numbers", console(2, k4K, kShort, 2, kMost).bytes());

    Writer last_frame = environment(kShort, kUsualRules, kEmpty);
    constexpr size_t kOwnStart = offsetof(EnvironmentState, random.position);
    damage(last_frame, Act::kDamage, {{offsetof(EnvironmentState, frame) - kOwnStart, kMost}}, kOwn);
    add("found-last-frame", step(step(last_frame, Act::kAct).byte(0).number(16), Act::kChangePlaces).bytes());

    // Quotients and remainders by numbers near the end of 64 bits, and of the smallest number.
    const auto huge = [](int shift) {
        return std::vector<Rule>{
            {Op::kPush, 1}, {Op::kPush, 31}, {Op::kShiftLeft, 0}, {Op::kPush, shift}, {Op::kShiftLeft, 0}};
    };
    for (const auto& [name, op] :
         {std::pair("found-quotient", Op::kDivide), std::pair("found-remainder", Op::kModulo)}) {
        std::vector<Rule> rules = huge(31);
        for (const Rule& rule : huge(31)) rules.push_back(rule);
        for (const Rule& rule : huge(30)) rules.push_back(rule);
        rules.insert(rules.end(), {{Op::kOr, 0}, {op, 0}, {Op::kStore, 3}});
        for (const Rule& rule : huge(31)) rules.push_back(rule);
        rules.insert(rules.end(),
                     {{Op::kPush, 1}, {Op::kShiftLeft, 0}, {Op::kPush, 7}, {op, 0}, {Op::kStore, 3}, {Op::kEnd, 0}});
        add(name, environment(kShort, rules, kEmpty).bytes());
    }
}

}  // namespace

std::vector<std::pair<std::string, Bytes>> fuzzing_seeds() {
    std::vector<std::pair<std::string, Bytes>> seeds;
    const auto add = [&](const std::string& name, const Bytes& bytes) { seeds.emplace_back(name, bytes); };

    add("console-full-frame", all_console_steps(console(2, k4K, kFullFrame)));
    add("console-full-frame-pal", all_console_steps(console(2, k4K, kFullFrame, 1)));
    add("console-paddles", all_console_steps(console(2, k4K, kFullFrame, 2 | 4 | 8)));
    add("console-swapped-paddles", all_console_steps(console(2, k4K, kFullFrame, 4 | 16 | 32)));
    add("console-short-frames", all_console_steps(console(0, k4K, kShort)));
    add("console-opcodes", all_console_steps(console(2, k4K, all_opcodes())));
    add("console-starfield", all_console_steps(console(2, k4K, kStarfield)));
    add("console-dpc", dpc_steps());
    add("console-noise", all_console_steps(console(2, k4K, noise(2048, 1))));
    add("console-jam", all_console_steps(console(2, k4K, {0x02})));
    add("console-never-ends", all_console_steps(console(2, k4K, {0x4c, 0x00, 0xf0})));
    add("console-break", all_console_steps(console(2, k4K, {0x00})));
    for (int type = 0; type < kTypes; ++type)
        add("cartridge-" + std::to_string(type), all_console_steps(console(type, k64K, kHotspots)));
    for (int type : {1, 15, 16, 18})  // 2K, 3F, 3E, CV
        add("cartridge-small-" + std::to_string(type), all_console_steps(console(type, k2K, kHotspots)));
    for (uint8_t size = 0; size < 16; ++size)  // detected by its size
        add("size-" + std::to_string(size),
            all_console_steps(console(0, size, {0x85, 0x3f, 0x85, 0x3f, 0x4c, 0x00, 0xf0})));

    add("environment", all_environment_steps(environment(kShort, kUsualRules, kEmpty)));
    add("environment-full-frame", all_environment_steps(environment(kFullFrame, kUsualRules, kEmpty)));
    add("environment-paddles", all_environment_steps(environment(kFullFrame, kUsualRules, kEmpty, 2 | 4 | 8)));
    add("environment-pal", all_environment_steps(environment(kShort, kUsualRules, kEmpty, 1, 1 | 4 | 32)));
    add("environment-operations", all_environment_steps(environment(kShort, every_operation(), kEmpty)));
    add("environment-unary", all_environment_steps(environment(kShort, kUnaryOperations, kEmpty)));
    add("environment-selection", all_environment_steps(environment(kShort, kUsualRules, kSelection)));
    add("environment-never-reached",
        all_environment_steps(environment(kShort, kEmpty, {{Op::kJump, 0}, {Op::kEnd, 0}})));
    add_found(add);
    return seeds;
}

}  // namespace atari
