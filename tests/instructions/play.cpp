// Plays a game for a number of frames and does nothing else, so that the instruction count of this process is the
// emulator's. The same game, frames and build always take the same number of instructions.
//
// The program is a client that only plays: it includes one header of the emulator, which shows nothing of the machine.
//
// usage: play ROM GAME FRAMES nothing|rgb    "rgb" reads the screen after every frame
//
// GAME is a file of the arguments of `make_game` (atari/_emulator.pyi), a line of words for each argument: its name,
// then its values. counting.py writes the file.
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "ale/environment.hpp"

namespace atari {

class Console;
class FastConsole;
class ResetTrace;
struct Machine;

namespace {

template <typename T>
concept Complete = requires { sizeof(T); };
static_assert(!Complete<Console> && !Complete<FastConsole> && !Complete<Machine> && !Complete<ResetTrace> &&
                  !Complete<Game> && !Complete<Environment::Parts>,
              "ale/environment.hpp shows what is inside of an environment");

using Words = std::map<std::string, std::vector<std::string>>;

Words read_words(const char* path) {
    Words words;
    std::ifstream file(path);
    for (std::string line; std::getline(file, line);) {
        std::istringstream stream(line);
        std::string name;
        stream >> name;
        words[name].assign(std::istream_iterator<std::string>(stream), {});
    }
    return words;
}

std::vector<int32_t> numbers(const Words& words, const std::string& name) {
    std::vector<int32_t> values;
    for (const std::string& word : words.at(name)) values.push_back(std::stoi(word));
    return values;
}

std::shared_ptr<const Game> load_game(const char* rom, const Words& words) {
    std::ifstream file(rom, std::ios::binary);
    const auto number = [&](const char* name) { return numbers(words, name).at(0); };
    const auto text = [&](const char* name) { return words.at(name).empty() ? "" : words.at(name)[0]; };
    GameDefinition game;
    game.image.assign(std::istreambuf_iterator<char>(file), {});
    game.cartridge = text("cartridge");
    game.format = text("format");
    game.first_line = number("first_line");
    game.height = number("height");
    game.hmove_blanks = number("hmove_blanks") != 0;
    for (int jack : {0, 1}) game.paddles[jack] = numbers(words, "paddles").at(static_cast<size_t>(jack)) != 0;
    game.swap_ports = number("swap_ports") != 0;
    game.swap_paddles = number("swap_paddles") != 0;
    game.detect_format = false;  // its frames would come before the frames that are counted
    game.starting_actions = numbers(words, "starting_actions");
    game.default_mode = number("default_mode");
    game.variables = number("variables");
    game.initial = numbers(words, "initial");
    for (int keep : numbers(words, "kept")) game.kept.push_back(keep != 0);
    const std::vector<int32_t> outputs = numbers(words, "outputs");
    game.terminal = outputs.at(0);
    game.mode_variable = outputs.at(1);
    game.rewards[0] = outputs.at(2);
    game.lives[0] = outputs.at(3);
    game.step = numbers(words, "step");
    game.select_mode = numbers(words, "select_mode");
    return make_game(game);
}

int play(const Words& words, std::shared_ptr<const Game> game, int frames, bool rgb) {
    Environment environment(std::move(game), Settings{}, 0);
    const std::vector<int32_t> actions = numbers(words, "minimal_actions");
    std::vector<uint8_t> pixels(static_cast<size_t>(environment.height()) * Environment::kWidth * 3);
    uint32_t random = 1;
    int total = 0;
    for (int frame = 0; frame < frames; ++frame) {
        if (environment.game_over()) environment.reset();
        random = 1664525 * random + 1013904223;
        total += environment.act({actions.at((random >> 16) % actions.size())})[0];
        if (rgb) environment.screen_rgb(pixels.data());
    }
    return total;
}

}  // namespace
}  // namespace atari

int main(int count, char** arguments) {
    using namespace atari;
    if (count != 5) return std::fprintf(stderr, "usage: play ROM GAME FRAMES nothing|rgb\n"), 2;
    try {
        const Words words = read_words(arguments[2]);
        const bool rgb = std::string(arguments[4]) == "rgb";
        std::printf("score %d\n", play(words, load_game(arguments[1], words), std::atoi(arguments[3]), rgb));
    } catch (const std::exception& error) {
        return std::fprintf(stderr, "%s: %s\n", arguments[2], error.what()), 2;
    }
}
