// The extension module atari_inspection, for tests alone. `Console` is a console without a game's rules or a seed; its
// methods run single accesses or instructions. `pool_gray` and `resize` are the two steps of an observation.
// Functions that write into memory write between guard values here, which are checked.
#include <nanobind/stl/unique_ptr.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "arm64_instructions.hpp"
#include "fast/jit/assembler_x86.hpp"
#include "ale/colours/colour_conversion.hpp"
#include "machine/console.hpp"
#include "machine/cpu/cpu_instructions.hpp"
#include "fast/fast_console.hpp"
#include "observations/pooling.hpp"
#include "observations/resizer.hpp"
#include "fast/tia/paint.hpp"
#include "python/arrays.hpp"

namespace atari {
namespace {

using Flags = std::pair<bool, bool>;

std::unique_ptr<Console> make(nb::bytes image, const std::string& cartridge, int first_line, int height, bool pal,
                              bool hmove_blanks, Flags paddles, bool swap_ports, bool swap_paddles, bool plain,
                              bool translated) {
    if (first_line < 0 || height < 1 || first_line + height > kFrameRows)
        throw std::invalid_argument("the framebuffer must lie within 300 lines");
    const auto* bytes = static_cast<const uint8_t*>(image.data());
    const std::vector<uint8_t> copy(bytes, bytes + image.size());
    const ConsoleConfig config{first_line, height,      pal, hmove_blanks, {paddles.first, paddles.second},
                               swap_ports, swap_paddles};
    std::unique_ptr<Console> console;
    if (plain) console = std::make_unique<Console>(std::make_shared<const Cartridge>(copy, cartridge), config);
    else
        console =
            std::make_unique<FastConsole>(std::make_shared<const FastCartridge>(copy, cartridge, translated), config);
    console->construct();
    console->reset();
    return console;
}

// Returns whether the cartridge has translated code.
bool translated(const Console& console) {
    const auto* const fast = dynamic_cast<const FastConsole*>(&console);
    return fast && fast->cartridge().translated_code().any();
}

nb::bytes as_bytes(const uint8_t* data, size_t size) { return nb::bytes(data, size); }

template <typename Item>
nb::list as_list(const Item* items, size_t count) {
    nb::list list;
    for (size_t i = 0; i < count; ++i) list.append(static_cast<int>(items[i]));
    return list;
}

template <typename Item, size_t count>
nb::list as_list(const Item (&items)[count]) {
    return as_list(items, count);
}

nb::object as_array(const uint8_t* data, std::initializer_list<size_t> shape) {
    size_t size = 1;
    for (size_t extent : shape) size *= extent;
    std::unique_ptr<uint8_t[]> copy(new uint8_t[size]);
    std::copy_n(data, size, copy.get());
    return array_of(std::move(copy), shape.begin(), shape.size());
}

nb::dict registers(const Cpu& cpu) {
    nb::dict dict;
    dict["a"] = cpu.a;
    dict["x"] = cpu.x;
    dict["y"] = cpu.y;
    dict["sp"] = cpu.sp;
    dict["pc"] = cpu.pc;
    const std::pair<const char*, Flag> flags[6] = {{"n", cpu.n}, {"v", cpu.v}, {"d", cpu.d},
                                                   {"i", cpu.i}, {"z", cpu.z}, {"c", cpu.c}};
    for (const auto& [name, flag] : flags) dict[name] = static_cast<bool>(flag);
    return dict;
}

// Returns the processor with some registers changed, given by name.
Cpu with_registers(Cpu cpu, nb::kwargs changes) {
    const std::pair<const char*, uint8_t*> bytes[4] = {{"a", &cpu.a}, {"x", &cpu.x}, {"y", &cpu.y}, {"sp", &cpu.sp}};
    const std::pair<const char*, Flag*> flags[6] = {{"n", &cpu.n}, {"v", &cpu.v}, {"d", &cpu.d},
                                                    {"i", &cpu.i}, {"z", &cpu.z}, {"c", &cpu.c}};
    for (auto [key, value] : changes) {
        const auto name = nb::cast<std::string>(key);
        bool good = name == "pc" && nb::try_cast(value, cpu.pc);
        for (const auto& [known, byte] : bytes) good |= name == known && nb::try_cast(value, *byte);
        bool on = false;
        for (const auto& [known, flag] : flags) {
            if (name != known || !nb::try_cast(value, on)) continue;
            *flag = on;
            good = true;
        }
        if (!good) throw std::invalid_argument("there is no register '" + name + "', or the value does not fit it");
    }
    return cpu;
}

// A processor without a console, on a bus that a test writes in Python.
struct Processor {
    Cpu cpu{};
    nb::object bus;

