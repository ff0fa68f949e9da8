// Code of the arm64 assembler for the tests, on any processor: short sequences by name, as
// tests/emulator/test_assembler_arm64.py describes them in the processor's own language.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "fast/jit/assembler_arm64.hpp"

namespace atari::arm64 {

inline std::map<std::string, std::vector<uint8_t>> instructions() {
    constexpr Reg a = numbered(3), b = numbered(8), base = numbered(20), index = numbered(9);
    const Mem near{base, 5}, field{base, 3732}, below{base, -128}, far{base, 100000}, indexed{base, 0, index},
        scaled{base, 3904, index, 8}, before{base, -127, index};
    const std::map<std::string, std::function<void(Assembler&)>> kSequences = {
        {"move", [=](Assembler& c) { c.move(a, b); }},
        {"move_64", [=](Assembler& c) { c.move64(a, b); }},
        {"move_constants",
         [=](Assembler& c) {
             for (const uint32_t value : {0u, 0x1234u, 0x120000u, 0x12345678u, 0xfffffff0u, 0x12ffffffu})
                 c.move(a, value);
         }},
        {"move_constant_64", [=](Assembler& c) { c.move64(a, uint64_t{0x55000012e124}); }},
        {"loads",
         [=](Assembler& c) {
             c.load8(a, near);
             c.load(a, field);
             c.load64(a, Mem{base, 3816});
             c.load16(a, before);
             c.load8(a, below);
             c.load8(a, far);
             c.load8(a, indexed);
             c.load64(a, scaled);
             c.load(a, Mem{base, 0, index, 4});
         }},
        {"stores",
         [=](Assembler& c) {
             c.store8(near, a);
             c.store8(near, uint8_t{0});
             c.store8(near, uint8_t{7});
             c.store16(before, a);
             c.store(field, a);
             c.store64(Mem{base, 3816}, a);
         }},
        {"two",
         [=](Assembler& c) {
             c.load_two(a, b, Mem{base, 12});
             c.store_two(Mem{base, 20}, a, b);
         }},
        {"addresses",
         [=](Assembler& c) {
             c.address(a, Mem{b, 76});
             c.address(a, Mem{b, -1});
             c.address(a, Mem{b, 0x1234});
             c.address(a, Mem{b, 2, index, 2});
             c.address64(a, Mem{base, 32});
             c.address_before(a, 16);
         }},
        {"arithmetic",
         [=](Assembler& c) {
             c.alu(Alu::add, a, b);
             c.alu(Alu::sub, a, 1);
             c.alu(Alu::and_, a, -0x80);
             c.alu(Alu::or_, a, 0x1280);
             c.alu(Alu::xor_, a, field);
             c.alu64(Alu::sub, a, Mem{base, 3816});
             c.alu8(Alu::and_, near, 0xf7);
             c.multiply(a, b, 76);
         }},
        {"after_a_move",
         [=](Assembler& c) {
             c.move(a, b);
             c.alu(Alu::and_, a, 0x0f);
             c.move(a, b);
             c.shift(ShiftDirection::right, a, 7);
             c.alu(Alu::add, a, 1);
             c.move(a, b);
             c.alu(Alu::add, a, a);
             c.move(a, b);
             c.here();
             c.alu(Alu::sub, a, 1);
         }},
        {"bytes",
         [=](Assembler& c) {
             c.increment8(a);
             c.decrement8(a);
             c.extend8(a, b);
             c.extract(a, b, 10, 4);
             c.shift(ShiftDirection::left, a, 6);
             c.shift64(ShiftDirection::left, a, 4);
             c.shift64(ShiftDirection::right, a, 2);
             c.shift_right_by(a, near, b);
         }},
        {"comparisons",
         [=](Assembler& c) {
             c.compare(a, b);
             c.set(If::above, a);
             c.compare(a, 0x7f);
             c.increment_if_not_below(b);
             c.compare(a, -1);
             c.compare64(a, 0x10010);
             c.compare8(near, a);
             c.compare8(near, uint8_t{0x81});
             c.subtract_and_compare(a, b);
             c.set_if_not_zero(a, near);
             c.shift_in_if_zero8(a, b);
             c.set_bit_7_if_reached(a, b, Mem{base, 3744});
         }},
        {"jumps",
         [=](Assembler& c) {
             JumpLabel label;
             c.test(a);
             c.jump(If::zero, label);
             c.test64(a);
             c.jump(If::not_zero, label);
             c.test8(a);
             c.jump(If::zero, label);
             c.test8(a);
             c.jump(If::sign, label);
             c.test8(a);
             const ShortJump bit = c.jump_short(If::not_sign);
             c.test(a, 0x180);
             c.jump(If::not_zero, label);
             c.test_bit64(a, b);
             c.jump(If::bit_clear, label);
             c.bind_short(bit);
             c.bind(label);
             c.compare(a, b);
             c.jump(If::not_above, label);
             c.jump(label);
             c.call(label);
             c.jump(a);
             c.call(a);
             c.ret();
         }},
        {"add_with_carry", [=](Assembler& c) { c.add_with_carry(a, Byte{{}, near, b}, b, Mem{base, 9}, false); }},
        {"add_constant_with_carry",
         [=](Assembler& c) { c.add_with_carry(a, Byte{uint8_t{0x12}, {}, b}, b, Mem{base, 9}, false); }},
        {"add", [=](Assembler& c) { c.add_with_carry(a, Byte{{}, {}, index}, b, Mem{base, 9}, true); }},
        {"subtract_with_carry",
         [=](Assembler& c) { c.subtract_with_carry(a, Byte{{}, near, b}, b, Mem{base, 9}, false); }},
        {"subtract", [=](Assembler& c) { c.subtract_with_carry(a, Byte{{}, {}, index}, b, Mem{base, 9}, true); }},
        {"subtract8",
         [=](Assembler& c) {
             c.move(a, index);
             c.subtract8(a, Byte{uint8_t{9}, {}, b}, b);
         }},
        {"log",
         [=](Assembler& c) {
             c.append(base, a, 0x1b, b);
             c.add_carry_of(a, b, index);
         }},
        {"stack",
         [=](Assembler& c) {
             c.add_to_stack(-64);
             c.store_pair(base, index, 1);
             c.load_pair(base, index, 3);
             c.add_to_stack(64);
         }},
    };
    std::map<std::string, std::vector<uint8_t>> code;
    for (const auto& [name, emit] : kSequences) {
        Assembler assembler;
        emit(assembler);
        code[name] = assembler.bytes();
    }
    return code;
}

// A jump over `distance` instructions, of an assembler whose jumps reach far or not.
inline std::vector<uint8_t> jump_over(std::size_t distance, bool far) {
    Assembler assembler(far);
    JumpLabel label;
    assembler.test(numbered(3));
    assembler.jump(If::zero, label);
    for (std::size_t i = 0; i < distance; ++i) assembler.ret();
    assembler.bind(label);
    return assembler.bytes();
}

}  // namespace atari::arm64
