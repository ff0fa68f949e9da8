#include "game_text.hpp"

#include <algorithm>
#include <charconv>
#include <utility>

#include "hashes.hpp"

namespace atari::web {
namespace {

// The value of a decimal byte with a digit above 9 (atari/games/interventions/writes.py), which no write stores.
constexpr int32_t kNoValue = INT32_MIN + 1;

bool contains(const std::vector<int32_t>& values, int32_t value) {
    return std::find(values.begin(), values.end(), value) != values.end();
}

// The words of one line.
class Line {
  public:
    explicit Line(std::string_view line) : rest_(line) { name_ = word(); }

    std::string_view name() const { return name_; }
    bool empty() const { return rest_.empty(); }
    std::string_view rest() const { return rest_; }
    std::string_view word() {
        const size_t end = std::min(rest_.find(' '), rest_.size());
        const std::string_view found = rest_.substr(0, end);
        rest_.remove_prefix(std::min(end + 1, rest_.size()));
        return found;
    }
    int32_t number() {
        const std::string_view digits = word();
        int32_t value = 0;
        const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
        if (error != std::errc{} || end != digits.data() + digits.size() || digits.empty())
            throw Refused("the game's text has the word '" + std::string(digits) +
                          "' in place of a number, in its line '" + std::string(name_) + "'");
        return value;
    }
    bool flag() { return number() != 0; }
    std::vector<int32_t> numbers() {
        std::vector<int32_t> found;
        while (!empty()) found.push_back(number());
        return found;
    }
    std::vector<int32_t> counted() {  // a count n, then n numbers
        std::vector<int32_t> found;
        for (int32_t count = number(); count > 0; --count) found.push_back(number());
        return found;
    }