    uint8_t read(uint16_t address) { return nb::cast<uint8_t>(bus.attr("read")(address)); }
    void write(uint16_t address, uint8_t value) { bus.attr("write")(address, value); }
    void spend(int cycles) { bus.attr("cycles") = nb::cast<int>(bus.attr("cycles")) + cycles; }
};

// Returns the registers and latches of the chips that programs cannot read, by their names in the chips' headers.
nb::dict state(const Console& console) {
    const Machine& m = console.machine();
    const Tia& t = m.tia;
    nb::dict riot, tia, cart, sound, all;
    riot["timer"] = m.riot.timer;
    riot["shift"] = m.riot.shift;
    riot["ddr_a"] = m.riot.ddr_a;
    riot["set_at"] = m.riot.set_at;
    riot["irq_at"] = m.riot.irq_at;
    riot["read_after_expiry"] = static_cast<bool>(m.riot.read_after_expiry);

    tia["frame_start"] = t.frame_start;
    tia["last_hmove"] = t.last_hmove;
    tia["draw_start"] = t.draw_start;
    tia["draw_stop"] = t.draw_stop;
    tia["drawn_to"] = t.drawn_to;
    tia["pending"] = t.pending;
    tia["to_line_end"] = t.to_line_end;
    tia["write_pos"] = t.write_pos;
    tia["vsync_done"] = t.vsync_done;
    tia["dump_off_cycle"] = t.dump_off_cycle;
    tia["last_line_count"] = t.last_line_count;
    tia["current_line"] = t.current_line;
    tia["playfield"] = t.playfield;
    tia["collisions"] = t.collisions;
    tia["vblank"] = t.vblank;
    tia["ctrlpf"] = t.ctrlpf;
    tia["nusiz"] = as_list(t.nusiz);
    tia["colour"] = as_list(t.colour);
    tia["grp"] = as_list(t.grp);
    tia["old_grp"] = as_list(t.old_grp);
    tia["hm"] = as_list(t.hm);
    tia["pos"] = as_list(t.pos);
    tia["refp"] = as_list(t.refp);
    tia["vdelp"] = as_list(t.vdelp);
    tia["enam"] = as_list(t.enam);
    tia["resmp"] = as_list(t.resmp);
    tia["skip_first"] = as_list(t.skip_first);
    tia["m0_variant"] = static_cast<int>(t.m0_variant);
    tia["ark_counter"] = t.ark_counter;
    tia["current"] = t.current;
    const std::pair<const char*, Flag> flags[9] = {
        {"enabl", t.enabl},          {"old_enabl", t.old_enabl},     {"vdelbl", t.vdelbl},
        {"pf_mirror", t.pf_reflect}, {"hmove_blank", t.hmove_blank}, {"cosmic_ark", t.cosmic_ark},
        {"dump_on", t.dump_on},      {"partial", t.partial},         {"greyed", t.greyed}};
    for (const auto& [name, flag] : flags) tia[name] = static_cast<bool>(flag);

    cart["bank"] = m.cart.bank;
    cart["slice"] = as_list(m.cart.slice);
    cart["top"] = as_list(m.cart.top);
    cart["bottom"] = as_list(m.cart.bottom);
    cart["flag"] = as_list(m.cart.flag);
    cart["counter"] = as_list(m.cart.counter);
    cart["music"] = as_list(m.cart.music);
    cart["random"] = m.cart.random;
    cart["stamp"] = m.cart.stamp;
    cart["fraction"] = m.cart.fraction;

    const std::pair<const char*, const uint8_t*> channels[6] = {{"audc", m.sound.audc}, {"audf", m.sound.audf},
                                                                {"audv", m.sound.audv}, {"counter", m.sound.counter},
                                                                {"p4", m.sound.p4},     {"p5", m.sound.p5}};
    for (const auto& [name, values] : channels) sound[name] = as_list(values, 2);

    all["cycles"] = m.cycles;
    all["bus"] = m.bus;
    all["stop"] = static_cast<bool>(m.cpu.stop);
    all["last_access_was_read"] = static_cast<bool>(m.cpu.last_access_was_read);
    all["jammed"] = static_cast<bool>(m.cpu.jammed);
    all["random_words"] = m.random_words;
    all["riot"] = riot;
    all["tia"] = tia;
    all["cart"] = cart;
    all["sound"] = sound;
    return all;
}

nb::object framebuffer(Console& console) {
    console.catch_up();
    return as_array(console.framebuffer(), {static_cast<size_t>(console.config().height), kScreenWidth});
}

void set_positions(Console& console, std::array<int, 5> positions) {
    for (int position : positions)
        if (position < 0 || position >= kScreenWidth) throw std::invalid_argument("a position is within 0..159");
    std::copy_n(positions.begin(), 5, console.raw_machine().tia.pos);
}

void set_ram(Console& console, nb::bytes ram) {
    if (ram.size() != 128) throw std::invalid_argument("RAM has 128 bytes");
    std::copy_n(static_cast<const uint8_t*>(ram.data()), 128, console.raw_machine().riot.ram);
}

void set_inputs(Console& console, int switches, std::array<int, 2> sticks, std::array<bool, 2> fire,
                std::array<int32_t, 4> resistances, std::array<bool, 4> paddle_fire) {
    for (int32_t resistance : resistances)
        if (resistance < 0) throw std::invalid_argument("a resistance is not negative");
    Inputs inputs{};
    inputs.switches = static_cast<uint8_t>(switches);
    for (size_t i = 0; i < 2; ++i) {
        inputs.stick[i] = static_cast<uint8_t>(sticks[i] & 15);
        inputs.fire[i] = fire[i];
    }
    for (size_t i = 0; i < 4; ++i) {
        inputs.resistance[i] = resistances[i];
        inputs.paddle_fire[i] = paddle_fire[i];
    }
    console.inputs() = inputs;
}

nb::bytes save(Console& console) {
    std::vector<uint8_t> state(console.state_size());
    console.save(state.data());
    return bytes_of(state);
}

void load(Console& console, nb::bytes state) {
    if (state.size() != console.state_size() || !console.load(static_cast<const uint8_t*>(state.data())))
        throw std::invalid_argument("the state is damaged, or of another cartridge");
}

// A snapshot in memory. Only the console that made it accepts it.
struct Snapshot {
    const Console* of;
    std::unique_ptr<ConsoleSnapshot> state;
};

Snapshot snapshot(const Console& console) { return {&console, console.snapshot()}; }

void restore(Console& console, const Snapshot& snapshot) {
    if (snapshot.of != &console) throw std::invalid_argument("this snapshot is of another console");
    console.restore(*snapshot.state);
}

// Returns whether two machines of a cartridge are in the same state. Framebuffers and collision latches, which
// `FastConsole` defers, are brought up to date and compared only if `complete`.
bool same_state(Console& first, Console& second, bool complete) {
    if (first.state_size() != second.state_size())
        throw std::invalid_argument("the consoles are of different cartridges");
    if (complete) {
        std::vector<uint8_t> saved(first.state_size()), also(second.state_size());
        first.save(saved.data());
        second.save(also.data());
        return saved == also;
    }
    Machine machines[2];
    std::memcpy(&machines[0], &first.machine(), sizeof(Machine));
    std::memcpy(&machines[1], &second.machine(), sizeof(Machine));
    machines[0].tia.collisions = machines[1].tia.collisions;
    return std::memcmp(&machines[0], &machines[1], sizeof(Machine)) == 0 &&
           std::equal(first.cartridge_ram(), first.cartridge_ram() + first.cartridge_ram_size(),
                      second.cartridge_ram());
}

using Bytes = List<const uint8_t>;
using Frame = nb::ndarray<const uint8_t, nb::shape<-1, kScreenWidth>, nb::c_contig, nb::device::cpu>;

// Returns the given level, or the highest. Throws if this processor does not support it.
SimdLevel checked_level(std::optional<SimdLevel> level) {
    if (level.value_or(SimdLevel::kScalar) > best_simd_level())
        throw std::invalid_argument("this processor does not support this SIMD level");
    return level.value_or(best_simd_level());
}

// Memory for a function's output, between values that the function must leave alone.
template <typename Value>
class Guarded {
  public:
    explicit Guarded(size_t size) : values_(size + 2 * kGuards, kGuard) {}

