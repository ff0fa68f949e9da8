#include "writes.hpp"

#include <algorithm>
#include <bit>
#include <stdexcept>
#include <utility>

#include "evaluate.hpp"

namespace atari {
namespace {

// The data that the program of a write reads. If `own` is an index, the byte of that index is `variables[kLabelByte]`.
struct Host : PassiveHost {
    const uint8_t* ram;
    const uint8_t* cartridge_ram;  // may be null
    WriteState& state;
    int32_t variables[kWriteVariables]{};
    int own = -1;

    Host(const Console& console, WriteState& state)
        : ram(console.ram()), cartridge_ram(console.cartridge_ram_size() >= 128 ? console.cartridge_ram() : nullptr),
          state(state) {}
    Host(const uint8_t* ram, WriteState& state) : ram(ram), cartridge_ram(nullptr), state(state) {}

    int64_t byte(int64_t address) const {
        const int index = static_cast<int>(address & 0x7f);
        return index == own ? variables[kLabelByte] : ram[index];
    }
    int64_t xbyte(int64_t address) const { return cartridge_ram ? cartridge_ram[address & 0x7f] : 0; }
    uint32_t random() { return state.next(); }

    int32_t result(const Program& program) {
        evaluate(program, *this);
        return variables[kResult];
    }
};

// Returns the value of the write's label if its byte were `byte`.
int32_t label_value(const Write& write, Host& host, uint8_t byte) {
    if (!write.label_values.empty()) return write.label_values[byte];
    host.own = write.index;
    host.variables[kLabelByte] = byte;
    const int32_t value = host.result(write.label);
    host.own = -1;
    return value;
}

// Returns the byte that a write stores, or -1 if the label cannot have the value. If several bytes give the label the
// value, the fewest changed bits decide, then the lowest byte, as in Labels::byte_of.
int target_byte(const Write& write, Host& host, uint8_t now, int32_t value) {
    if (!write.of_label) return (now & ~write.mask) | (value & write.mask);
    if (label_value(write, host, now) == value) return now;
    int best = -1, fewest = 9;
    for (int byte = 0; byte < 256; ++byte) {
        const int changes = std::popcount(static_cast<unsigned>(byte ^ now));
        if (((byte ^ now) & ~write.mask) != 0 || changes >= fewest) continue;
        if (label_value(write, host, static_cast<uint8_t>(byte)) != value) continue;
        best = byte;
        fewest = changes;
    }
    return best;
}

bool due(const Write& write, int32_t frame) {
    return write.every_frame || std::binary_search(write.frames.begin(), write.frames.end(), frame);
}

}  // namespace

void Write::prepare() {
    if (index < 0 || index > 127 || mask == 0) throw std::invalid_argument("a write needs a byte 0..127 and a mask");
    std::sort(frames.begin(), frames.end());
    // A label's program that reads no RAM does not depend on the console: it runs once for each byte.
    if (!of_label || label.reads_ram()) return;
    const uint8_t ram[128]{};
    WriteState state{};
    Host host{ram, state};
    std::vector<int32_t> values;
    for (int byte = 0; byte < 256; ++byte) values.push_back(label_value(*this, host, static_cast<uint8_t>(byte)));
    label_values = std::move(values);
}

void WriteState::seed(uint32_t value) {
    random[0] = value;
    random[1] = 0x61746172;  // any constant: the streams of small seeds differ after the first step
    next();
    next();
}

uint32_t WriteState::next() {
    const uint64_t state = random[0] | uint64_t{random[1]} << 32;
    const uint64_t after = state * 6364136223846793005u + 1442695040888963407u;
    random[0] = static_cast<uint32_t>(after);
    random[1] = static_cast<uint32_t>(after >> 32);
    const auto mixed = static_cast<uint32_t>(((state >> 18) ^ state) >> 27);
    const auto turns = static_cast<uint32_t>(state >> 59);
    return mixed >> turns | mixed << (-turns & 31);
}

int Writes::add(std::shared_ptr<const Write> write, WriteState& state) {
    const auto place = std::find(slots_.begin(), slots_.end(), nullptr);
    const int slot = static_cast<int>(place - slots_.begin());
    if (slot == kMaxWrites) return -1;
    if (place == slots_.end()) slots_.push_back(std::move(write));
    else *place = std::move(write);
    state.done[slot >> 5] &= ~(1u << (slot & 31));
    return slot;
}

int Writes::remove(const Write* write) {
    const auto place =
        std::find_if(slots_.begin(), slots_.end(), [&](const auto& slot) { return slot.get() == write; });
    if (place == slots_.end()) return -1;
    const int slot = static_cast<int>(place - slots_.begin());
    *place = nullptr;
    while (!slots_.empty() && !slots_.back()) slots_.pop_back();
    return slot;
}

void Writes::begin_frame(const Console& console, WriteState& state) {
    for (size_t slot = 0; slot < slots_.size(); ++slot) {
        const Write* const write = slots_[slot].get();
        if (!write || !write->remembers) continue;
        Host host(console, state);
        const uint8_t byte = console.ram()[write->index];
        old_[slot] = write->of_label ? label_value(*write, host, byte) : byte & write->mask;
    }
}

template <typename Chosen>
bool Writes::apply_if(Chosen&& chosen, Console& console, WriteState& state, int32_t frame) {
    bool changed = false;
    for (size_t slot = 0; slot < slots_.size(); ++slot)
        if (const Write* const write = slots_[slot].get(); write && chosen(*write))
            changed |= apply(*write, static_cast<int>(slot), console, state, frame);
    return changed;
}

bool Writes::apply(Console& console, WriteState& state, int32_t frame, bool paid) {
    return apply_if([&](const Write& write) { return write.paid == paid && due(write, frame); }, console, state, frame);
}

bool Writes::apply_at_reset(Console& console, WriteState& state) {
    begin_frame(console, state);
    return apply_if([](const Write& write) { return write.at_reset; }, console, state, 0);
}

bool Writes::apply_now(int slot, Console& console, WriteState& state, int32_t frame) {
    begin_frame(console, state);
    return apply(*slots_[static_cast<size_t>(slot)], slot, console, state, frame);
}

bool Writes::apply(const Write& write, int slot, Console& console, WriteState& state, int32_t frame) {
    uint32_t& done = state.done[slot >> 5];
    const uint32_t bit = 1u << (slot & 31);
    if (write.once && done & bit) return false;
    const uint8_t now = console.ram()[write.index];
    Host host(console, state);
    host.variables[kOld] = write.remembers ? old_[slot] : 0;
    host.variables[kFrame] = frame;
    if (write.conditional && !host.result(write.condition)) return false;
    done |= write.once ? bit : 0;
    const int byte = target_byte(write, host, now, host.result(write.value));
    if (byte < 0 || byte == now) return false;
    console.poke_ram(static_cast<uint8_t>(0x80 + write.index), static_cast<uint8_t>(byte));
    return true;
}

}  // namespace atari