  private:
    std::string_view rest_, name_;
};

// Reads a line of the arguments of `make_game`, as atari/cores/compiled.py names them. Returns whether it is one.
bool read_definition(Line& line, GameDefinition& game) {
    const std::string_view name = line.name();
    if (name == "cartridge") game.cartridge = line.rest();
    else if (name == "format") game.format = line.word();
    else if (name == "detect_format") game.detect_format = line.flag();
    else if (name == "first_line") game.first_line = line.number();
    else if (name == "height") game.height = line.number();
    else if (name == "hmove_blanks") game.hmove_blanks = line.flag();
    else if (name == "paddles") game.paddles[0] = line.flag(), game.paddles[1] = line.flag();
    else if (name == "swap_ports") game.swap_ports = line.flag();
    else if (name == "swap_paddles") game.swap_paddles = line.flag();
    else if (name == "paddle_range") game.paddle_min = line.number(), game.paddle_max = line.number();
    else if (name == "power_on_switches") game.power_on_switches = static_cast<uint8_t>(line.number());
    else if (name == "legal_actions") game.set_legal_actions(line.numbers());
    else if (name == "starting_actions") game.starting_actions = line.numbers();
    else if (name == "default_mode") game.default_mode = line.number();
    else if (name == "variables") game.variables = line.number();
    else if (name == "initial") game.initial = line.numbers();
    else if (name == "kept") {
        for (const int32_t keep : line.numbers()) game.kept.push_back(keep != 0);
    } else if (name == "outputs") game.set_outputs(line.numbers());
    else if (name == "step") game.step = line.numbers();
    else if (name == "select_mode") game.select_mode = line.numbers();
    else return false;
    return true;
}

Program program(const std::vector<int32_t>& words, int variables) {
    return words.empty() ? Program() : Program(words, variables, false);
}

Label read_label(Line& line, LabelWrite& write) {
    Label label;
    write.name = line.word();
    write.index = label.index = line.number();
    write.mask = label.mask = line.number();
    label.decimal = line.flag();
    label.value = program(line.counted(), Label::kVariables);
    const std::vector<int32_t> visible = line.counted();
    label.hides = !visible.empty();
    label.visible = program(visible, Label::kVariables);
    write.program = line.counted();
    write.possible = line.counted();
    return label;
}

Coordinate read_coordinate(Line& line) {
    const std::string_view kind = line.word();
    const int32_t number = line.number();
    if (kind == "label") return {Coordinate::Kind::kLabel, number};
    if (kind == "at") return {Coordinate::Kind::kConstant, number};
    if (kind == "none") return {};
    throw Refused("an object of the game's text has an unknown coordinate '" + std::string(kind) + "'");
}

std::shared_ptr<Write> read_write(Line& line) {
    auto write = std::make_shared<Write>();
    write->index = line.number();
    write->mask = static_cast<uint8_t>(line.number());
    write->every_frame = line.flag();
    write->at_reset = line.flag();
    write->once = line.flag();
    write->paid = line.flag();
    write->remembers = line.flag();
    write->frames = line.counted();
    const std::vector<int32_t> condition = line.counted(), value = line.counted(), label = line.counted();
    write->conditional = !condition.empty();
    write->condition = program(condition, kWriteVariables);
    write->value = program(value, kWriteVariables);
    write->of_label = !label.empty();
    write->label = program(label, kWriteVariables);
    write->prepare();
    return write;
}

// Reads the text line by line.
class GameReader {
  public:
    std::shared_ptr<const PageGame> read(std::string_view text, View image) {
        definition_.image.assign(image.begin(), image.end());
        while (!text.empty()) {
            const size_t end = std::min(text.find('\n'), text.size());
            if (end > 0) read_line(Line(text.substr(0, end)));
            text.remove_prefix(std::min(end + 1, text.size()));
        }
        if (format_ != kTableFormat)
            throw Refused("the game's text has the format " + std::to_string(format_) + ", and this core reads " +
                          std::to_string(kTableFormat) + "; build the page again");
        for (const ScreenObject& object : game_->objects)
            for (const auto& [kind, number] : {object.x, object.y})
                if (kind == Coordinate::Kind::kLabel && (number < 0 || number >= static_cast<int>(labels_.size())))
                    throw Refused("an object has no such label");
        game_->labels = Labels(std::move(labels_));
        game_->rom_md5 = hex(md5(image));
        if (game_->players < 1 || game_->players > definition_.players)
            throw Refused("the game has no rules for its players");
        game_->game = make_game(definition_);
        return game_;
    }

  private:
    void read_line(Line line) {
        const std::string_view name = line.name();
        if (name == "table") format_ = line.number();
        else if (name == "id") game_->id = line.rest();
        else if (name == "players") game_->players = line.number();
        else if (name == "modes") game_->modes = line.numbers();
        else if (name == "difficulties") game_->difficulties = line.numbers();
        else if (name == "label") labels_.push_back(read_label(line, game_->label_writes.emplace_back()));
        else if (name == "object") game_->objects.push_back({read_coordinate(line), read_coordinate(line)});
        else if (name == "intervention") game_->interventions.push_back({parse_json(line.rest()), {}});
        else if (name == "write") {
            if (game_->interventions.empty()) throw Refused("a write of the game's text belongs to no intervention");
            last_write_ = read_write(line);
            game_->interventions.back().writes.push_back(last_write_);
        } else if (name == "definition") {
            if (!last_write_) throw Refused("a definition of the game's text belongs to no write");
            last_write_->definition = line.rest();
        } else if (!read_definition(line, definition_))
            throw Refused("the game's text has an unknown line '" + std::string(name) + "'; build the page again");
    }

