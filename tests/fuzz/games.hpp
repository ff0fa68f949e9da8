// Games of ROM images for the thread tests.
#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include "ale/environment_parts.hpp"

namespace atari {

constexpr int kTestGames = 10;

using Games = std::vector<std::shared_ptr<const Game>>;

// Loads ROM images, with rules that read RAM and draw random words each frame.
inline Games load_games(const std::filesystem::path& folder) {
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        if (entry.path().extension() == ".bin") files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    if (files.size() < kTestGames) throw std::runtime_error("the folder holds fewer than ten ROM images (*.bin)");
    std::vector<int32_t> rules;
    for (auto [op, argument] : std::initializer_list<std::pair<Op, int32_t>>{{Op::kPush, 0x80},
                                                                             {Op::kPush, 0xff},
                                                                             {Op::kPositiveSum, 0},
                                                                             {Op::kRandom, 0},
                                                                             {Op::kXor, 0},
                                                                             {Op::kStore, 0},
                                                                             {Op::kEnd, 0}})
        rules.insert(rules.end(), {static_cast<int32_t>(op), argument});
    Games games;
    for (size_t i = 0; i < kTestGames; ++i) {
        std::ifstream file(files[i * files.size() / kTestGames], std::ios::binary);
        const std::vector<uint8_t> image(std::istreambuf_iterator<char>(file), {});
        auto game = std::make_shared<Game>();
        game->cartridge = std::make_shared<const FastCartridge>(image, "");
        game->palette = i % 3 == 0 ? &NTSC : i % 3 == 1 ? &PAL : &SECAM;
        game->variables = 4;
        game->mode_variable = 3;
        game->step = Program(rules, game->variables, false);
        game->check();
        games.push_back(game);
    }
    return games;
}

}  // namespace atari
