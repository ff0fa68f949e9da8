// `_emulator.ObservationStack`: the observations of an agent, made from the frames of a core or from arrays.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>

#include <algorithm>
#include <memory>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include "ale/programs/labels.hpp"
#include "bound_emulator.hpp"
#include "observations/observation_stack.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace atari {
namespace {

using Pickled = std::tuple<int, int, int, int, bool, int, int, int, std::string, nb::bytes>;

// Threads may share a stack. A stack's lock is taken before that of the emulator that it reads.
class BoundStack : Exclusive {
  public:
    BoundStack(const ObservationSettings& settings, int rows, const std::string& format) : format_(format) {
        if (rows < 1 || rows > kFrameRows)
            throw std::invalid_argument("rows must be within 1.." + std::to_string(kFrameRows));
        if (settings.stack_num < 1 || settings.stack_num > 10'000)
            throw std::invalid_argument("stack_num must be within 1..10000");
        if (settings.pixels == PixelFormat::kNone)
            throw std::invalid_argument("a stack is of images or of RAM; pixels must not be NONE");
        std::shared_ptr<const Resizer> resizer;
        if (!of_ram(settings)) resizer = std::make_shared<const Resizer>(rows, settings.img_height, settings.img_width);
        stack_ = std::make_unique<ObservationStack>(FrameSource(rows, palette_of(format)), settings, resizer);
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

    Array observation() {
        const ObservationSettings& settings = stack_->settings();
        const auto stack = static_cast<size_t>(settings.stack_num);
        const size_t rams[] = {stack, kRamSize};
        const size_t images[] = {stack, static_cast<size_t>(settings.img_height),
                                 static_cast<size_t>(settings.img_width), 3};
        auto* const bytes = new uint8_t[stack_->size()];
        const nb::capsule owner(bytes, [](void* memory) noexcept { delete[] static_cast<uint8_t*>(memory); });
        briefly([&] { stack_->write(bytes); });
        if (!stack_->planes()) return Array(bytes, 2, rams, owner);
        return Array(bytes, stack_->planes() == 3 ? 4 : 3, images, owner);
    }

    nb::bytes save() {
        std::vector<uint8_t> state(stack_->state_size());
        briefly([&] { stack_->save(state.data()); });
        return nb::bytes(state.data(), state.size());
    }
    void load(nb::bytes state) {
        if (state.size() != stack_->state_size())
            throw nb::value_error(("the state of this stack has " + std::to_string(stack_->state_size()) +
                                   " bytes, got " + std::to_string(state.size()))
                                      .c_str());
        briefly([&] { stack_->load(static_cast<const uint8_t*>(state.data())); });
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
                format_,
                save()};
    }

  private:
    static bool of_ram(const ObservationSettings& settings) { return settings.pixels == PixelFormat::kRam; }

    // Calls `work` without the GIL, with the source on `frame`: an emulator, an array, or another core, whose `screen`
    // or `ram` is called. Throws if the frame is not of this stack's size and TV format.
    template <typename Work>
    void with(nb::handle frame, Work&& work) {
        Emulator* emulator = nullptr;
        if (nb::try_cast(frame, emulator, false) && emulator) {
            locked([&] {
                emulator->natively([&](Environment& environment) {
                    read(environment, emulator->number);
                    work();
                });
            });
            return;
        }
        const char* const read = of_ram(stack_->settings()) ? "ram" : "screen";
        std::vector<uint8_t> copy = bytes_of(nb::hasattr(frame, read) ? frame.attr(read)() : nb::borrow(frame));
        locked([&] {
            stack_->source().read(copy.data());
            work();
        });
    }

    void read(Environment& environment, uint64_t number) {
        FrameSource& source = stack_->source();
        if (environment.height() != source.rows() || environment.parts().game->palette != &source.palette())
            throw std::invalid_argument(
                "the core's frames have another size or TV format than this stack's, which "
                "are " +
                std::to_string(source.rows()) + " x 160 in " + format_);
        if (of_ram(stack_->settings())) return source.read(environment);
        if (number != emulator_) stack_->forget_looks();
        emulator_ = number;
        if (environment.parts().settings.color_averaging) {
            averaged_.resize(static_cast<size_t>(source.rows() * kScreenWidth));
            environment.screen(averaged_.data());
            source.read(averaged_.data());
        } else {
            source.read(environment);
        }
    }

    std::vector<uint8_t> bytes_of(const nb::object& frame) {
        if (of_ram(stack_->settings())) {
            nb::ndarray<const uint8_t, nb::shape<kRamSize>, nb::c_contig, nb::device::cpu> ram;
            if (nb::try_cast(frame, ram, false)) return {ram.data(), ram.data() + kRamSize};
            throw nb::type_error("RAM is that of a core, or a uint8 array (128,)");
        }
        nb::ndarray<const uint8_t, nb::ndim<2>, nb::c_contig, nb::device::cpu> array;
        const int rows = stack_->source().rows();
        if (!nb::try_cast(frame, array, false) || static_cast<int>(array.shape(0)) != rows ||
            array.shape(1) != kScreenWidth)
            throw nb::type_error(("a frame is a core, or a C-contiguous uint8 array of palette indices, (" +
                                  std::to_string(rows) + ", 160)")
                                     .c_str());
        return {array.data(), array.data() + array.size()};
    }

    const std::string format_;
    uint64_t emulator_ = 0;  // the number of the emulator that was read last
    std::vector<uint8_t> averaged_;
    std::unique_ptr<ObservationStack> stack_;
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

#define ARRAY "numpy.typing.NDArray[numpy.uint8]"

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
        .def("observation", &BoundStack::observation, nb::sig("def observation(self) -> " ARRAY),
             "A new array, (stack_num, img_height, img_width), with a last axis of 3 for colours; for RAM (stack_num,\n"
             "128). The oldest image is the first.")
        .def("save", &BoundStack::save, "The images, and the frames that the next image may need, as bytes.")
        .def("load", &BoundStack::load, "state"_a,
             "Continue from `save` of a stack with the same settings; ValueError if the bytes have another length.")
        .def("__getstate__", &BoundStack::pickled)
        .def("__setstate__", &unpickle);
}

}  // namespace atari
