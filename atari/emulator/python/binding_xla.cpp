// `_emulator.XlaPort`: the vector environment for functions that JAX compiles (atari/integrations/jax). XLA calls the
// handlers below from its threads, without the GIL, and the environments write straight into XLA's buffers.

#include <cstring>
#include <map>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "bound_engine.hpp"
#include "xla_abi.hpp"

namespace atari {
namespace {

using xla::Buffer;
using xla::CallFrame;

// An error with its code.
struct XlaError : std::runtime_error {
    XlaError(xla::ErrorCode code, const std::string& what) : std::runtime_error(what), code(code) {}
    xla::ErrorCode code;
};

[[noreturn]] void refuse(const std::string& what) { throw XlaError(xla::kInvalidArgument, what); }

template <typename T>
constexpr xla::DataType kType = std::is_same_v<T, bool>      ? xla::kPred
                                : std::is_same_v<T, uint8_t> ? xla::kU8
                                : std::is_same_v<T, float>   ? xla::kF32
                                                             : xla::kS32;

// An engine under its handle. Calls through the handle run one at a time.
struct Port {
    Port(BoundEngine& engine, bool pixels, bool ram) : engine(&engine), shape(engine.shape(pixels, ram)) {
        memory.complete(own, {shape.rows, shape.players, 0, 0, shape.has_final, shape.own_rewards});
    }

    Lock lock;
    BoundEngine* engine;  // null after the port has been closed
    const BatchShape shape;
    Batch own;  // holds results between send and recv, and arrays that compiled functions do not get
    BatchMemory memory;

    // Calls `part(name, member, type, values in a row)` for each array that compiled functions get: all but doubles,
    // which JAX has only if it is configured so.
    template <typename Part>
    void for_each(Part&& part) const {
        Batch::for_each(shape, [&]<typename T>(const char* name, T* Batch::* member, size_t width) {
            if constexpr (!std::is_same_v<T, double>) part(name, member, kType<T>, width);
        });
    }
};

// The open ports by their handles, which are never used again.
struct Ports {
    Lock lock;
    std::map<uint64_t, std::shared_ptr<Port>> by_handle;
    uint64_t last = 0;

    uint64_t add(std::shared_ptr<Port> port) {
        const std::lock_guard guard(lock);
        by_handle[++last] = std::move(port);
        return last;
    }
    std::shared_ptr<Port> find(uint64_t handle) {
        const std::lock_guard guard(lock);
        const auto found = by_handle.find(handle);
        return found == by_handle.end() ? nullptr : found->second;
    }
    void remove(uint64_t handle) {
        const std::lock_guard guard(lock);
        by_handle.erase(handle);
    }
};

// Never destroyed: XLA's threads may run while the process ends.
Ports& ports() {
    static Ports& all = *new Ports;
    return all;
}

Buffer& operand(const xla::Operands& operands, int64_t at, const char* what) {
    if (at >= operands.size) refuse(std::string("there is no ") + what);
    if (operands.kinds[at] != xla::kBufferOperand) refuse(std::string(what) + " is no array");
    return *static_cast<Buffer*>(operands.values[at]);
}

size_t values_of(const Buffer& buffer) {
    size_t values = 1;
    for (int64_t axis = 0; axis < buffer.rank; ++axis) values *= static_cast<size_t>(buffer.dimensions[axis]);
    return values;
}

template <typename T>
std::vector<int64_t> widened(const Buffer& buffer) {
    const T* const values = static_cast<const T*>(buffer.data);
    std::vector<int64_t> wide(values, values + values_of(buffer));
    // Larger values of uint64 become negative: out of range in either case.
    return wide;
}

std::vector<int64_t> integers(const Buffer& buffer, const char* what) {
    switch (buffer.type) {
        case xla::kS8: return widened<int8_t>(buffer);
        case xla::kS16: return widened<int16_t>(buffer);
        case xla::kS32: return widened<int32_t>(buffer);
        case xla::kS64: return widened<int64_t>(buffer);
        case xla::kU8: return widened<uint8_t>(buffer);
        case xla::kU16: return widened<uint16_t>(buffer);
        case xla::kU32: return widened<uint32_t>(buffer);
        case xla::kU64: return widened<uint64_t>(buffer);
        default: refuse(std::string(what) + " must be integers");
    }
}

// The buffer of the handle, which is also the first result, so that calls run in the order in which they are chained.
uint64_t pass_handle(const CallFrame& call) {
    const Buffer& in = operand(call.arguments, 0, "handle");
    const Buffer& out = operand(call.results, 0, "handle");
    uint64_t handle = 0;
    for (const Buffer* buffer : {&in, &out})
        if (buffer->type != xla::kU8 || values_of(*buffer) != sizeof handle) refuse("a handle is uint8 of shape (8,)");
    std::memcpy(&handle, in.data, sizeof handle);
    std::memmove(out.data, in.data, sizeof handle);
    return handle;
}

// A batch of the results' buffers.
Batch results_of(Port& port, const xla::Operands& results) {
    Batch batch = port.own;
    int64_t at = 1;
    port.for_each([&]<typename T>(const char* name, T* Batch::* member, xla::DataType type, size_t width) {
        const Buffer& buffer = operand(results, at++, "result");
        if (buffer.type != type || values_of(buffer) != width * port.shape.rows)
            refuse(std::string("the result ") + name + " is not as this environment has it");
        batch.*member = static_cast<T*>(buffer.data);
    });
    if (at != results.size) refuse("there are more results than this environment has");
    // Marks each row as one with an older final observation, so that rows without a new one are zeroed.
    if (port.shape.has_final) std::memset(batch.ended, 1, port.shape.rows);
    return batch;
}

void step(Port& port, const CallFrame& call) {
    const std::vector<int64_t> actions = integers(operand(call.arguments, 1, "action"), "actions");
    port.engine->step_natively(actions, results_of(port, call.results));
}

void send(Port& port, const CallFrame& call) {
    const std::vector<int64_t> actions = integers(operand(call.arguments, 1, "action"), "actions");
    port.memory.complete(port.own, port.shape);
    if (call.arguments.size == 2) return port.engine->send_natively(actions, nullptr, port.own);
    const std::vector<int64_t> environments = integers(operand(call.arguments, 2, "env_id"), "env_id");
    port.engine->send_natively(actions, &environments, port.own);
}

void recv(Port& port, const CallFrame& call) { port.engine->receive_natively(results_of(port, call.results)); }

xla::Error* failure(const CallFrame& call, xla::ErrorCode code, const char* what) {
    xla::ErrorCreateArguments arguments{sizeof arguments, nullptr, what, code};
    return call.api->create_error(&arguments);
}

template <void (*work)(Port&, const CallFrame&)>
void execute(const CallFrame& call) {
    const uint64_t handle = pass_handle(call);
    const std::shared_ptr<Port> port = ports().find(handle);
    const XlaError closed(xla::kNotFound,
                          "there is no environment of this handle: it was closed, or is of another "
                          "process; call xla(envs) for a new one");
    if (!port) throw closed;
    const std::lock_guard guard(port->lock);
    if (!port->engine) throw closed;
    work(*port, call);
}

// A handler as XLA calls it. No exception leaves it.
template <void (*work)(Port&, const CallFrame&)>
xla::Error* handle(CallFrame* call) noexcept {
    for (xla::Extension* extension = call->extensions; extension; extension = extension->next) {
        if (extension->type != xla::kMetadata) continue;
        xla::ApiVersion& version = reinterpret_cast<xla::MetadataExtension*>(extension)->metadata->version;
        version.major = 0;
        // The used part of the interface is the same in all versions. Versions that pass no functions here accept 1.
        version.minor = call->api ? call->api->version.minor : 1;
        return nullptr;
    }
    if (call->stage != xla::kExecute) return nullptr;
    try {
        execute<work>(*call);
        return nullptr;
    } catch (const XlaError& error) {
        return failure(*call, error.code, error.what());
    } catch (const std::bad_alloc&) {
        return failure(*call, xla::kResourceExhausted, "out of memory");
    } catch (const std::logic_error& error) {
        return failure(*call, xla::kInvalidArgument, error.what());
    } catch (const std::exception& error) {
        return failure(*call, xla::kFailedPrecondition, error.what());
    } catch (...) {
        return failure(*call, xla::kInternal, "an environment failed");
    }
}

// Holds an engine under a handle. Compiled functions find it until this object is destroyed.
class XlaPort {
  public:
    XlaPort(nb::handle_t<BoundEngine> engine, bool pixels, bool ram)
        : port_(std::make_shared<Port>(nb::cast<BoundEngine&>(engine), pixels, ram)), engine_(nb::borrow(engine)) {
        handle_ = ports().add(port_);
    }
    XlaPort(const XlaPort&) = delete;
    XlaPort& operator=(const XlaPort&) = delete;

