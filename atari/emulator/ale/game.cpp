#include "game.hpp"

#include <stdexcept>

#include "controllers.hpp"
#include "fast/fast_console.hpp"

namespace atari {

void GameRules::set_legal_actions(const std::vector<int32_t>& actions) {
    legal_actions = 0;
    for (const int32_t action : actions) legal_actions |= action >= 0 && action < kActions ? 1u << action : 0u;
}

void GameRules::set_outputs(const std::vector<int32_t>& outputs) {
    if (outputs.size() < 4 || outputs.size() > 2 * kMaxPlayers + 2 || outputs.size() % 2)
        throw std::invalid_argument("a game's outputs are terminal, mode, and reward and lives of each player");
    terminal = outputs[0];
    mode_variable = outputs[1];
    players = static_cast<int>(outputs.size()) / 2 - 1;
    for (size_t player = 0; player < kMaxPlayers; ++player) {  // players that do not play share player 1's
        const size_t at = player < static_cast<size_t>(players) ? 2 * player + 2 : 2;
        rewards[player] = outputs[at];
        lives[player] = outputs[at + 1];
    }
}

std::shared_ptr<const Game> make_game(const GameDefinition& definition) {
    auto game = std::make_shared<Game>();
    static_cast<GameRules&>(*game) = definition;
    game->cartridge = std::make_shared<const FastCartridge>(definition.image, definition.cartridge);
    game->console.first_line = definition.first_line;
    game->console.height = definition.height;
    game->console.pal = definition.format == "PAL";
    game->console.hmove_blanks = definition.hmove_blanks;
    for (int jack : {0, 1}) game->console.paddles[jack] = definition.paddles[jack];
    game->console.swap_ports = definition.swap_ports;
    game->console.swap_paddles = definition.swap_paddles;
    game->palette = &palette_of(definition.format);
    game->step = Program(definition.step, definition.variables, false);
    game->select_mode = Program(definition.select_mode, definition.variables, true);
    game->check();
    return game;
}

void Game::check() const {
    if (players < 1 || players > kMaxPlayers) throw std::invalid_argument("a game has 1 to 4 players");
    for (const auto* outputs : {&rewards, &lives})
        for (int variable : *outputs)
            if (variable < 0 || variable >= variables) throw std::invalid_argument("a game's variable does not exist");
    for (int variable : {terminal, mode_variable})
        if (variable < 0 || variable >= variables) throw std::invalid_argument("a game's variable does not exist");
    if (initial.size() > static_cast<size_t>(variables) || kept.size() != initial.size())
        throw std::invalid_argument("a game's start values do not fit its variables");
    if (console.first_line < 0 || console.height < 1 || console.height > kFrameRows ||
        console.first_line > kFrameRows - console.height)
        throw std::invalid_argument("the framebuffer must lie within 300 lines");
    if (paddle_min < 0 || paddle_max > kMaxResistance || paddle_min > paddle_max)
        throw std::invalid_argument("the range of paddles must lie within 0..16777216");
    for (int action : starting_actions)
        if ((action < 0 || action >= kActions) && action != kReset)
            throw std::invalid_argument("a starting action does not exist");
}

std::unique_ptr<Console> make_console(const Game& game, bool plain) {
    if (plain) return std::make_unique<Console>(game.cartridge, game.console);
    return std::make_unique<FastConsole>(game.cartridge, game.console);
}

}  // namespace atari
