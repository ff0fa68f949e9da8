// The methods of `_emulator.VectorEngine` for the RAM and the screen of an environment, its labels and its writes.

#include <algorithm>
#include <memory>
#include <vector>

#include "ale/programs/labels.hpp"
#include "ale/programs/writes.hpp"
#include "bound_engine.hpp"

namespace atari {
namespace {

template <auto draw>
nb::object screen_of(BoundEngine& engine, int environment) {
    const auto height = engine.get(environment, [](Environment& e) { return static_cast<size_t>(e.height()); });
    const size_t shape[] = {height, kScreenWidth, 3};
    std::unique_ptr<uint8_t[]> bytes(new uint8_t[height * kScreenWidth * 3]);
    engine.get_slowly(environment, [&](Environment& e) { (e.*draw)(bytes.get()); });
    return array_of(std::move(bytes), shape, 3);
}

}  // namespace

void register_vector_ram(EngineClass& engine) {
    engine
        .def("screen_rgb", &screen_of<&Environment::screen_rgb>, "environment"_a,
             nb::sig("def screen_rgb(self, environment: int) -> " NDARRAY("uint8")))
        .def("redraw", &screen_of<&Environment::redraw>, "environment"_a,
             nb::sig("def redraw(self, environment: int) -> " NDARRAY("uint8")))
        .def(
            "ram",
            [](BoundEngine& x, int i) {
                const auto ram = x.get(i, [](Environment& e) { return std::vector<uint8_t>(e.ram(), e.ram() + 128); });
                return bytes_of(ram);
            },
            "environment"_a)
        .def(
            "copy_rams",
            [](BoundEngine& x, List<const int64_t> environments, Table<uint8_t> out, VectorEngine::RamOf of) {
                if (out.shape(0) != environments.shape(0) || out.shape(1) != 128)
                    throw std::invalid_argument("out must be of shape (environments, 128)");
                std::vector<int> numbers;
                for (size_t i = 0; i < environments.size(); ++i)
                    numbers.push_back(static_cast<int>(std::clamp<int64_t>(environments(i), -1, INT32_MAX)));
                const std::vector<uint8_t> rams = x.rams(numbers, of);
                std::copy(rams.begin(), rams.end(), out.data());
            },
            "environments"_a, nb::arg("out").noconvert(), "of"_a,
            nb::sig("def copy_rams(self, environments: " NDARRAY("int64") ", out: " NDARRAY(
                "uint8") ", of: RamOf) -> None"),
            "Copy the RAM of environments to the rows of `out`.")
        .def(
            "evaluate_labels",
            [](BoundEngine& x, const Shared<Labels>& labels, List<const int32_t> environments, Table<int32_t> values,
               Table<bool> visible, VectorEngine::RamOf of) {
                const size_t count = labels.value->size(), rows = environments.size();
                if (values.shape(0) != count || values.shape(1) != rows || visible.shape(0) != count ||
                    visible.shape(1) != rows)
                    throw std::invalid_argument("values and visible must be of shape (labels, environments)");
                const std::vector<uint8_t> rams = x.rams({environments.data(), environments.data() + rows}, of);
                labels.value->evaluate(rams.data(), rows, values.data(), reinterpret_cast<uint8_t*>(visible.data()));
            },
            "labels"_a, "environments"_a, nb::arg("values").noconvert(), nb::arg("visible").noconvert(), "of"_a,
            nb::sig("def evaluate_labels(self, labels: Labels, environments: " NDARRAY("int32") ", values: " NDARRAY(
                "int32") ", visible: " NDARRAY("bool") ", of: RamOf) -> None"),
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
                    throw std::invalid_argument(kTooManyWrites);
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
