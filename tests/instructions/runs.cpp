// Counts which handlers of the fast interpreter run one after the other, over all ROMs of a folder, for
// scripts/generate/make-handlers.py. Every ROM counts once. Games that run slowly may be named: each naming counts a
// ROM ten times more. The present superinstructions were chosen with solaris, twice, beam_rider, carnival, centipede,
// darkchambers, frostbite, galaxian, gopher, pitfall2, private_eye and seaquest. Prints "count first second ...", with
// counts per million instructions. It leaves out instructions that the plain interpreter runs, and those after a short
// loop.
//
// usage: runs FOLDER [GAME...] > counts
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "machine/console.hpp"
#include "fast/interpreter/decoder.hpp"
#include "fast/interpreter/decoder.hpp"

namespace {

using namespace atari;

constexpr const char* kNames[] = {
    "kStep",
    "kLoop",
    "kRamCode",
#define SINGLE(operation, operand) #operation "_" #operand,
#define PAIR(...)
#include "fast/interpreter/handlers.def"
};

constexpr size_t kLongest = 24;

using Run = std::vector<uint16_t>;
using Counts = std::map<Run, double>;

void count(const std::filesystem::path& path, double weight, Counts& counts) {
    std::ifstream file(path, std::ios::binary);
    const std::vector<uint8_t> image(std::istreambuf_iterator<char>(file), {});
    const auto cartridge = std::make_shared<const Cartridge>(image, "");
    const bool one_bank = cartridge->type() != CartridgeType::kE0 && cartridge->type() != CartridgeType::kFE;
    Console console(cartridge, ConsoleConfig{});
    console.construct();
    console.reset();
    Counts here;
    double total = 0;
    uint32_t random = 1;
    for (int frame = 0; frame < 600; ++frame) {
        random = random * 1664525 + 1013904223;
        console.inputs().stick[0] = random >> 28;
        console.inputs().fire[0] = (random >> 20 & 3) == 0;
        console.inputs().switches = frame / 10 == 7 ? 0x3e : 0x3f;  // RESET
        console.start_frame();
        Run run;
        uint16_t next = 0;  // address after the last instruction
        for (int i = 0; i < kInstructionLimit; ++i) {
            const Cpu& cpu = console.machine().cpu;
            const uint8_t* bytes = console.image_at(cpu.pc);
            const unsigned in_bank = cartridge->type() == CartridgeType::k2K ? 0x7ff : 0xfff;
            const uint8_t* bank = bytes && one_bank ? bytes - (cpu.pc & in_bank) : nullptr;
            const DecodedInstruction instruction = bytes ? decode(bytes, 3, *cartridge, bank) : DecodedInstruction{};
            const uint16_t now = instruction.handler;
            // Nearly all are skipped.
            const bool loops = is_branch(now) && instruction.jump >= -3 && instruction.jump < 0;
            if (now == kStep || loops || cpu.pc != next || run.size() == kLongest) {
                if (frame >= 100 && run.size() > 1) here[run] += 1;
                run.clear();
            }
            if (now != kStep) run.push_back(now);
            if (frame >= 100) total += 1;
            next = static_cast<uint16_t>(cpu.pc + (bytes ? length_of(kOpcodes[bytes[0]].form) : 1));
            console.run_instruction();
            if (console.machine().cpu.stop || console.machine().cpu.jammed) break;
        }
        console.raw_machine().cpu.stop = false;
    }
    for (const auto& [run, times] : here) counts[run] += weight * 1e6 * times / total;
}

}  // namespace

int main(int number, char** arguments) {
    const std::vector<std::string> slow(arguments + 2, arguments + std::max(number, 2));
    Counts counts;
    std::vector<std::filesystem::path> roms;
    for (const auto& entry : std::filesystem::directory_iterator(arguments[1]))
        if (entry.path().extension() == ".bin") roms.push_back(entry.path());
    std::sort(roms.begin(), roms.end());
    double all = 0;
    for (const auto& rom : roms) {
        const double weight = 1 + 10 * static_cast<double>(std::count(slow.begin(), slow.end(), rom.stem().string()));
        count(rom, weight, counts);
        all += weight;
    }
    for (const auto& [run, times] : counts) {
        if (times < 0.5 * all) continue;
        std::printf("%.1f", times / all);
        for (uint16_t handler : run) std::printf(" %s", kNames[handler]);
        std::printf("\n");
    }
}
