// `_emulator.resize_image` and `_emulator.rgb_to_gray`: images of any size. Use them through `atari.wrappers`.

#include <algorithm>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "arrays.hpp"
#include "observations/image.hpp"

namespace atari {
namespace {

// An image, which is read with the GIL: a screen takes microseconds, less than a copy of it and a wait for the GIL.
struct Image {
    ImageSize size;
    int channels;
    std::vector<size_t> extents;
    Values<const uint8_t> array;
};

Image image_of(nb::handle given) {
    Values<const uint8_t> array;
    if (!nb::try_cast(given, array, false))
        refuse_type("an image must be a C-contiguous array of uint8, got " +
                    shown(nb::hasattr(given, "dtype") ? nb::object(given.attr("dtype")) : nb::borrow(given.type())));
    std::vector<size_t> extents;
    for (size_t axis = 0; axis < array.ndim(); ++axis) extents.push_back(array.shape(axis));
    const bool served =
        (extents.size() == 2 || extents.size() == 3) &&
        std::all_of(extents.begin(), extents.end(), [](size_t n) { return n >= 1 && n <= kLongestSide; });
    if (!served)
        throw std::invalid_argument(
            "an image must have the shape (rows, columns) or (rows, columns, channels), each within 1.." +
            std::to_string(kLongestSide) + ", got " + shown(given.attr("shape")));
    const ImageSize size{static_cast<int>(extents[0]), static_cast<int>(extents[1])};
    const int channels = extents.size() == 3 ? static_cast<int>(extents[2]) : 1;
    return {size, channels, extents, array};
}

// Returns a new array that `fill` has written.
template <typename Fill>
nb::object filled(const std::vector<size_t>& extents, Fill&& fill) {
    size_t size = 1;
    for (const size_t extent : extents) size *= extent;
    std::unique_ptr<uint8_t[]> memory(new uint8_t[size]);
    fill(memory.get());
    return array_of(std::move(memory), extents.data(), extents.size());
}

nb::object resized(nb::handle given, int rows, int columns) {
    if (std::min(rows, columns) < 1 || std::max(rows, columns) > kLongestSide)
        throw std::invalid_argument("rows and columns must be within 1.." + std::to_string(kLongestSide) + ", got " +
                                    std::to_string(rows) + " and " + std::to_string(columns));
    const Image image = image_of(given);
    std::vector<size_t> extents = image.extents;
    extents[0] = static_cast<size_t>(rows);
    extents[1] = static_cast<size_t>(columns);
    return filled(extents, [&](uint8_t* to) {
        resize_image(image.array.data(), image.size, image.channels, {rows, columns}, to);
    });
}

nb::object gray(nb::handle given) {
    const Image image = image_of(given);
    if (image.extents.size() != 3 || image.channels != 3)
        throw std::invalid_argument("an RGB image must have the shape (rows, columns, 3), got " +
                                    shown(given.attr("shape")));
    return filled({image.extents[0], image.extents[1]},
                  [&](uint8_t* to) { rgb_to_gray(image.array.data(), image.extents[0], image.extents[1], to); });
}

}  // namespace

void register_image(nb::module_& m) {
    m.def("resize_image", &resized, "image"_a, "rows"_a, "columns"_a,
          nb::sig("def resize_image(image: " NDARRAY("uint8") ", rows: int, columns: int) -> " NDARRAY("uint8")),
          "The image, (rows, columns) or (rows, columns, channels), in another size; a new array.");
    m.def("rgb_to_gray", &gray, "image"_a, nb::sig("def rgb_to_gray(image: " NDARRAY("uint8") ") -> " NDARRAY("uint8")),
          "The brightness of an image, (rows, columns, 3); a new array, (rows, columns).");
}

}  // namespace atari
