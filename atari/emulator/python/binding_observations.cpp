// `_emulator.ObservationStack`: the observations of an agent, made from the frames of a core or from arrays.

#include <memory>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include "core_frames.hpp"

namespace atari {
namespace {

using Pickled = std::tuple<int, int, int, int, bool, int, int, int, std::string, nb::bytes>;

// Threads may share a stack. A stack's lock is taken before that of the emulator that it reads.
class BoundStack : Exclusive {
  public:
    BoundStack(const ObservationSettings& settings, int rows, const std::string& format)
        : stack_(make_stack(settings, rows, format)), frames_(*stack_, format) {
        if (settings.pixels == PixelFormat::kNone)
            throw std::invalid_argument("a stack is of images or of RAM; pixels must not be NONE");
    }

    void begin(nb::handle frame, bool new_stack) {
        with(frame, [&] { stack_->begin(new_stack); });
    }
    void repeat(bool new_stack) {
        briefly([&] { stack_->repeat(new_stack); });
    }
    void frame_played(nb::handle frame, int left, bool ended) {
        if (left == 1 && stack_->planes() && stack_->settings().maxpool)
            with(frame, [&] { stack_->frame_played(left, ended); });
    }
    void skip_ended(nb::handle frame, int left, bool ended) {
        with(frame, [&] { stack_->skip_ended(left, ended); });
    }

    nb::object observation() {
        return observation_of(*stack_, true, [&](uint8_t* to) { briefly([&] { stack_->write(to); }); });
    }

    nb::bytes save() {
        std::vector<uint8_t> state(stack_->state_size());
        briefly([&] { stack_->save(state.data()); });
        return bytes_of(state);
    }
    void load(nb::bytes state) {
        const uint8_t* const bytes = state_bytes(state, stack_->state_size(), "stack");
        briefly([&] { stack_->load(bytes); });
    }

    Pickled pickled() {
        const ObservationSettings& s = stack_->settings();
        return {static_cast<int>(s.pixels),
                s.img_height,
                s.img_width,
                s.stack_num,
                s.maxpool,
                static_cast<int>(s.end_frames),
                static_cast<int>(s.padding),
                stack_->source().rows(),
                frames_.format(),
                save()};
    }

  private:
    // Calls `work` without the GIL, with the source on `frame`: an emulator, an array, or another core, whose `screen`
    // or `ram` is called. Throws if the frame is not of this stack's size and TV format.
    template <typename Work>
    void with(nb::handle frame, Work&& work) {
        Emulator* emulator = nullptr;
        if (nb::try_cast(frame, emulator, false) && emulator) {
            locked([&] {
                emulator->natively([&](Environment& environment) {
                    frames_.read(environment, emulator->number);
                    work();
                });
            });
            return;
        }
        const std::vector<uint8_t> bytes = frames_.bytes_of(frame);
        locked([&] {
            frames_.read(bytes);
            work();
        });
    }

    const std::unique_ptr<ObservationStack> stack_;
    CoreFrames frames_;
};

void unpickle(BoundStack* self, const Pickled& state) {
    const auto& [pixels, height, width, stack_num, maxpool, end_frames, padding, rows, format, bytes] = state;
    const ObservationSettings settings{
        static_cast<PixelFormat>(pixels), height, width, stack_num, maxpool, static_cast<EndFrames>(end_frames),
        static_cast<Padding>(padding)};
    new (self) BoundStack(settings, rows, format);
    try {
        self->load(bytes);
    } catch (...) {
        self->~BoundStack();
        throw;
    }
}

}  // namespace

void register_observations(nb::module_& m) {
    nb::class_<BoundStack>(
        m, "ObservationStack",
        "The pooled, resized and stacked frames that an agent observes, equal to those of a lane of `VectorEngine`.\n"
        "With PixelFormat.RAM it stacks the RAM.\n\n"
        "A frame is a core, or a C-contiguous uint8 array of palette indices, (rows, 160). A core's frame is\n"
        "rendered only if an image needs it. Raises ValueError if a size is not supported or a core has other rows\n"
        "or another TV format, TypeError for another frame. RAM comes from a core, or is an array (128,).")
        .def(nb::init<const ObservationSettings&, int, const std::string&>(), "settings"_a, "rows"_a, "format"_a)
        .def("begin", &BoundStack::begin, "frame"_a, "new_stack"_a = true,
             nb::sig("def begin(self, frame: object, new_stack: bool = True) -> None"),
             "Begin an episode with the present frame; `new_stack` drops the images before it.")
        .def("repeat", &BoundStack::repeat, "new_stack"_a = false, "Add the last image again.")
        .def("frame_played", &BoundStack::frame_played, "frame"_a, "left"_a, "ended"_a,
             nb::sig("def frame_played(self, frame: object, left: int, ended: bool) -> None"),
             "A frame of a skip was played, and `left` remain; `ended`: the episode ended with this frame. The call\n"
             "with `left` 1 is required; a core must then play exactly one frame before `skip_ended`.")
        .def("skip_ended", &BoundStack::skip_ended, "frame"_a, "left"_a, "ended"_a,
             nb::sig("def skip_ended(self, frame: object, left: int, ended: bool) -> None"),
             "Add the image of a skip, `left` frames before its end.")
        .def("observation", &BoundStack::observation, nb::sig("def observation(self) -> " NDARRAY("uint8")),
             "A new array, (stack_num, img_height, img_width), with a last axis of 3 for colours; for RAM (stack_num,\n"
             "128). The oldest image is the first.")
        .def("save", &BoundStack::save, "The images, and the frames that the next image may need, as bytes.")
        .def("load", &BoundStack::load, "state"_a,
             "Continue from `save` of a stack with the same settings; ValueError if the bytes have another length.")
        .def("__getstate__", &BoundStack::pickled)
        .def("__setstate__", &unpickle);
}

}  // namespace atari
