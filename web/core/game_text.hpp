// A game of the page: its compiled definition, labels, objects and interventions, read from the text that
// atari/web/table.py writes. The text has a line for each fact: its name, then its words.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "ale/environment.hpp"
#include "ale/programs/labels.hpp"
#include "ale/programs/writes.hpp"
#include "bytes.hpp"
#include "json.hpp"

namespace atari::web {

inline constexpr int kTableFormat = 1;
inline constexpr size_t kMostImage = 512 * 1024;

using SharedWrite = std::shared_ptr<const Write>;

// A label's name, and its value as the program of a write.
struct LabelWrite {
    std::string name;
    int index = 0, mask = 0xff;
    std::vector<int32_t> program;
    std::vector<int32_t> possible;  // the values that it can have, if other bytes choose between them; may be empty
};

// A column or a row of a thing on the screen.
struct Coordinate {
    enum class Kind { kNone, kLabel, kConstant };

    Kind kind = Kind::kNone;
    int32_t number = 0;  // of the label, or the constant
};

// A thing on the screen, which is visible if the labels of its place are.
struct ScreenObject {
    Coordinate x, y;
};

struct PageIntervention {
    Json definition;
    std::vector<SharedWrite> writes;
};

struct PageGame {
    std::string id, rom_md5;
    int players = 1;
    std::shared_ptr<const Game> game;
    std::vector<int32_t> modes, difficulties;
    std::vector<LabelWrite> label_writes;
    Labels labels{{}};
    std::vector<ScreenObject> objects;
    std::vector<PageIntervention> interventions;

    // Returns the write of a definition, in the form of `atari.cores.writes.write_of`: of an intervention, or of a number
    // to a label or a place. Throws Refused for any other.
    SharedWrite write_of(std::string_view definition) const;
    const LabelWrite& label_write(const std::string& name) const;       // throws Refused if there is none
    const PageIntervention* intervention(std::string_view name) const;  // null if there is none
};

// Throws Refused or std::invalid_argument if the text or the image cannot be played.
std::shared_ptr<const PageGame> read_game(std::string_view text, View image);

}  // namespace atari::web