    Value* data() { return values_.data() + kGuards; }

    // Throws std::logic_error if the function has written before `first` or from `last` on.
    void check(size_t first, size_t last) const {
        const auto untouched = [](Value value) { return value == kGuard; };
        const auto begin = values_.begin() + kGuards;
        if (!std::all_of(values_.begin(), begin + static_cast<ptrdiff_t>(first), untouched) ||
            !std::all_of(begin + static_cast<ptrdiff_t>(last), values_.end(), untouched))
            throw std::logic_error("values outside the output have been written");
    }
    void check() const { check(0, values_.size() - 2 * kGuards); }

  private:
    static constexpr int kGuards = 256;
    static constexpr auto kGuard = static_cast<Value>(0xa5c35aa5u);
    std::vector<Value> values_;
};

std::pair<nb::object, std::vector<uint32_t>> pooled(Frame early, Frame late, Bytes table,
                                                    std::optional<SimdLevel> level) {
    const size_t rows = early.shape(0);
    const bool pairs = table.shape(0) == 65536;
    if (rows < 1 || rows > kFrameRows || late.shape(0) != rows || (table.shape(0) != 256 && !pairs))
        throw std::invalid_argument("two frames of the same 1..300 rows and a table of 256 or 65536 are needed");
    Guarded<uint8_t> gray(early.size());
    Guarded<uint32_t> changes(rows);
    const auto pool = pairs ? pool_pairs : pool_gray;
    pool(early.data(), late.data(), static_cast<int>(rows), table.data(), gray.data(), changes.data(),
         checked_level(level));
    gray.check();
    changes.check();
    return {as_array(gray.data(), {rows, kScreenWidth}), {changes.data(), changes.data() + rows}};
}

nb::object resized(Frame frame, int height, int width, const std::optional<std::vector<uint32_t>>& changes,
                   std::optional<SimdLevel> level, std::optional<std::pair<int, int>> result_rows) {
    const size_t rows = frame.shape(0);
    const Resizer resize(static_cast<int>(rows), height, width, checked_level(level));
    if (changes && changes->size() != rows) throw std::invalid_argument("`changes` has an entry for each row");
    for (size_t row = 0; changes && row < rows; ++row)
        if ((*changes)[row] >> kScreenWidth / 8) throw std::invalid_argument("`changes` has 20 bits for each row");
    const size_t extents[2] = {static_cast<size_t>(height), static_cast<size_t>(width)};
    Guarded<uint8_t> small(extents[0] * extents[1]);
    const uint32_t* const changed = changes ? changes->data() : nullptr;
    if (result_rows) {
        const auto [first, last] = *result_rows;
        if (!resize.area_resize() || first < 0 || first >= last || last > height)
            throw std::invalid_argument(
                "rows must lie within the height; sizes that are sums of blocks have no single rows");
        resize.area_resize()->make_rows(frame.data(), changed, small.data(), first, last);
        const size_t begin = static_cast<size_t>(first) * extents[1], end = static_cast<size_t>(last) * extents[1];
        small.check(begin, end);
        return as_array(small.data() + begin, {static_cast<size_t>(last - first), extents[1]});
    }
    resize(frame.data(), changed, small.data());
    small.check();
    return as_array(small.data(), {extents[0], extents[1]});
}

// Returns a row of 160 zeros with pixels first .. last-1 filled at a SIMD level.
nb::object painted(std::array<Bytes, 3> layers, std::array<uint8_t, 4> colours, int first, int last, SimdLevel level) {
    if (first < 0 || first >= last || last > kScreenWidth)
        throw std::invalid_argument("0 <= first < last <= 160 is needed");
    Mask masks[3];
    for (size_t i = 0; i < 3; ++i) {
        if (layers[i].shape(0) != kScreenWidth) throw std::invalid_argument("a layer has 160 pixels");
        for (size_t x = 0; x < kScreenWidth; ++x)
            masks[i].word[x / 64] |= uint64_t{layers[i].data()[x] != 0} << (x % 64);
    }
    Guarded<uint8_t> row(kScreenWidth);
    std::fill_n(row.data(), kScreenWidth, uint8_t{0});
    painters()[static_cast<size_t>(checked_level(level))](row.data(), {masks[0], masks[1], masks[2]}, colours.data(),
                                                          first, last);
    row.check();
    return as_array(row.data(), {kScreenWidth});
}

nb::object coloured(Frame frame, const std::string& format, std::optional<SimdLevel> level) {
    const size_t rows = frame.shape(0);
    if (rows < 1 || rows > kFrameRows || frame.shape(1) != kScreenWidth)
        throw std::invalid_argument("a frame is (1..300, 160)");
    Guarded<uint8_t> rgb(3 * frame.size());
    to_rgb(frame.data(), static_cast<int>(rows), palette_of(format), rgb.data(), checked_level(level));
    rgb.check();
    return as_array(rgb.data(), {rows, kScreenWidth, 3});
}

}  // namespace

void register_web_readers(nb::module_& m);  // web_readers.cpp

}  // namespace atari

