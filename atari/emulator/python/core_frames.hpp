// `CoreFrames`: the frames of cores of Python's, for an `ObservationStack`.
#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "ale/programs/labels.hpp"
#include "bound_emulator.hpp"
#include "observations/observation_stack.hpp"

namespace atari {

// Returns a stack of frames of `rows` x 160, or of RAM.
inline std::unique_ptr<ObservationStack> make_stack(const ObservationSettings& settings, int rows,
                                                    const std::string& format) {
    if (rows < 1 || rows > kFrameRows)
        throw std::invalid_argument("rows must be within 1.." + std::to_string(kFrameRows));
    if (settings.stack_num < 1 || settings.stack_num > 10'000)
        throw std::invalid_argument("stack_num must be within 1..10000");
    std::shared_ptr<const Resizer> resizer;
    if (settings.pixels != PixelFormat::kNone && settings.pixels != PixelFormat::kRam)
        resizer = std::make_shared<const Resizer>(rows, settings.img_height, settings.img_width);
    return std::make_unique<ObservationStack>(FrameSource(rows, palette_of(format)), settings, resizer);
}

// Returns the observation that `write(memory)` writes: (stack_num, img_height, img_width), with a last axis of 3 for
// colours; for RAM (stack_num, 128). If not `stacked`, it has no axis for the stack.
template <typename Write>
nb::object observation_of(const ObservationStack& stack, bool stacked, Write&& write) {
    const ObservationSettings& settings = stack.settings();
    const auto frames = static_cast<size_t>(settings.stack_num);
    const size_t images[] = {frames, static_cast<size_t>(settings.img_height), static_cast<size_t>(settings.img_width),
                             3};
    const size_t rams[] = {frames, kRamSize};
    const size_t axes = stack.planes() == 3 ? 4 : stack.planes() ? 3 : 2;
    std::unique_ptr<uint8_t[]> bytes(new uint8_t[stack.size()]);
    write(bytes.get());
    return array_of(std::move(bytes), (stack.planes() ? images : rams) + !stacked, axes - !stacked);
}

// A frame is the present frame of an emulator, or the bytes of another core's frame or RAM, which the caller keeps while
// the stack reads them.
class CoreFrames {
  public:
    CoreFrames(ObservationStack& stack, std::string format) : stack_(stack), format_(std::move(format)) {}

    const std::string& format() const { return format_; }
    bool of_ram() const { return stack_.settings().pixels == PixelFormat::kRam; }

    // Throws std::invalid_argument if the frame is not of the stack's size and TV format.
    void read(Environment& environment, uint64_t number) {
        FrameSource& source = stack_.source();
        if (environment.height() != source.rows() || environment.parts().game->palette != &source.palette())
            throw std::invalid_argument(
                "the core's frames have another size or TV format than this stack's, which are " +
                std::to_string(source.rows()) + " x 160 in " + format_);
        if (of_ram()) return source.read(environment);
        if (number != emulator_) stack_.forget_looks();
        emulator_ = number;
        if (environment.parts().settings.color_averaging) {
            averaged_.resize(static_cast<size_t>(source.rows() * kScreenWidth));
            environment.screen(averaged_.data());
            source.read(averaged_.data());
        } else {
            source.read(environment);
        }
    }
    void read(const std::vector<uint8_t>& bytes) { stack_.source().read(bytes.data()); }

    // Returns the present frame or RAM of a core that is no emulator, or of an array, for `read`. Called with the GIL.
    std::vector<uint8_t> bytes_of(nb::handle frame) {
        const char* const method = of_ram() ? "ram" : "screen";
        const nb::object array = nb::hasattr(frame, method) ? frame.attr(method)() : nb::borrow(frame);
        return of_ram() ? ram_of(array) : screen_of(array);
    }

    static std::vector<uint8_t> ram_of(const nb::object& array) {
        nb::ndarray<const uint8_t, nb::shape<kRamSize>, nb::c_contig, nb::device::cpu> ram;
        if (!nb::try_cast(array, ram, false)) refuse_type("RAM is that of a core, or a uint8 array (128,)");
        return {ram.data(), ram.data() + kRamSize};
    }

  private:
    std::vector<uint8_t> screen_of(const nb::object& array) {
        nb::ndarray<const uint8_t, nb::ndim<2>, nb::c_contig, nb::device::cpu> screen;
        const int rows = stack_.source().rows();
        if (!nb::try_cast(array, screen, false) || static_cast<int>(screen.shape(0)) != rows ||
            screen.shape(1) != kScreenWidth)
            refuse_type("a frame is a core, or a C-contiguous uint8 array of palette indices, (" +
                        std::to_string(rows) + ", 160)");
        return {screen.data(), screen.data() + screen.size()};
    }

    ObservationStack& stack_;
    const std::string format_;
    uint64_t emulator_ = 0;  // the number of the emulator that was read last
    std::vector<uint8_t> averaged_;
};

}  // namespace atari