    std::shared_ptr<PageGame> game_ = std::make_shared<PageGame>();
    GameDefinition definition_;
    std::vector<Label> labels_;
    std::shared_ptr<Write> last_write_;
    int format_ = 0;
};

// Sets the frames of a write from "when" of its definition: "frame", "reset", "held", or a list of frames.
void set_frames(Write& write, const Json* when) {
    const std::string word = when && when->kind == Json::Kind::kText ? when->text : "frame";
    if (when && when->kind == Json::Kind::kList) {
        for (const auto& [name, frame] : when->items) {
            if (!frame.is_integer() || frame.number < 0 || frame.number > INT32_MAX)
                throw Refused("a write has a wrong frame");
            if (frame.number == 0) write.at_reset = true;
            else write.frames.push_back(static_cast<int32_t>(frame.number));
        }
        return;
    }
    if ((when && when->kind != Json::Kind::kText) || (word != "frame" && word != "reset" && word != "held"))
        throw Refused("a write cannot be applied at such a time");
    write.every_frame = word != "reset";
    write.at_reset = word != "frame";
}

}  // namespace

SharedWrite PageGame::write_of(std::string_view definition) const {
    for (const PageIntervention& intervention : interventions)
        for (const SharedWrite& write : intervention.writes)
            if (write->definition == definition) return write;
    const Json rule = parse_json(definition);
    if (rule.kind != Json::Kind::kObject) throw Refused("a write is no object of JSON");
    for (const auto& [name, value] : rule.items)
        if (name != "to" && name != "value" && name != "when" && name != "mask" && name != "once" && name != "paid")
            throw Refused("the page plays writes of a number, and of the interventions of " + id +
                          "; a write has more, \"" + name + "\"");
    auto write = std::make_shared<Write>();
    write->definition = definition;
    const Json* const to = rule.find("to");
    const auto number = [&](const char* name, int64_t low, int64_t high) {
        const int64_t found = rule.integer_of(name, "a write");
        if (found < low || found > high) throw Refused(std::string("a write has a wrong \"") + name + '"');
        return static_cast<int32_t>(found);
    };
    const LabelWrite* const label = to && to->kind == Json::Kind::kText ? &label_write(to->text) : nullptr;
    if (label) {
        write->index = label->index;
        write->mask = static_cast<uint8_t>(label->mask);
        write->of_label = true;
        write->label = program(label->program, kWriteVariables);
        if (rule.find("mask")) throw Refused("a write to a label has a mask; the label has its own");
    } else {
        write->index = number("to", 0, 255) % 128;
        if (rule.find("mask")) write->mask = static_cast<uint8_t>(number("mask", 1, 255));
    }
    const int32_t value = label ? number("value", INT32_MIN, INT32_MAX) : number("value", 0, 255);
    write->value = Program({static_cast<int32_t>(Op::kPush), value, static_cast<int32_t>(Op::kStore), kResult,
                            static_cast<int32_t>(Op::kEnd), 0},
                           kWriteVariables, false);
    set_frames(*write, rule.find("when"));
    const auto flag = [&](const char* name, bool otherwise) {
        const Json* const found = rule.find(name);
        if (found && found->kind != Json::Kind::kTrue && found->kind != Json::Kind::kFalse)
            throw Refused(std::string("a write has a wrong \"") + name + '"');
        return found ? found->is_true() : otherwise;
    };
    write->once = flag("once", false);
    write->paid = flag("paid", true);
    write->prepare();
    if (label) {
        const std::vector<int32_t>& possible = write->label_values.empty() ? label->possible : write->label_values;
        if (value == kNoValue || (!possible.empty() && !contains(possible, value)))
            throw Refused(label->name + " cannot be " + std::to_string(value));
    }
    return write;
}

const LabelWrite& PageGame::label_write(const std::string& name) const {
    for (const LabelWrite& label : label_writes)
        if (label.name == name) return label;
    throw Refused(id + " has no label '" + name + "'");
}

const PageIntervention* PageGame::intervention(std::string_view name) const {
    for (const PageIntervention& one : interventions)
        if (const Json* const own = one.definition.find("name"); own && own->text == name) return &one;
    return nullptr;
}

std::shared_ptr<const PageGame> read_game(std::string_view text, View image) {
    if (image.size() > kMostImage) throw Refused("the file has more bytes than any cartridge, so it is no ROM file");
    return GameReader().read(text, image);
}

}  // namespace atari::web