    // Waits for a call that is running.
    ~XlaPort() {
        const GilRelease release;
        try {
            ports().remove(handle_);
            const std::lock_guard guard(port_->lock);
            port_->engine->forget_natively(port_->own);
            port_->engine = nullptr;
        } catch (const std::exception&) {  // in a forked process, where a call was running: XLA does not run there
        }
    }

    // Name, dtype and shape of each result of a compiled function, in order.
    nb::list results() const {
        nb::list all;
        port_->for_each([&](const char* name, auto, xla::DataType type, size_t width) {
            const char* const dtype = type == xla::kPred  ? "bool"
                                      : type == xla::kU8  ? "uint8"
                                      : type == xla::kF32 ? "float32"
                                                          : "int32";
            const size_t rows = port_->shape.rows;
            all.append(nb::make_tuple(name, dtype, width == 1 ? nb::make_tuple(rows) : nb::make_tuple(rows, width)));
        });
        return all;
    }

    nb::bytes handle() const { return nb::bytes(&handle_, sizeof handle_); }

  private:
    std::shared_ptr<Port> port_;
    nb::object engine_;
    uint64_t handle_ = 0;
};

nb::dict targets() {
    nb::dict all;
    const auto add = [&](const char* name, xla::Handler handler) {
        all[name] = nb::capsule(reinterpret_cast<const void*>(handler), "xla._CUSTOM_CALL_TARGET");
    };
    add("atari_step", &handle<&step>);
    add("atari_send", &handle<&send>);
    add("atari_recv", &handle<&recv>);
    return all;
}

}  // namespace

void register_xla(nb::module_& m) {
    nb::class_<XlaPort>(m, "XlaPort",
                        "Access to a vector engine for functions compiled by JAX, as long as this\n"
                        "object exists.")
        .def(nb::init<nb::handle_t<BoundEngine>, bool, bool>(), "engine"_a, "pixels"_a, "ram"_a,
             nb::sig("def __init__(self, engine: VectorEngine, pixels: bool, ram: bool) -> None"))
        .def("results", &XlaPort::results, nb::sig("def results(self) -> list[tuple[str, str, tuple[int, ...]]]"),
             "Name, dtype and shape of each result of a compiled function, in their order.")
        .def_prop_ro("handle", &XlaPort::handle, "Eight bytes by which handlers find the engine.");
    m.def("xla_targets", &targets, nb::sig("def xla_targets() -> dict[str, object]"),
          "The handlers by their names, for `jax.ffi.register_ffi_target`.");
}

}  // namespace atari
