// The options of a play session, in the form of the options of a replay's header and of a snapshot's facts.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "game_text.hpp"
#include "json.hpp"

namespace atari::web {

struct Options {
    uint32_t seed = 0;
    std::vector<std::string> stickiness{"0.25"};  // numbers of JSON: one, or one for each player
    std::optional<int32_t> mode, difficulty;
    int32_t max_frames = 0;  // of an episode; 0 is no limit
    bool sound = false;      // only a fact of snapshots: a session always makes sound
    std::vector<const PageIntervention*> interventions;

    Settings settings() const;
};

// Reads an object of JSON; missing keys have their default. Its "interventions" are names or definitions. Throws Refused
// if an option is wrong.
Options read_options(const Json& table, const PageGame& game);

// The probability that ALE uses: it stores settings as text of six digits and parses them as float32.
double as_ale_reads(double probability);

// The JSON of the facts that a snapshot of such a session has, without those of its blobs.
std::string facts_of(const PageGame& game, const Options& options, int mode);
// The JSON of the header of a replay of such a session.
std::string header_of(const PageGame& game, const Options& options, std::string_view package);

}  // namespace atari::web
