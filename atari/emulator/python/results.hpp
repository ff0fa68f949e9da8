// The parts of the results of a step in Python: arrays, and the keys of `info`.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cstddef>
#include <cstdint>
#include <memory>

namespace atari {

namespace nb = nanobind;

using Array = nb::ndarray<nb::numpy, uint8_t, nb::c_contig, nb::device::cpu>;

// Returns an array that owns its memory.
inline nb::object array_of(std::unique_ptr<uint8_t[]> memory, const size_t* shape, size_t axes) {
    uint8_t* const bytes = memory.get();
    const nb::capsule owner(bytes, [](void* owned) noexcept { delete[] static_cast<uint8_t*>(owned); });
    memory.release();
    return nb::cast(Array(bytes, axes, shape, owner));
}

// The keys of every step's `info`, made once.
struct InfoKeys {
    const nb::object lives = key("lives"), episode_frame = key("episode_frame_number"), frame = key("frame_number");

    static nb::object key(const char* name) { return nb::steal(PyUnicode_InternFromString(name)); }
};

}  // namespace atari
