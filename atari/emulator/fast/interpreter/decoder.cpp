#include "decoder.hpp"

#include <algorithm>
#include <array>
#include <compare>
#include <cstddef>

#include "machine/cartridge/cartridge.hpp"

namespace atari {
namespace {

using Type = CartridgeType;
using HandlerTable = std::array<std::array<uint16_t, static_cast<size_t>(Operand::kCount)>, 256>;

// The handler by operation and operand; kStep if there is none.
constexpr HandlerTable kSingles = [] {
    HandlerTable table{};
#define SINGLE(operation, operand) table[operation][static_cast<size_t>(Operand::operand)] = operation##_##operand;
#define PAIR(...)
#include "handlers.def"
    return table;
}();

struct Superinstruction {
    uint16_t first, second, handler;
    auto operator<=>(const Superinstruction&) const = default;
};
constexpr auto kSuperinstructions = [] {
    std::array rows{
#define SINGLE(...)
#define PAIR(o1, k1, o2, k2) Superinstruction{o1##_##k1, o2##_##k2, o1##_##k1##_##o2##_##k2},
#include "handlers.def"
        Superinstruction{kHandlers, kHandlers, kStep},  // sorts after all others
    };
    std::sort(rows.begin(), rows.end());
    return rows;
}();

// Returns the superinstruction of two handlers, or the first handler if there is none.
uint16_t superinstruction_of(uint16_t first, uint16_t second) {
    const auto row =
        std::lower_bound(kSuperinstructions.begin(), kSuperinstructions.end(), Superinstruction{first, second, 0});
    return row->first == first && row->second == second ? row->handler : first;
}

// Returns whether the whole window is one bank of the image.
bool one_bank(Type type) {
    return type != Type::kE0 && type != Type::kE7 && type != Type::kFE && type != Type::k3F && type != Type::k3E &&
           type != Type::kCV;
}

// Returns the size of the parts of the image that are switched as a whole. No instruction is decoded across their ends.
size_t slice_size(Type type) {
    switch (type) {
        case Type::kE0: return 1024;
        case Type::k2K:
        case Type::kE7:
        case Type::k3F:
        case Type::k3E:
        case Type::kCV: return 2048;
        default: return 4096;
    }
}

bool within(unsigned value, Window window) { return value - window.from < window.size; }

// Returns whether an image byte is plain image in every part of the window that can show it.
bool plain_in_image(const Cartridge& cartridge, size_t offset) {
    const Window plain = cartridge.plain_window();
    switch (cartridge.type()) {
        case Type::kE0: return offset < 7168 || within(0xc00 + offset % 1024, plain);  // slice 7 is always the last
        case Type::kE7: return offset >= 14336 && within(0x800 + offset % 2048, plain);
        case Type::k3F:
        case Type::k3E:
        case Type::kCV: return true;  // checked again when the code is entered
        case Type::k2K: return true;
        default: return within(offset % 4096, plain);
    }
}

bool is_ram(uint16_t address) { return (address & 0x1280) == 0x80; }

bool is_timer(uint16_t address) { return (address & 0x1285) == 0x284; }

Operand absolute(uint16_t address, const Cartridge& cartridge, const uint8_t* bank, uint16_t& value) {
    if (is_timer(address)) return Operand::Timer;
    if (is_ram(address)) {
        value = address & 0x7f;
        return Operand::RamA;
    }
    if (!(address & 0x1000)) return Operand::PortA;
    if (cartridge.type() == Type::kDPC && (address & 0xfff) < 0x40) return Operand::Dpc;
    if (cartridge.type() == Type::kFE) {
        value = cartridge.image()[(address & 0xfff) + (address & 0x2000 ? 0 : 4096)];
        return Operand::Fixed;
    }
    if (!bank || !within(address & 0xfff, cartridge.plain_window())) return Operand::PortA;
    value = bank[address & (cartridge.type() == Type::k2K ? 0x7ff : 0xfff)];
    return Operand::Fixed;
}

// Returns whether an indexed operand can only reach plain image. If so, `base` becomes an offset in the bank.
bool reaches_plain_image(uint16_t& base, const Cartridge& cartridge, const uint8_t* bank) {
    if (!bank || (base & 0x1fff) < 0x1000) return false;
    const unsigned offset = base & (cartridge.type() == Type::k2K ? 0x7ff : 0xfff);
    const unsigned end =
        cartridge.type() == Type::k2K ? 0x800 : cartridge.plain_window().from + cartridge.plain_window().size;
    if (offset < cartridge.plain_window().from || offset + 256 > end) return false;
    base = static_cast<uint16_t>(offset);
    return true;
}

bool is_store(Operation operation) { return operation == STA || operation == STX || operation == STY; }

// Returns the kind of a store outside RAM by an address of two bytes.
Operand stored_at(uint16_t& address, const Cartridge& cartridge) {
    if ((address & 0x1080) || cartridge.watches_tia()) return Operand::PortA;
    const uint8_t reg = tia_register(address);
    const Operand kind = stored_in(reg);
    if (kind != Operand::Tia && kind != Operand::Grp0 && kind != Operand::Grp1) return Operand::PortA;
    address = reg;
    return kind == Operand::Tia ? Operand::TiaA : kind == Operand::Grp0 ? Operand::Grp0A : Operand::Grp1A;
}

Operand operand_of(Opcode opcode, uint16_t& operand, const Cartridge& cartridge, const uint8_t* bank) {
    switch (opcode.form) {
        case Imp: return Operand::Imp;
        case Acc: return Operand::Acc;
        case Imm: return Operand::Imm;
        case Rel: return Operand::Rel;
        case Ind: return Operand::Ind;
        case Zp:
            if (operand & 0x80) {
                operand &= 0x7f;
                return Operand::Ram;
            }
            if (cartridge.watches_tia()) return Operand::PortZ;
            if (!is_store(opcode.operation)) return operand & 8 ? Operand::Input : Operand::PortZ;
            if (const Operand kind = stored_in(tia_register(operand)); kind != Operand::PortZ) {
                operand = tia_register(operand);
                return kind;
            }
            return Operand::PortZ;
        case ZpX: return Operand::RamX;
        case ZpY: return Operand::RamY;
        case Abs:
            if (opcode.operation == JMP || opcode.operation == JSR)
                return bank && cartridge.type() != Type::k2K && (operand & 0x1000) &&
                               within(operand & 0xfff, cartridge.plain_window())
                           ? Operand::Near
                           : Operand::Far;
            if (is_store(opcode.operation) && !is_ram(operand)) return stored_at(operand, cartridge);
            return absolute(operand, cartridge, bank, operand);
        case AbsX:
        case AbsY: {
            const bool plain = !is_store(opcode.operation) && reaches_plain_image(operand, cartridge, bank);
            if (opcode.form == AbsX) return plain ? Operand::RomX : Operand::AnyX;
            return plain ? Operand::RomY : Operand::AnyY;
        }
        case IndX: return Operand::IndX;
        default: return Operand::IndY;
    }
}

// Returns the number of bytes at the end of a slice or of RAM in which this operation is not decoded. The byte after
// that end may belong to TIA space. A program there reads the data bus, and collisions up to the clock at which the
// last write shows. Handlers do not log a write that changes nothing. A write shows at most eight clocks later. In that
// time a program runs at most one instruction after a store, of two cycles and at most two bytes.
int undecoded_after(Operation operation) { return is_store(operation) || operation == PHA || operation == PHP ? 3 : 1; }

bool is_expiry(uint16_t address) { return (address & 0x1285) == 0x285; }

// Returns the loop that these three successive instructions begin.
Loop loop_of(const DecodedInstruction& first, const DecodedInstruction& second, const DecodedInstruction& third) {
    const auto either = [](uint16_t handler, auto... of) { return ((handler == of) || ...); };
    const auto counts = [&](const DecodedInstruction& step, const DecodedInstruction& branch) {
        return either(step.handler, DEX_Imp, DEY_Imp) && either(branch.handler, BNE_Rel, BPL_Rel);
    };
    if (counts(first, second) && second.jump == -1) return first.handler == DEX_Imp ? Loop::kCountX : Loop::kCountY;
    if (either(first.handler, STA_Wsync, STX_Wsync, STY_Wsync) && counts(second, third) && third.jump == -3)
        return second.handler == DEX_Imp ? Loop::kLinesX : Loop::kLinesY;
    if (first.handler == SBC_Imm && second.handler == BCS_Rel && second.jump == -2) return Loop::kDivide;
    if (second.jump != -3) return Loop::kNone;
    if (either(first.handler, LDA_Timer, LDX_Timer, LDY_Timer) && either(second.handler, BNE_Rel, BPL_Rel, BMI_Rel))
        return Loop::kTimer;
    const bool reads_expiry =
        either(first.handler, LDA_PortA, LDX_PortA, LDY_PortA, BIT_PortA) && is_expiry(first.operand);
    return reads_expiry && second.handler == BPL_Rel ? Loop::kExpiry : Loop::kNone;
}

// Returns the cycles of one round; for a loop with WSYNC, of the instructions after WSYNC.
int round_cycles(Loop loop, const DecodedInstruction& second, const DecodedInstruction& third) {
    switch (loop) {
        case Loop::kLinesX:
        case Loop::kLinesY: return 2 + third.taken;
        case Loop::kTimer:
        case Loop::kExpiry: return 4 + second.taken;
        default: return 2 + second.taken;
    }
}

}  // namespace

bool is_branch(uint16_t handler) {
    return handler == BCC_Rel || handler == BCS_Rel || handler == BEQ_Rel || handler == BMI_Rel || handler == BNE_Rel ||
           handler == BPL_Rel || handler == BVC_Rel || handler == BVS_Rel;
}

DecodedInstruction decode(const uint8_t* bytes, int available, const Cartridge& cartridge, const uint8_t* bank) {
    DecodedInstruction instruction{nullptr, kStep, 0, 0, 0, Loop::kNone};
    const Opcode opcode = kOpcodes[bytes[0]];
    const int length = length_of(opcode.form);
    if (length + undecoded_after(opcode.operation) > available) return instruction;
    uint16_t operand = length > 1 ? bytes[1] : 0;
    if (length > 2) operand = static_cast<uint16_t>(operand | bytes[2] << 8);
    if (opcode.form == Rel) {
        const int distance = static_cast<int8_t>(bytes[1]);
        instruction.jump = static_cast<int16_t>(2 + distance);
        // `bytes` gives only the position in a bank. Its low eight bits decide whether a branch crosses a page.
        instruction.operand = static_cast<uint16_t>(distance & 0xff);
        instruction.handler = kSingles[opcode.operation][static_cast<size_t>(Operand::Rel)];
        return instruction;
    }
    const Operand kind = operand_of(opcode, operand, cartridge, bank);
    if (kind == Operand::IndY) {
        if (!pointer_in_ram(operand)) return instruction;
        operand &= 0x7f;
    }
    instruction.operand = operand;
    instruction.handler = kSingles[opcode.operation][static_cast<size_t>(kind)];
    return instruction;
}

std::vector<DecodedInstruction> decode_image(const Cartridge& cartridge) {
    const size_t size = cartridge.size(), slice = slice_size(cartridge.type());
    const uint8_t* image = cartridge.image();
    std::vector<DecodedInstruction> decoded(size + 1, DecodedInstruction{nullptr, kStep, 0, 0, 0, Loop::kNone});
    const auto decodable = [&](size_t first, size_t from, size_t to) {
        if (to >= first + slice || first + slice > size) return false;
        for (size_t i = from; i < to; ++i)
            if (!plain_in_image(cartridge, i)) return false;
        return true;
    };
    for (size_t i = 0; i < size; ++i) {
        const size_t first = i - i % slice;
        const int length = length_of(kOpcodes[image[i]].form);
        if (!decodable(first, i, i + static_cast<size_t>(length))) continue;
        const uint8_t* const bank = one_bank(cartridge.type()) ? image + first : nullptr;
        DecodedInstruction instruction = decode(image + i, static_cast<int>(first + slice - i), cartridge, bank);
        const size_t next = i + static_cast<size_t>(length);
        if (is_branch(instruction.handler)) {
            const auto target = static_cast<std::ptrdiff_t>(i) + instruction.jump;
            if (target < static_cast<std::ptrdiff_t>(first) ||
                !decodable(first, static_cast<size_t>(target), static_cast<size_t>(target) + 1))
                continue;
            instruction.taken = ((static_cast<size_t>(target) ^ next) & 0xff00) ? 4 : 3;
        } else if (instruction.handler == JMP_Near || instruction.handler == JSR_Near) {
            instruction.jump =
                static_cast<int16_t>(static_cast<int>(instruction.operand & 0xfff) - static_cast<int>(i - first));
        }
        decoded[i] = instruction;
    }
    // Chooses loops and superinstructions. The second instruction of a superinstruction keeps its own decoded
    // instruction.
    const std::vector<DecodedInstruction> plain = decoded;
    const auto after = [&](size_t i) { return i + static_cast<size_t>(length_of(kOpcodes[image[i]].form)); };
    for (size_t i = 0; i < size; ++i) {
        if (plain[i].handler == kStep) continue;
        const size_t second = after(i), third = plain[second].handler == kStep ? size : after(second);
        const uint16_t handler = superinstruction_of(plain[i].handler, plain[second].handler);
        const Loop loop = loop_of(plain[i], plain[second], plain[third]);
        decoded[i].handler = handler;
        if (loop == Loop::kNone) continue;
        decoded[i].handler = kLoop;
        decoded[i].loop = loop;
        decoded[i].jump = static_cast<int16_t>(handler);
        decoded[i].taken = static_cast<uint8_t>(round_cycles(loop, plain[second], plain[third]));
    }
    for (DecodedInstruction& instruction : decoded) instruction.code = code_of(instruction.handler);
    return decoded;
}

}  // namespace atari
