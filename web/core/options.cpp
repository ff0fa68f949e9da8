#include "options.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "ale/environment_state.hpp"
#include "hashes.hpp"

namespace atari::web {
namespace {

int32_t in_range(const Json& value, const std::string& name, double low, double high) {
    if (!value.is_integer() || value.number < low || value.number > high)
        throw Refused("the option " + name + " is out of range");
    return static_cast<int32_t>(value.number);
}

std::optional<int32_t> choice(const Json& value, const std::string& name, const std::vector<int32_t>& choices,
                              const std::string& game) {
    if (value.is_null()) return std::nullopt;
    const int32_t chosen = in_range(value, name, INT32_MIN, INT32_MAX);
    if (std::find(choices.begin(), choices.end(), chosen) != choices.end()) return chosen;
    std::string listed;
    for (const int32_t one : choices) listed += (listed.empty() ? "" : ", ") + std::to_string(one);
    throw Refused(game + " has no " + name + ' ' + std::to_string(chosen) + "; it has " + listed);
}

std::vector<std::string> probabilities(const Json& value, size_t players) {
    std::vector<std::string> found;
    const auto add = [&](const Json& one) {
        if (one.kind != Json::Kind::kNumber || one.number < 0 || one.number > 1)
            throw Refused("repeat_action_probability is a number from 0 to 1");
        found.push_back(one.token);
    };
    if (value.kind == Json::Kind::kList)
        for (const auto& [name, one] : value.items) add(one);
    else add(value);
    if (found.size() != 1 && found.size() != players)
        throw Refused("repeat_action_probability has one number, or one for each player");
    return found;
}

std::vector<const PageIntervention*> interventions_of(const Json& value, const PageGame& game) {
    std::vector<const PageIntervention*> found;
    if (value.kind != Json::Kind::kList && !value.is_null()) throw Refused("the option interventions is a list");
    size_t writes = 0;
    for (const auto& [key, one] : value.items) {
        const Json* const name = one.kind == Json::Kind::kText ? &one : one.find("name");
        const PageIntervention* const known = name ? game.intervention(name->text) : nullptr;
        if (!known || (one.kind == Json::Kind::kObject && one.canonical() != known->definition.canonical()))
            throw Refused("the page's table of " + game.id + " has no such intervention" +
                          (name ? " as '" + name->text + "'" : ""));
        found.push_back(known);
        writes += known->writes.size();
    }
    if (writes > kMaxWrites) throw Refused("the interventions have more than 64 writes together");
    return found;
}

std::string number_or_null(const std::optional<int32_t>& value) { return value ? std::to_string(*value) : "null"; }

std::string definitions_of(const Options& options) {
    std::string joined = "[";
    for (const PageIntervention* const one : options.interventions)
        joined += (joined.size() > 1 ? ", " : "") + one->definition.canonical();
    return joined + "]";
}

// The JSON of `atari.cores.writes.fact`.
std::string fact_of_interventions(const Options& options) {
    if (options.interventions.empty()) return "null";
    std::string names;
    for (const PageIntervention* const one : options.interventions)
        names += (names.empty() ? "" : ", ") + one->definition.find("name")->text;
    const std::string definitions = definitions_of(options);
    return quoted(names + " (" + hex(blake2b(view_of(definitions), 4)) + ")");
}

std::string list_of_probabilities(const Options& options, int players) {
    std::string joined = "[";
    for (size_t player = 0; player < static_cast<size_t>(players); ++player)
        joined += (player ? ", " : "") + options.stickiness[options.stickiness.size() > 1 ? player : 0];
    return joined + "]";
}

}  // namespace

Options read_options(const Json& table, const PageGame& game) {
    if (table.kind != Json::Kind::kObject) throw Refused("the options are an object of JSON");
    Options options;
    for (const auto& [name, value] : table.items) {
        if (name == "seed") {
            if (!value.is_integer() || value.number < 0 || value.number > UINT32_MAX)
                throw Refused("a seed is a whole number from 0 to 4294967295");
            options.seed = static_cast<uint32_t>(value.number);
        } else if (name == "repeat_action_probability") {
            options.stickiness = probabilities(value, static_cast<size_t>(game.players));
        } else if (name == "mode") {
            options.mode = choice(value, name, game.modes, game.id);
        } else if (name == "difficulty") {
            options.difficulty = choice(value, name, game.difficulties, game.id);
        } else if (name == "max_num_frames_per_episode") {
            options.max_frames = value.is_null() ? 0 : in_range(value, name, 0, INT32_MAX);
        } else if (name == "sound") {
            options.sound = value.is_true();
        } else if (name == "interventions") {
            options.interventions = interventions_of(value, game);
        } else {
            throw Refused("there is no option '" + name + "'");
        }
    }
    if (game.players > 1 && !options.mode) throw Refused("a game of several players needs the option mode");
    return options;
}

double as_ale_reads(double probability) {
    const double number = static_cast<float>(probability);
    if (number == 0) return 0;
    double scale = 1e5;  // six digits, as "%g" rounds them
    while (number * scale < 1e5) scale *= 10;
    return static_cast<float>(std::nearbyint(number * scale) / scale);
}

Settings Options::settings() const {
    Settings settings;
    for (const std::string& one : stickiness)
        settings.player_probabilities.push_back(as_ale_reads(std::strtod(one.c_str(), nullptr)));
    settings.repeat_action_probability = settings.player_probabilities.front();
    if (settings.player_probabilities.size() == 1) settings.player_probabilities.clear();
    settings.max_frames_per_episode = max_frames;
    settings.sound = true;
    return settings;
}

std::string facts_of(const PageGame& game, const Options& options, int mode) {
    const bool several = game.players > 1;
    std::string facts = std::string("{\"core\": \"") + (several ? "multiplayer" : "native") +
                        "\", \"game\": " + quoted(game.id) + ", \"rom\": " + quoted(game.rom_md5) +
                        ", \"state version\": " + std::to_string(kStateVersion) +
                        ", \"interventions\": " + fact_of_interventions(options);
    if (several)
        return facts + ", \"mode\": " + std::to_string(mode) +
               ", \"repeat_action_probability\": " + list_of_probabilities(options, game.players) +
               ", \"parameters\": {}, \"corrected_scores\": false, \"end_of_reset\": \"multi_agent_ale\", "
               "\"random_words\": \"multi_agent_ale\"}";
    return facts + ", \"repeat_action_probability\": " + options.stickiness.front() +
           ", \"mode\": " + number_or_null(options.mode) + ", \"difficulty\": " + number_or_null(options.difficulty) +
           ", \"frame_skip\": 1, \"max_num_frames_per_episode\": " + std::to_string(options.max_frames) +
           ", \"sound\": " + (options.sound ? "true" : "false") + ", \"color_averaging\": false}";
}

std::string header_of(const PageGame& game, const Options& options, std::string_view package) {
    const bool several = game.players > 1;
    const std::string start = std::string("{\"format\": ") + (several ? "2" : "1") + ", \"game\": " + quoted(game.id) +
                              ", \"rom\": " + quoted(game.rom_md5);
    const std::string end = ", \"package\": " + quoted(package) + "}";
    const std::string mode = ", \"mode\": " + number_or_null(options.mode),
                      difficulty = ", \"difficulty\": " + number_or_null(options.difficulty);
    if (several)
        return start +
               ", \"core\": \"multiplayer\", \"source\": \"page\", \"players\": " + std::to_string(game.players) +
               ", \"options\": {\"corrected_scores\": false" + difficulty +
               ", \"end_of_reset\": \"multi_agent_ale\", \"max_num_frames_per_episode\": " +
               std::to_string(options.max_frames) + mode +
               ", \"mode_numbers\": \"multi_agent_ale\", \"parameters\": {}, \"players\": " +
               std::to_string(game.players) +
               ", \"random_words\": \"multi_agent_ale\", \"repeat_action_probability\": " +
               list_of_probabilities(options, game.players) + ", \"seed\": " + std::to_string(options.seed) + "}" + end;
    const std::string limit = options.max_frames ? std::to_string(options.max_frames) : "null";
    const std::string interventions =
        options.interventions.empty() ? "" : ", \"interventions\": " + definitions_of(options);
    // The fields of both the task and the options of ale-py's environment.
    const std::string shared = ", \"frameskip\": 1, \"repeat_action_probability\": " + options.stickiness.front() +
                               ", \"max_num_frames_per_episode\": " + limit + mode + difficulty + interventions;
    return start + ", \"core\": \"native\", \"source\": \"page\", \"id\": null, \"task\": " +
           quoted("{\"format\": 1, \"game\": " + quoted(game.id) + shared + "}") +
           ", \"options\": {\"obs_type\": \"rgb\", \"continuous\": false, \"continuous_action_threshold\": 0.5, "
           "\"sound_obs\": false, \"full_action_space\": false" +
           shared + "}" + end;
}

}  // namespace atari::web
