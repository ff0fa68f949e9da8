// All bindings include this header: nanobind with its casters, and arrays and bytes from and to Python.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

// The type of an array in a signature.
#define NDARRAY(type) "numpy.typing.NDArray[numpy." type "]"

namespace atari {

namespace nb = nanobind;
using namespace nb::literals;

// The arguments of bindings, by their axes: any number, one, or two.
template <typename T>
using Values = nb::ndarray<T, nb::c_contig, nb::device::cpu>;
template <typename T>
using List = nb::ndarray<T, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
template <typename T>
using Table = nb::ndarray<T, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

// Errors in arguments are std::invalid_argument and std::out_of_range, or this TypeError.
[[noreturn]] inline void refuse_type(const std::string& why) { throw nb::type_error(why.c_str()); }

inline std::string shown(nb::handle value) { return nb::repr(value).c_str(); }

// Returns the memory of an array that must have `size` values; `name` is for the error. If T is not const, the array must
// be writable.
template <typename T>
T* values_of(nb::handle array, size_t size, const char* name, const char* of_its_type = "") {
    Values<T> values;
    if (!nb::try_cast(array, values, false) || values.size() != size)
        throw std::invalid_argument(std::string(name) + (std::is_const_v<T> ? " must be a" : " must be a writable") +
                                    " C-contiguous array of " + std::to_string(size) + " values" + of_its_type);
    return values.data();
}

inline nb::bytes bytes_of(const std::vector<uint8_t>& bytes) { return nb::bytes(bytes.data(), bytes.size()); }

// Returns the bytes of a state that must have `size` of them. `what` names the state's object in the error.
inline const uint8_t* state_bytes(const nb::bytes& state, size_t size, const char* what) {
    if (state.size() != size)
        throw std::invalid_argument("the state of this " + std::string(what) + " has " + std::to_string(size) +
                                    " bytes, got " + std::to_string(state.size()));
    return static_cast<const uint8_t*>(state.data());
}

// Returns an array of NumPy over memory that `owner` keeps.
template <typename T>
nb::object array_over(T* values, const size_t* shape, size_t axes, const nb::capsule& owner) {
    return nb::cast(nb::ndarray<nb::numpy, T, nb::c_contig, nb::device::cpu>(values, axes, shape, owner));
}

// Returns an array that owns its memory.
template <typename T>
nb::object array_of(std::unique_ptr<T[]> memory, const size_t* shape, size_t axes) {
    T* const values = memory.get();
    const nb::capsule owner(values, [](void* owned) noexcept { delete[] static_cast<T*>(owned); });
    memory.release();
    return array_over(values, shape, axes, owner);
}

// The keys of every step's `info`, made once.
struct InfoKeys {
    const nb::object lives = key("lives"), episode_frame = key("episode_frame_number"), frame = key("frame_number");

    static nb::object key(const char* name) { return nb::steal(PyUnicode_InternFromString(name)); }
};

}  // namespace atari
