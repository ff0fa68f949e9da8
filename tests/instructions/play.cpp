// Plays a game for a number of frames and does nothing else, so that the instruction count of this process is the
// emulator's. The same game, frames and build always take the same number of instructions.
//
// The program is a client that only plays: it includes one header of the emulator, which shows nothing of the machine.
//
// usage: play GAME FRAMES nothing|rgb    "rgb" reads the screen after every frame
//
// GAME is a file of the words of a game (game_words.hpp).
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "game_words.hpp"

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
    if (count != 4) return std::fprintf(stderr, "usage: play GAME FRAMES nothing|rgb\n"), 2;
    try {
        std::ifstream file(arguments[1]);
        const Words words = read_words(file);
        GameDefinition game = game_of(words);
        game.detect_format = false;  // its frames would come before the frames that are counted
        const bool rgb = std::string(arguments[3]) == "rgb";
        std::printf("score %d\n", play(words, make_game(game), std::atoi(arguments[2]), rgb));
    } catch (const std::exception& error) {
        return std::fprintf(stderr, "%s: %s\n", arguments[1], error.what()), 2;
    }
}
