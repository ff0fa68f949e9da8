// Plays the golden values of ale-py (tests/conformance/goldens.json) without Python, so that each platform for which a
// C++ compiler and an emulator of the processor exist can show that its build is exact: RAM, screen, sound, rewards,
// lives and frame numbers of all games.
//
// usage: goldens FILE fast|plain [save STATES | load STATES] [GAME ...]
//
//   FILE         the games, their ROM images and their golden values, from goldens_file.py
//   fast, plain  the core: the fast one or the reference core
//   save STATES  write each game's state in the middle of the generated actions
//   load STATES  play only the second half of the generated actions, from the states that another build has saved
//   GAME ...     only these games
#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "crc32.hpp"
#include "fast/simd.hpp"
#include "game_words.hpp"

namespace atari {
namespace {

constexpr int kActions = 1000;
constexpr int kMiddle = kActions / 2;

// The sums of a game in play, which a saved state carries to the program that goes on.
struct Sums {
    uint32_t random = 1;
    int32_t reward = 0;
    int32_t resets = 0;
    std::array<uint32_t, 3> chain{};  // RAM, screen, sound of all frames so far
};

class GoldenGame {
  public:
    GoldenGame(const Words& words, bool plain)
        : words_(words), stand_in_(number(words, "stand_in") != 0), game_(make_game(game_of(words))) {
        settings_.repeat_action_probability = 0;
        settings_.sound = true;
        settings_.plain = plain;
        actions_ = numbers(words, "minimal_actions");
        begin();
    }

    // A fresh machine.
    void begin() {
        environment_ = std::make_unique<Environment>(game_, settings_, 123);
        screen_.resize(static_cast<size_t>(environment_->height()) * Environment::kWidth);
        sums_ = {};
    }

    void play_noops() {
        compare("noop_0", described(false));
        for (int frame = 1; frame <= kActions; ++frame) {
            act(0);
            const std::string name = "noop_" + std::to_string(frame);
            if (words_.contains(name)) compare(name, described(true));
        }
    }

    void play_generated_actions(int begin, int end) {
        for (int i = begin; i < end; ++i) {
            if (environment_->game_over()) {
                environment_->reset();
                ++sums_.resets;
            }
            sums_.random = 1664525 * sums_.random + 1013904223;
            act(actions_.at((sums_.random >> 16) % actions_.size()));
        }
    }

    void compare_generated_actions() {
        std::vector<std::string> seen = described(true);
        if (!stand_in_) seen.push_back(std::to_string(sums_.resets));
        seen.push_back(std::to_string(environment_->frame_number()));
        seen.push_back(std::to_string(environment_->episode_frame_number()));
        compare("random", seen);
    }

    void save(std::ostream& file) {
        std::vector<uint8_t> state(environment_->state_size());
        environment_->save(state.data());
        const uint64_t size = state.size();
        file.write(reinterpret_cast<const char*>(&sums_), sizeof sums_);
        file.write(reinterpret_cast<const char*>(&size), sizeof size);
        file.write(reinterpret_cast<const char*>(state.data()), static_cast<std::streamsize>(size));
    }

    void load(std::istream& file) {
        uint64_t size = 0;
        file.read(reinterpret_cast<char*>(&sums_), sizeof sums_);
        file.read(reinterpret_cast<char*>(&size), sizeof size);
        if (size != environment_->state_size()) throw std::runtime_error("the saved state has another size");
        std::vector<uint8_t> state(size);
        file.read(reinterpret_cast<char*>(state.data()), static_cast<std::streamsize>(size));
        if (!file || !environment_->load(state.data())) throw std::runtime_error("the saved state is refused");
    }

    int compared() const { return compared_; }
    int wrong() const { return wrong_; }

  private:
    void act(int action) {
        sums_.reward += environment_->act({action})[0];
        environment_->screen(screen_.data());
        sums_.chain[0] = crc32(sums_.chain[0], environment_->ram(), 128);
        sums_.chain[1] = crc32(sums_.chain[1], screen_.data(), screen_.size());
        sums_.chain[2] = crc32(sums_.chain[2], environment_->audio(), 512);
    }

