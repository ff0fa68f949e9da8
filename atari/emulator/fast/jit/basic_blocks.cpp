#include "basic_blocks.hpp"

#include <algorithm>

#include "fast/interpreter/handlers.hpp"

namespace atari {
namespace {

// --- the instructions of an image ---

struct Found {
    std::vector<bool> is_instruction, is_leader;
};

constexpr bool ends_block(Operation operation) { return operation == JMP || operation == RTS; }

class Finder {
  public:
    Finder(const uint8_t* image, const std::vector<DecodedInstruction>& decoded)
        : image_(image), decoded_(decoded), size_(decoded.size() - 1), covered_(size_ + 3),
          found_{std::vector<bool>(size_ + 1), std::vector<bool>(size_ + 1)} {}

    // Finds first the code that is reached from the start of a bank, then everything else that can be decoded. The rest
    // is code that is reached through tables, and data, which never runs. Handlers run the instructions that are not
    // found.
    Found find() {
        const std::size_t bank_size = std::min<std::size_t>(size_, 4096);
        for (std::size_t bank = 0; bank + bank_size <= size_; bank += bank_size) {
            const uint8_t* const vector = image_ + bank + bank_size - 4;
            reach(bank + (vector[0] | std::size_t{vector[1]} << 8) % bank_size);
        }
        for (std::size_t place = 0; place < size_; ++place)
            if (!covered_[place]) reach(place);
        return std::move(found_);
    }

  private:
    // Finds the instructions from here on, and those that they branch to, up to instructions that were found before.
    void reach(std::size_t first) {
        std::vector<std::size_t> pending{first};
        while (!pending.empty()) {
            std::size_t place = pending.back();
            pending.pop_back();
            while (!found_.is_instruction[place] && decoded_[place].handler != kStep) {
                found_.is_instruction[place] = true;
                const auto [operation, operand] = kind_of(decoded_[place]);
                if (operand == Operand::Rel || operand == Operand::Near) {
                    const std::size_t target = target_place(decoded_, place);
                    found_.is_leader[target] = true;
                    pending.push_back(target);
                }
                const std::size_t next = next_place(decoded_, place);
                for (std::size_t byte = place; byte < next; ++byte) covered_[byte] = true;
                if (ends_block(operation)) break;
                if (operation == JSR) found_.is_leader[next] = true;
                place = next;
            }
        }
    }