NB_MODULE(atari_inspection, m) {
    using namespace atari;
    register_web_readers(m);
    nb::class_<Snapshot>(m, "ConsoleSnapshot", "A state in memory, as `Console.snapshot` returned it.");
    nb::class_<Console>(m, "Console",
                        "A bare console, driven by hand: for tests and for looking inside.\n\n"
                        "Made as at power-on, after one reset; no frame has begun. `cartridge` names the type of bank\n"
                        "switching, \"\" detects it. The other arguments are those of a game's screen and "
                        "controllers.\n"
                        "If `plain`, the reference core; if not, `run_frame` runs the fast core, and if `translated`,\n"
                        "by translated code where the platform supports it.\n"
                        "Raises ValueError if the image is of no supported type.")
        .def(nb::new_(&make), "image"_a, "cartridge"_a = "", nb::kw_only(), "first_line"_a = 34, "height"_a = 210,
             "pal"_a = false, "hmove_blanks"_a = true, "paddles"_a = Flags{false, false}, "swap_ports"_a = false,
             "swap_paddles"_a = false, "plain"_a = true, "translated"_a = true)
        .def("reset", &Console::reset, "The reset of all chips, as a game is reset. RAM survives.")
        .def("read", &Console::read, "address"_a, "A read on the bus, at the present cycle; an int within 0..255.")
        .def("write", &Console::write, "address"_a, "value"_a, "A write on the bus, at the present cycle.")
        .def(
            "step",
            [](Console& x) {
                if (!x.machine().cpu.jammed) x.run_instruction();
            },
            "Run one instruction; nothing once an illegal opcode has stopped the processor.")
        .def("start_frame", &Console::start_frame, "Begin a frame: cycles count from 0 again, lines keep their phase.")
        .def("run_frame", &Console::run_frame, "Run until the frame ends, for at most 25000 instructions.")
        .def_prop_rw(
            "cycles", [](const Console& x) { return x.machine().cycles; },
            [](Console& x, uint32_t cycles) { x.raw_machine().cycles = cycles; },
            "Processor cycles since the frame began; the chips see what is set here as time.")
        .def_prop_ro("scan_lines", &Console::scan_lines, "Lines since the frame began.")
        .def_prop_ro(
            "registers", [](const Console& x) { return registers(x.machine().cpu); },
            nb::for_getter(nb::sig("def registers(self, /) -> dict[str, int]")),
            "Of the processor: a, x, y, sp, pc, and the flags n, v, d, i, z, c as bools.")
        .def(
            "set_registers",
            [](Console& x, nb::kwargs changes) { x.raw_machine().cpu = with_registers(x.machine().cpu, changes); },
            "changes"_a, nb::sig("def set_registers(self, **changes: int) -> None"),
            "Change some of `registers`, given by name.")
        .def_prop_rw(
            "ram", [](const Console& x) { return as_bytes(x.ram(), 128); }, &set_ram, "The 128 bytes of RAM.")
        .def_prop_ro(
            "cartridge_ram", [](const Console& x) { return as_bytes(x.cartridge_ram(), x.cartridge_ram_size()); },
            "The cartridge's own RAM, empty if it has none.")
        .def_prop_ro("translated", &translated, "Whether there is translated code of the program.")
        .def_prop_ro("cartridge_type", [](const Console& x) { return x.cartridge().type_name(); })
        .def_prop_rw(
            "positions", [](const Console& x) { return as_list(x.machine().tia.pos); }, &set_positions,
            nb::for_getter(nb::sig("def positions(self, /) -> list[int]")),
            "Of player 0, player 1, missile 0, missile 1 and ball: five columns within 0..159.")
        .def("framebuffer", &framebuffer, nb::sig("def framebuffer(self) -> numpy.typing.NDArray[numpy.uint8]"),
             "The current frame's framebuffer up to the latest access of the TIA: uint8 (height, 160), palette "
             "indices.")
        .def(
            "make_samples",
            [](Console& x) {
                uint8_t samples[kAudioSamples];
                x.make_samples(samples);
                return as_array(samples, {kAudioSamples});
            },
            nb::sig("def make_samples(self) -> numpy.typing.NDArray[numpy.uint8]"),
            "The next 512 samples of sound: uint8 (512,), unsigned around 128.")
        .def("set_inputs", &set_inputs, nb::kw_only(), "switches"_a = 0x3f, "sticks"_a = std::array<int, 2>{0, 0},
             "fire"_a = std::array<bool, 2>{false, false}, "resistances"_a = std::array<int32_t, 4>{0, 0, 0, 0},
             "paddle_fire"_a = std::array<bool, 4>{false, false, false, false},
             "What is pressed: SWCHB, both sticks (bits 0-3: up, down, left, right), fire, paddles. Default: nothing.")
        .def("state", &state, nb::sig("def state(self) -> dict[str, typing.Any]"),
             "All chips' registers and latches, by name, as nested dicts. For looking, not for saving.")
        .def("save", &save, "The whole state as bytes.")
        .def("load", &load, "state"_a, "Continue from `save`; ValueError if the bytes cannot be a state.")
        .def("snapshot", &snapshot, "The whole state in memory, deferred frames included.")
        .def("restore", &restore, "snapshot"_a,
             "Continue from a `snapshot` of this console; ValueError if it is of another one.");

    nb::class_<Processor>(m, "Processor",
                          "A processor without a console. `bus` is an object with `read(address)`, `write(address,\n"
                          "value)` and a number `cycles`, to which the processor adds.")
        .def(
            "__init__", [](Processor* x, nb::object bus) { new (x) Processor{Cpu{}, std::move(bus)}; }, "bus"_a)
        .def(
            "step", [](Processor& x) { x.cpu.run_instruction(x); }, "Run one instruction.")
        .def_prop_ro(
            "registers", [](const Processor& x) { return registers(x.cpu); },
            nb::for_getter(nb::sig("def registers(self, /) -> dict[str, int]")), "As of a `Console`.")
        .def(
            "set_registers", [](Processor& x, nb::kwargs changes) { x.cpu = with_registers(x.cpu, changes); },
            "changes"_a, nb::sig("def set_registers(self, **changes: int) -> None"),
            "Change some of `registers`, given by name.");

    nb::enum_<SimdLevel>(m, "SimdLevel", "A level of SIMD instructions. The results of all levels are equal.")
        .value("SCALAR", SimdLevel::kScalar)
        .value("SIMD128", SimdLevel::kSimd128)
        .value("AVX2", SimdLevel::kAvx2)
        .value("AVX512", SimdLevel::kAvx512);
    m.def("best_simd_level", &best_simd_level,
          "The highest level that this processor supports. The functions below use it where `level` is None.");
    m.def("paint", &painted, "layers"_a, "colours"_a, "first"_a, "last"_a, "level"_a,
          nb::sig("def paint(layers: Sequence[numpy.typing.NDArray[numpy.uint8]], colours: Sequence[int], first: int, "
                  "last: int, "
                  "level: SimdLevel) -> numpy.typing.NDArray[numpy.uint8]"),
          "A row of 160 zeros in which pixels first .. last-1 have been painted: those of the three layers, (160,) "
          "each,\n"
          "in the first three colours, the others in the fourth.");
    m.def("to_rgb", &coloured, "frame"_a, "format"_a, "level"_a = nb::none(),
          nb::sig("def to_rgb(frame: numpy.typing.NDArray[numpy.uint8], format: str, "
                  "level: SimdLevel | None = None) -> "
                  "numpy.typing.NDArray[numpy.uint8]"),
          "A frame of palette indices, (rows, 160), in the colours of a TV format.");
    m.def(
        "short_jump",
        [](size_t distance) {
            if (distance > 1000) throw std::invalid_argument("distance must be within 0..1000");
            x86::Assembler code;
            const ShortJump jump = code.jump_short(If::zero);
            for (size_t i = 0; i < distance; ++i) code.ret();
            code.bind_short(jump);
            return bytes_of(code.bytes());
        },
        "distance"_a,
        "What the JIT translator's assembler makes of a jump of two bytes over `distance` others, and these.\n"
        "Raises RuntimeError if such a jump does not reach so far.");
    m.def(
        "arm64_instructions",
        [] {
            nb::dict code;
            for (const auto& [name, bytes] : arm64::instructions()) code[name.c_str()] = bytes_of(bytes);
            return code;
        },
        nb::sig("def arm64_instructions() -> dict[str, bytes]"),
        "Short sequences of the JIT translator's assembler of arm64, by name.");
    m.def(
        "arm64_logical_constant",
        [](uint32_t value) -> std::optional<int> {
            if (const auto field = arm64::logical_constant(value)) return static_cast<int>(*field);
            return {};
        },
        "value"_a, "The 13 bits that stand for a constant in a logical instruction of arm64; None if it has none.");
    m.def(
        "arm64_jump",
        [](size_t skipped, bool far) {
            if (skipped > 1'000'000) throw std::invalid_argument("skipped must be within 0..1000000");
            const std::vector<uint8_t> code = arm64::jump_over(skipped, far);
            return bytes_of(code);
        },
        "skipped"_a, nb::kw_only(), "far"_a,
        "A conditional jump of arm64 over instructions, and these. Raises RuntimeError if it does not reach so far.");
    m.def("same_state", &same_state, "first"_a, "second"_a, "complete"_a,
          "Whether two consoles are in the same state to the byte. Unless this is `complete`, framebuffers and\n"
          "collision latches are left out, and a console that runs frames fast goes on deferring them.");
    m.def("pool_gray", &pooled, "early"_a, "late"_a, "table"_a, "level"_a = nb::none(),
          nb::sig("def pool_gray(early: numpy.typing.NDArray[numpy.uint8], late: numpy.typing.NDArray[numpy.uint8], "
                  "table: numpy.typing.NDArray[numpy.uint8], level: SimdLevel | None = None) -> "
                  "tuple[numpy.typing.NDArray[numpy.uint8], list[int]]"),
          "The brighter of two frames, (rows, 160) palette indices, by a table of 256 grays, or what a table of "
          "65,536\n"
          "has for early * 256 + late; and for each row bit k if columns 8k .. 8k+7 differ from the row above.");
    m.def("resize", &resized, "frame"_a, "height"_a, "width"_a, "changes"_a = nb::none(), "level"_a = nb::none(),
          "rows"_a = nb::none(),
          nb::sig("def resize(frame: numpy.typing.NDArray[numpy.uint8], height: int, width: int, "
                  "changes: collections.abc.Sequence[int] | None = None, level: SimdLevel | None = None, "
                  "rows: tuple[int, int] | None = None) -> numpy.typing.NDArray[numpy.uint8]"),
          "A gray frame, (rows, 160), scaled down as by OpenCV's INTER_AREA. `changes` as from `pool_gray`. `rows`:\n"
          "(first, last), to make only result rows first .. last-1.\n"
          "Raises ValueError if the size is not served.");
}
