// The methods of `_emulator.VectorEngine` for the RAM and the screen of an environment, its labels and its writes.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "ale/programs/labels.hpp"
#include "ale/programs/writes.hpp"
#include "bound_engine.hpp"

using namespace nanobind::literals;

namespace atari {
namespace {

using Rams = Table<uint8_t>;

template <auto draw>
nb::object screen_of(BoundEngine& engine, int environment) {
    const auto height = engine.get(environment, [](Environment& e) { return static_cast<size_t>(e.height()); });
    auto* bytes = new uint8_t[height * kScreenWidth * 3];
    nb::capsule owner(bytes, [](void* memory) noexcept { delete[] static_cast<uint8_t*>(memory); });
    engine.get_slowly(environment, [&](Environment& e) { (e.*draw)(bytes); });
    const size_t shape[3] = {height, kScreenWidth, 3};
    return nb::cast(nb::ndarray<nb::numpy, uint8_t, nb::c_contig, nb::device::cpu>(bytes, 3, shape, owner));
}

}  // namespace

#define ARRAY(type) "numpy.typing.NDArray[numpy." type "]"

void register_vector_ram(EngineClass& engine) {
    engine
        .def("screen_rgb", &screen_of<&Environment::screen_rgb>, "environment"_a,
             nb::sig("def screen_rgb(self, environment: int) -> " ARRAY("uint8")))
        .def("redraw", &screen_of<&Environment::redraw>, "environment"_a,
             nb::sig("def redraw(self, environment: int) -> " ARRAY("uint8")))
        .def(
            "ram",
            [](BoundEngine& x, int i) {
                const auto ram = x.get(i, [](Environment& e) { return std::vector<uint8_t>(e.ram(), e.ram() + 128); });
                return nb::bytes(ram.data(), ram.size());
            },
            "environment"_a)
        .def(
            "copy_rams",
            [](BoundEngine& x, List<int64_t> environments, Rams out, VectorEngine::RamOf of) {
                if (out.shape(0) != environments.shape(0) || out.shape(1) != 128)
                    throw nb::value_error("out must be of shape (environments, 128)");
                std::vector<int> numbers;
                for (size_t i = 0; i < environments.size(); ++i)
                    numbers.push_back(static_cast<int>(std::clamp<int64_t>(environments(i), -1, INT32_MAX)));
                const std::vector<uint8_t> rams = x.rams(numbers, of);
                std::copy(rams.begin(), rams.end(), out.data());
            },
            "environments"_a, nb::arg("out").noconvert(), "of"_a,
            nb::sig(
                "def copy_rams(self, environments: " ARRAY("int64") ", out: " ARRAY("uint8") ", of: RamOf) -> None"),
            "Copy the RAM of environments to the rows of `out`.")
        .def(
            "evaluate_labels",
            [](BoundEngine& x, const Shared<Labels>& labels, List<int32_t> environments, Table<int32_t> values,
               Table<bool> visible, VectorEngine::RamOf of) {
                const size_t count = labels.value->size(), rows = environments.size();
                if (values.shape(0) != count || values.shape(1) != rows || visible.shape(0) != count ||
                    visible.shape(1) != rows)
                    throw nb::value_error("values and visible must be of shape (labels, environments)");
                const std::vector<uint8_t> rams = x.rams({environments.data(), environments.data() + rows}, of);
                labels.value->evaluate(rams.data(), rows, values.data(), reinterpret_cast<uint8_t*>(visible.data()));
            },
            "labels"_a, "environments"_a, nb::arg("values").noconvert(), nb::arg("visible").noconvert(), "of"_a,
            nb::sig("def evaluate_labels(self, labels: Labels, environments: " ARRAY("int32") ", values: " ARRAY(
                "int32") ", visible: " ARRAY("bool") ", of: RamOf) -> None"),
            "Copy RAM like `copy_rams`, then call `labels.evaluate` with the copies.")
        .def(
            "set_ram",
            [](BoundEngine& x, int i, int index, int value) {
                x.get(i, [&](Environment& e) { e.set_ram(index & 127, value & 255); });
            },
            "environment"_a, "index"_a, "value"_a)
        .def(
            "add_write",
            [](BoundEngine& x, int i, const Shared<Write>& write, bool now) {
                if (!x.get(i, [&](Environment& e) { return e.parts().add_write(write.value, now); }))
                    throw nb::value_error(kTooManyWrites);
            },
            "environment"_a, "write"_a, "now"_a = false, "Call Emulator.add_write of an environment.")
        .def(
            "remove_write",
            [](BoundEngine& x, int i, const Shared<Write>& write) {
                x.get(i, [&](Environment& e) { e.parts().remove_write(write.value.get()); });
            },
            "environment"_a, "write"_a);
}

}  // namespace atari