    const uint8_t* const image_;
    const std::vector<DecodedInstruction>& decoded_;
    const std::size_t size_;
    std::vector<bool> covered_;
    Found found_;
};

// --- properties of an instruction ---

// clang-format off
constexpr bool is_read_inline(Operand operand) {
    switch (operand) {
        case Operand::Imm: case Operand::Fixed: case Operand::Ram: case Operand::RamA: case Operand::RamX:
        case Operand::RamY: case Operand::Input: case Operand::RomX: case Operand::RomY: case Operand::Timer:
        case Operand::AnyX: case Operand::AnyY: case Operand::IndY: case Operand::Dpc:
            return true;
        default: return false;
    }
}

constexpr bool is_implied_inline(int op) {
    switch (op) {
        case TAX: case TAY: case TXA: case TYA: case INX: case INY: case DEX: case DEY: case CLD: case SED: case NOP:
        case CLC: case SEC: case CLV: case TXS: case TSX: case PHA: case PLA:
            return true;
        default: return false;
    }
}

// clang-format on
constexpr bool is_inlined(Kind kind) {
    const auto [operation, operand] = kind;
    if (operand == Operand::Rel || operation == JMP || operation == JSR || operation == RTS) return true;
    if (is_read(operation)) return is_read_inline(operand);
    if (is_store(operation)) return is_stored_inline(operand);
    if (is_modify(operation)) return operand == Operand::Acc || operand == Operand::Ram || operand == Operand::RamX;
    return is_implied_inline(operation);
}

constexpr bool sets_nz(int op) {
    return is_read(op) || is_modify(op) || op == TAX || op == TAY || op == TXA || op == TYA || op == TSX || op == INX ||
           op == INY || op == DEX || op == DEY || op == PLA;
}

// Returns the register whose value an inlined instruction leaves in N and Z; none if N and Z depend on something else.
// clang-format off
constexpr std::optional<CpuRegister> nz_register(Kind kind) {
    switch (kind.operation) {
        case LDA: case AND: case ORA: case EOR: case ADC: case SBC: case TXA: case TYA: case PLA: return CpuRegister::A;
        case LDX: case TAX: case TSX: case INX: case DEX: return CpuRegister::X;
        case LDY: case TAY: case INY: case DEY: return CpuRegister::Y;
        case ASL: case LSR: case ROL: case ROR:
            if (kind.operand == Operand::Acc) return CpuRegister::A;
            return {};
        default: return {};
    }
}
// clang-format on

// Returns whether translated code runs this without reading or changing N and Z.
constexpr bool leaves_nz(Kind kind) {
    if (is_store(kind.operation)) return is_stored_inline(kind.operand);
    const int op = kind.operation;
    return op == CLC || op == SEC || op == CLV || op == CLD || op == SED || op == NOP || op == TXS || op == PHA;
}

constexpr bool changes_carry(int op) {
    return op == ADC || op == SBC || op == CMP || op == CPX || op == CPY || op == PLP || is_modify(op);
}

// Returns the cycles of an inlined instruction that does not jump, without page crossings.
constexpr int32_t base_cycles(Kind kind) {
    if (is_read(kind.operation)) return static_cast<int32_t>(read_cost(kind.operand));
    if (is_store(kind.operation)) return static_cast<int32_t>(store_cost(kind.operand));
    if (is_modify(kind.operation)) return static_cast<int32_t>(modify_cost(kind.operand));
    return kind.operation == PHA ? 3 : kind.operation == PLA ? 4 : 2;
}

Kind kind_of(const BlockInstruction& instruction) { return {instruction.operation, instruction.operand}; }

// --- the states ---

// N and Z are computed only if something can read them. A handler that is called in between gets them.
void find_omitted_nz(std::vector<BlockInstruction>& instructions) {
    bool replaced = false;  // by a later instruction of the block, before anything reads them
    for (auto at = instructions.rbegin(); at != instructions.rend(); ++at) {
        at->omits_nz = replaced && at->is_inlined && nz_register(kind_of(*at));
        replaced = sets_nz(at->operation) || (replaced && leaves_nz(kind_of(*at)));
    }
    std::optional<CpuRegister> omitted;
    for (BlockInstruction& at : instructions) {
        if (sets_nz(at.operation)) omitted.reset();
        at.entry.nz = omitted;
        if (at.omits_nz) omitted = nz_register(kind_of(at));
    }
}

// ADC after CLC and SBC after SEC do not read the carry, provided that the instructions between are reached from CLC or
// SEC.
void find_known_carry(std::vector<BlockInstruction>& instructions) {
    std::optional<bool> carry;
    std::size_t since = 0;  // the instruction after the CLC or SEC
    for (std::size_t i = 0; i < instructions.size(); ++i) {
        const BlockInstruction& at = instructions[i];
        const bool adds = at.operation == ADC;
        if ((adds || at.operation == SBC) && at.is_inlined && carry && *carry != adds)
            for (std::size_t k = since; k <= i; ++k) instructions[k].entry.carry = carry;
        if (at.operation == CLC || at.operation == SEC) {
            carry = at.operation == SEC;
            since = i + 1;
        } else if (is_jump(at.operation) || at.operand == Operand::Rel || changes_carry(at.operation)) {
            carry.reset();
        }
    }
}

int32_t cycles_after(const BlockInstruction& at) {
    // Handlers and jumps add all cycles, and WSYNC replaces them.
    if (!at.is_inlined || is_jump(at.operation) || at.operand == Operand::Wsync) return 0;
    const int32_t before = at.loops ? 0 : at.entry.cycles;  // skipping rounds of a loop adds them
    return before + base_cycles(kind_of(at));
}

void count_cycles(std::vector<BlockInstruction>& instructions) {
    int32_t cycles = 0;
    for (BlockInstruction& at : instructions) {
        at.entry.cycles = cycles;
        cycles = at.cycles_after = cycles_after(at);
    }
}

BlockInstruction describe(const std::vector<DecodedInstruction>& decoded, std::size_t place) {
    const DecodedInstruction& instruction = decoded[place];
    const Kind kind = kind_of(instruction);
    return {place, kind.operation, kind.operand, instruction.operand, instruction.handler == kLoop, is_inlined(kind),
            {}};
}

}  // namespace

std::size_t next_place(const std::vector<DecodedInstruction>& decoded, std::size_t place) {
    return place + static_cast<std::size_t>(length_of(kind_of(decoded[place]).operand));
}

std::size_t target_place(const std::vector<DecodedInstruction>& decoded, std::size_t place) {
    return static_cast<std::size_t>(static_cast<std::ptrdiff_t>(place) + decoded[place].jump);
}

std::vector<Block> find_blocks(const uint8_t* image, const std::vector<DecodedInstruction>& decoded) {
    const Found found = Finder(image, decoded).find();
    std::vector<bool> in_block(decoded.size());
    std::vector<Block> blocks;
    for (std::size_t first = 0; first + 1 < decoded.size(); ++first) {
        // Splits the code from a leader on into successive blocks.
        for (std::size_t place = first; found.is_instruction[place] && !in_block[place];) {
            if (place == first || found.is_leader[place]) {
                if (place != first) blocks.back().falls_through = true;
                blocks.emplace_back();
            }
            Block& block = blocks.back();
            block.instructions.push_back(describe(decoded, place));
            in_block[place] = true;
            block.next = next_place(decoded, place);
            block.ends_in_jump = ends_block(block.instructions.back().operation);
            if (block.ends_in_jump) break;
            place = block.next;
        }
    }
    for (Block& block : blocks) {
        find_omitted_nz(block.instructions);
        find_known_carry(block.instructions);
        count_cycles(block.instructions);
    }
    return blocks;
}

}  // namespace atari