    // The words of goldens_file.py for the present state.
    std::vector<std::string> described(bool with_history) {
        environment_->screen(screen_.data());
        std::vector<std::string> seen{hex(crc32(0, environment_->ram(), 128)),
                                      hex(crc32(0, screen_.data(), screen_.size())),
                                      hex(crc32(0, environment_->audio(), 512))};
        if (with_history) {
            for (const uint32_t sum : sums_.chain) seen.push_back(hex(sum));
        }
        if (stand_in_) return seen;
        seen.push_back(std::to_string(environment_->lives()));
        seen.push_back(std::to_string(environment_->game_over()));
        if (with_history) seen.push_back(std::to_string(sums_.reward));
        return seen;
    }

    void compare(const std::string& name, const std::vector<std::string>& seen) {
        const std::vector<std::string>& golden = words_.at(name);
        ++compared_;
        if (seen == golden) return;
        ++wrong_;
        std::printf("%s: %s differs\n", words_.at("game").at(0).c_str(), name.c_str());
        for (size_t i = 0; i < std::max(seen.size(), golden.size()); ++i) {
            const auto word = [i](const auto& words) { return i < words.size() ? words[i].c_str() : "nothing"; };
            std::printf("  value %zu: %s, golden: %s\n", i, word(seen), word(golden));
        }
    }

    static std::string hex(uint32_t value) {
        char text[9];
        std::snprintf(text, sizeof text, "%08x", static_cast<unsigned>(value));
        return text;
    }

    Words words_;
    bool stand_in_;  // a cartridge for two players, under the rules of another game: its rewards have no meaning
    std::shared_ptr<const Game> game_;
    Settings settings_;
    std::vector<int32_t> actions_;
    std::unique_ptr<Environment> environment_;
    std::vector<uint8_t> screen_;
    Sums sums_;
    int compared_ = 0, wrong_ = 0;
};

int run(const std::vector<std::string>& arguments) {
    const std::string job =
        arguments.size() > 3 && (arguments[2] == "save" || arguments[2] == "load") ? arguments[2] : "";
    const std::vector<std::string> chosen(arguments.begin() + (job.empty() ? 2 : 4), arguments.end());
    std::ifstream file(arguments[0]);
    std::fstream states;
    if (!job.empty()) states.open(arguments[3], std::ios::binary | (job == "save" ? std::ios::out : std::ios::in));
    if (!file || (!job.empty() && !states)) throw std::runtime_error("a file cannot be opened");
    int games = 0, compared = 0, wrong = 0;
    for (Words words = read_words(file); !words.empty(); words = read_words(file)) {
        if (!chosen.empty() && std::ranges::find(chosen, words.at("game").at(0)) == chosen.end()) continue;
        GoldenGame game(words, arguments[1] == "plain");
        if (job == "load") {
            game.load(states);
        } else {
            game.play_noops();
            game.begin();
            game.play_generated_actions(0, kMiddle);
            if (job == "save") game.save(states);
        }
        game.play_generated_actions(kMiddle, kActions);
        game.compare_generated_actions();
        ++games;
        compared += game.compared();
        wrong += game.wrong();
    }
    std::printf("%d games, %d golden values compared, %d differ\n", games, compared, wrong);
    return games == 0 || wrong > 0;
}

}  // namespace
}  // namespace atari

int main(int count, char** arguments) {
    if (count < 3 || (std::string(arguments[2]) != "fast" && std::string(arguments[2]) != "plain")) {
        return std::fprintf(stderr, "usage: goldens FILE fast|plain [save STATES | load STATES] [GAME ...]\n"), 2;
    }
    try {
        atari::check_simd_level();
        return atari::run({arguments + 1, arguments + count});
    } catch (const std::exception& error) {
        return std::fprintf(stderr, "%s: %s\n", arguments[1], error.what()), 2;
    }
}
