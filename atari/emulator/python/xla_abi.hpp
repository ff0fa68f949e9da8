// The structs that XLA and the functions that it calls exchange: the part of its foreign function interface ("typed
// FFI", version 0) that binding_xla.cpp uses. It is a C ABI: structs begin with their size, and newer versions only add
// members at the end. So no header of XLA is needed, and one wheel serves all versions of JAX that have this interface.
#pragma once

#include <cstddef>
#include <cstdint>

namespace atari::xla {

// The type of a buffer's elements.
enum DataType : int32_t {
    kPred = 1,
    kS8 = 2,
    kS16 = 3,
    kS32 = 4,
    kS64 = 5,
    kU8 = 6,
    kU16 = 7,
    kU32 = 8,
    kU64 = 9,
    kF32 = 11,
};

enum ErrorCode : int32_t {
    kInvalidArgument = 3,
    kNotFound = 5,
    kResourceExhausted = 8,
    kFailedPrecondition = 9,
    kInternal = 13,
};

constexpr int32_t kMetadata = 1;       // the type of an extension
constexpr int32_t kExecute = 3;        // the stage in which a function does its work
constexpr int32_t kBufferOperand = 1;  // the only kind of argument and of result used here

struct Error;  // XLA's own

struct Extension {
    size_t struct_size;
    int32_t type;
    Extension* next;
};

struct ApiVersion {
    size_t struct_size;
    Extension* extensions;
    int32_t major, minor;
};

struct ErrorCreateArguments {
    size_t struct_size;
    Extension* extensions;
    const char* message;  // XLA copies it
    ErrorCode code;
};

// XLA's functions; only the first is declared.
struct Api {
    size_t struct_size;
    Extension* extensions;
    ApiVersion version;
    const void* internal_api;
    Error* (*create_error)(ErrorCreateArguments*);
};

struct Buffer {
    size_t struct_size;
    Extension* extensions;
    DataType type;
    void* data;
    int64_t rank;
    int64_t* dimensions;
};

// The arguments of a call, and its results, which are buffers that XLA has allocated.
struct Operands {
    size_t struct_size;
    Extension* extensions;
    int64_t size;
    int32_t* kinds;
    void** values;
};

struct Attributes {
    size_t struct_size;
    Extension* extensions;
    int64_t size;
    int32_t* kinds;
    void** names;
    void** values;
};

struct CallFrame {
    size_t struct_size;
    Extension* extensions;
    const Api* api;
    void* context;
    int32_t stage;
    Operands arguments, results;
    Attributes attributes;
    void* future;
};

// The properties of a function, for its registration. An extension of a call frame points to this struct, and the
// function fills it in. Newer versions have more members, which are zero.
struct Metadata {
    size_t struct_size;
    ApiVersion version;
    uint32_t traits;
};

struct MetadataExtension {
    Extension extension;
    Metadata* metadata;
};

// Success is null.
using Handler = Error* (*)(CallFrame*);

}  // namespace atari::xla
