// A game as text, which game_words.py writes: the arguments of `make_game` (atari/emulator/python/binding.cpp), a line of words for
// each argument: its name, then its values.
#pragma once

#include <istream>
#include <iterator>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "ale/environment.hpp"

namespace atari {

using Words = std::map<std::string, std::vector<std::string>>;

// Reads the lines up to an empty line or the end.
inline Words read_words(std::istream& file) {
    Words words;
    for (std::string line; std::getline(file, line) && !line.empty();) {
        std::istringstream stream(line);
        std::string name;
        stream >> name;
        words[name].assign(std::istream_iterator<std::string>(stream), {});
    }
    return words;
}

inline std::vector<int32_t> numbers(const Words& words, const std::string& name) {
    std::vector<int32_t> values;
    for (const std::string& word : words.at(name)) values.push_back(std::stoi(word));
    return values;
}

inline int number(const Words& words, const std::string& name) { return numbers(words, name).at(0); }

inline std::string text(const Words& words, const std::string& name) {
    std::string joined;
    for (const std::string& word : words.at(name)) joined += (joined.empty() ? "" : " ") + word;
    return joined;
}

inline std::vector<uint8_t> bytes(const std::string& hex) {
    std::vector<uint8_t> values;
    for (size_t i = 0; i < hex.size(); i += 2)
        values.push_back(static_cast<uint8_t>(std::stoi(hex.substr(i, 2), nullptr, 16)));
    return values;
}

inline GameDefinition game_of(const Words& words) {
    GameDefinition game;
    game.image = bytes(text(words, "image"));
    game.cartridge = text(words, "cartridge");
    game.format = text(words, "format");
    game.detect_format = number(words, "detect_format") != 0;
    game.first_line = number(words, "first_line");
    game.height = number(words, "height");
    game.hmove_blanks = number(words, "hmove_blanks") != 0;
    for (int jack : {0, 1}) game.paddles[jack] = numbers(words, "paddles").at(static_cast<size_t>(jack)) != 0;
    game.swap_ports = number(words, "swap_ports") != 0;
    game.swap_paddles = number(words, "swap_paddles") != 0;
    game.power_on_switches = static_cast<uint8_t>(number(words, "power_on_switches"));
    game.paddle_min = numbers(words, "paddle_range").at(0);
    game.paddle_max = numbers(words, "paddle_range").at(1);
    game.legal_actions = 0;
    for (int action : numbers(words, "legal_actions")) game.legal_actions |= 1u << action;
    game.starting_actions = numbers(words, "starting_actions");
    game.default_mode = number(words, "default_mode");
    game.variables = number(words, "variables");
    game.initial = numbers(words, "initial");
    for (int keep : numbers(words, "kept")) game.kept.push_back(keep != 0);
    const std::vector<int32_t> outputs = numbers(words, "outputs");
    game.terminal = outputs.at(0);
    game.mode_variable = outputs.at(1);
    game.rewards[0] = outputs.at(2);
    game.lives[0] = outputs.at(3);
    game.step = numbers(words, "step");
    game.select_mode = numbers(words, "select_mode");
    return game;
}

}  // namespace atari
