// The settings of the vector engine, bound as structs and enums: atari/vector/options.py makes them from a task.

#include <type_traits>

#include "arrays.hpp"
#include "threads.hpp"
#include "vector/lanes.hpp"

namespace atari {
namespace {

// Makes a setting a property. A limit accepts None.
template <typename T>
void bind_setting(nb::class_<EpisodeSettings>& settings, const char* name, T EpisodeSettings::* member) {
    if constexpr (std::is_same_v<T, EpisodeSettings::Limit>) settings.def_rw(name, member, nb::arg().none());
    else settings.def_rw(name, member);
}

}  // namespace

void register_settings(nb::module_& m) {
    nb::enum_<FirePress>(m, "FirePress", "When FIRE is pressed at the start of an episode.")
        .value("NEVER", FirePress::kNever)
        .value("BEFORE_NOOPS", FirePress::kBeforeNoops)
        .value("AFTER_NOOPS", FirePress::kAfterNoops);
    nb::enum_<OnReset>(m, "OnReset", "The effect of a reset after a lost life.")
        .value("NOOP", OnReset::kNoop)
        .value("CONTINUE", OnReset::kContinue)
        .value("NEW_GAME", OnReset::kNewGame);
    nb::enum_<Unit>(m, "Unit", "How long FIRE is pressed, and how often lives are compared: a frame, or a whole skip.")
        .value("FRAME", Unit::kFrame)
        .value("SKIP", Unit::kSkip);
    nb::enum_<Seeding>(m, "Seeding", "How generators are seeded: like AtariEnv.reset, or like ale-py's vector.")
        .value("GYMNASIUM", Seeding::kGymnasium)
        .value("ALE", Seeding::kAle);
    nb::enum_<PixelFormat>(
        m, "PixelFormat",
        "The pixels of observations. GRAY_OF_RGB pools colours and makes the result gray; RAM has no pixels.")
        .value("NONE", PixelFormat::kNone)
        .value("GRAY", PixelFormat::kGray)
        .value("RGB", PixelFormat::kRgb)
        .value("GRAY_OF_RGB", PixelFormat::kGrayOfRgb)
        .value("RAM", PixelFormat::kRam);
    nb::enum_<EndFrames>(m, "EndFrames", "The frames that are observed when an episode ends inside a skip.")
        .value("LAST", EndFrames::kLast)
        .value("GYMNASIUM", EndFrames::kGymnasium)
        .value("BASELINES", EndFrames::kBaselines)
        .value("ENVPOOL", EndFrames::kEnvpool);
    nb::enum_<Padding>(m, "Padding", "The content of a new stack: zeros, or the first frame of the episode.")
        .value("ZERO", Padding::kZero)
        .value("RESET", Padding::kReset);
    nb::enum_<Autoreset>(m, "Autoreset", "The modes of gymnasium.vector.AutoresetMode.")
        .value("NEXT_STEP", Autoreset::kNextStep)
        .value("SAME_STEP", Autoreset::kSameStep)
        .value("DISABLED", Autoreset::kDisabled);

    nb::class_<EpisodeSettings> episode(m, "EpisodeSettings", "How episodes begin, are played, and end.");
    episode.def(nb::init<>());
#define SETTING(type, name, ...) bind_setting(episode, #name, &EpisodeSettings::name);
#include "vector/episode_settings.def"
    nb::class_<ObservationSettings>(m, "ObservationSettings", "How frames are pooled, resized and stacked.")
        .def(nb::init<>())
        .def_rw("pixels", &ObservationSettings::pixels)
        .def_rw("img_height", &ObservationSettings::img_height)
        .def_rw("img_width", &ObservationSettings::img_width)
        .def_rw("stack_num", &ObservationSettings::stack_num)
        .def_rw("maxpool", &ObservationSettings::maxpool)
        .def_rw("end_frames", &ObservationSettings::end_frames)
        .def_rw("padding", &ObservationSettings::padding);
    nb::class_<VectorSettings>(m, "VectorSettings", "How many results make a batch, and which threads work on them.")
        .def(nb::init<>())
        .def_rw("batch_size", &VectorSettings::batch_size)
        .def_rw("threads", &VectorSettings::threads)
        .def_rw("first_core", &VectorSettings::first_core)
        .def_rw("autoreset", &VectorSettings::autoreset);
    nb::class_<LaneSpec>(
        m, "LaneSpec",
        "The differences between the lanes of a vector. `seed` is nine words: one for the emulator, and eight for\n"
        "the generator of episodes.")
        .def(nb::init<>())
        .def_prop_rw(
            "game", [](const LaneSpec& x) { return Shared<Game>{x.game}; },
            [](LaneSpec& x, const Shared<Game>& game) { x.game = game.value; })
        .def_prop_rw(
            "reward", [](const LaneSpec& x) { return Shared<RewardFormula>{x.reward}; },
            [](LaneSpec& x, const Shared<RewardFormula>& reward) { x.reward = reward.value; })
        .def_rw("actions", &LaneSpec::actions)
        .def_rw("action_set", &LaneSpec::action_set)
        .def_rw("mode", &LaneSpec::mode, nb::arg().none())
        .def_rw("difficulty", &LaneSpec::difficulty, nb::arg().none())
        .def_rw("seed", &LaneSpec::seed);
}

}  // namespace atari
