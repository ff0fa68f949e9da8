// Plays programs on a fast console and on a reference console, and compares the two after every frame, without Python,
// so that each platform for which a C++ compiler and an emulator of the processor exist can show that its translated
// code is right. tests/emulator/test_fast_equals_plain.py is the same test, with more events, where Python runs.
//
// usage: fast_equals_plain FILE translated|handlers
//
//   FILE                  the programs, from programs_file.py
//   translated, handlers  whether the fast console runs translated code. The program ends with an error if it cannot.
#include <cstdio>
#include <cstring>
#include <fstream>
#include <memory>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "fast/fast_console.hpp"
#include "game_words.hpp"

namespace atari {
namespace {

constexpr int kFrames = 24;

class Pair {
  public:
    Pair(const Words& words, bool translated) : random_(static_cast<uint32_t>(number(words, "seed"))) {
        const std::vector<uint8_t> image = bytes(text(words, "image"));
        const std::string type = text(words, "cartridge");
        ConsoleConfig config{chance(3) ? 0 : 34,       210,        chance(20), chance(80),
                             {chance(50), chance(50)}, chance(30), chance(30)};
        const auto cartridge = std::make_shared<const FastCartridge>(image, type, translated);
        if (cartridge->translated_code().any() != translated) throw std::runtime_error("no code is translated here");
        consoles_[0] = std::make_unique<FastConsole>(cartridge, config);
        consoles_[1] = std::make_unique<Console>(std::make_shared<const Cartridge>(image, type), config);
        for (auto& console : consoles_) {
            console->construct();
            console->reset();
        }
    }

    // Plays a frame, and returns whether both consoles are then the same.
    bool play() {
        change();
        for (auto& console : consoles_) console->run_frame();
        if (chance(30)) {
            const size_t size = consoles_[0]->config().framebuffer_bytes();
            const uint8_t* const buffers[] = {consoles_[0]->framebuffer(), rendered_by_plain()};
            if (std::memcmp(buffers[0], buffers[1], size) != 0) return false;
        }
        if (chance(20)) return saved(0) == saved(1);
        Machine machines[2];
        for (int i : {0, 1}) std::memcpy(&machines[i], &consoles_[i]->machine(), sizeof(Machine));
        machines[0].tia.collisions = machines[1].tia.collisions;  // the fast console computes them later
        return std::memcmp(&machines[0], &machines[1], sizeof(Machine)) == 0;
    }

  private:
    bool chance(unsigned percent) { return random_() % 100 < percent; }

    // Inputs, resets, changes of RAM, and the state of one console loaded into the other.
    void change() {
        if (chance(5))
            for (auto& console : consoles_) console->reset();
        if (chance(5)) {
            const auto place = static_cast<uint8_t>(random_() % 128), value = static_cast<uint8_t>(random_());
            for (auto& console : consoles_) console->poke_ram(place, value);
        }
        if (chance(5)) {
            const size_t from = random_() % 2;
            consoles_[1 - from]->load(saved(from).data());
        }
        if (chance(20)) {
            Inputs inputs{};
            inputs.switches = static_cast<uint8_t>(random_());
            for (size_t i = 0; i < 2; ++i) {
                inputs.stick[i] = static_cast<uint8_t>(random_() & 15);
                inputs.fire[i] = chance(40);
            }
            for (size_t i = 0; i < 4; ++i) {
                inputs.resistance[i] = static_cast<int32_t>(random_() % 800000);
                inputs.paddle_fire[i] = chance(30);
            }
            for (auto& console : consoles_) console->inputs() = inputs;
        }
    }

    const uint8_t* rendered_by_plain() {
        consoles_[1]->catch_up();
        return consoles_[1]->framebuffer();
    }

    std::vector<uint8_t> saved(size_t which) {
        std::vector<uint8_t> state(consoles_[which]->state_size());
        consoles_[which]->save(state.data());
        return state;
    }

    std::mt19937 random_;
    std::unique_ptr<Console> consoles_[2];  // the fast one and the reference
};

int run(const char* name, bool translated) {
    std::ifstream file(name);
    if (!file) throw std::runtime_error("the file cannot be opened");
    int programs = 0, wrong = 0;
    for (Words words = read_words(file); !words.empty(); words = read_words(file)) {
        Pair pair(words, translated);
        ++programs;
        for (int frame = 1; frame <= kFrames; ++frame) {
            if (pair.play()) continue;
            std::printf("%s: frame %d differs\n", text(words, "name").c_str(), frame);
            ++wrong;
            break;
        }
    }
    std::printf("%d programs of %d frames compared, %d differ\n", programs, kFrames, wrong);
    return programs == 0 || wrong > 0;
}

}  // namespace
}  // namespace atari

int main(int count, char** arguments) {
    const std::string code = count == 3 ? arguments[2] : "";
    if (code != "translated" && code != "handlers")
        return std::fprintf(stderr, "usage: fast_equals_plain FILE translated|handlers\n"), 2;
    try {
        return atari::run(arguments[1], code == "translated");
    } catch (const std::exception& error) {
        return std::fprintf(stderr, "%s: %s\n", arguments[1], error.what()), 2;
    }
}
