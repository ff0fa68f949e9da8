#include "executable.hpp"

#include <cstring>

// The memory is first writable and then executable: many systems forbid both at once. Processors other than x86 must be
// notified of new code, because they may still hold the earlier contents of the addresses.

#if defined(_WIN32)
#define WIN32_LEAN_AND_MEAN
#include <windows.h>

namespace atari {

void Executable::fill(const std::vector<uint8_t>& code) {
    size_ = code.size();
    void* const memory = VirtualAlloc(nullptr, size_, MEM_RESERVE | MEM_COMMIT, PAGE_READWRITE);
    if (!memory) return;
    std::memcpy(memory, code.data(), size_);
    DWORD before;
    if (VirtualProtect(memory, size_, PAGE_EXECUTE_READ, &before) &&
        FlushInstructionCache(GetCurrentProcess(), memory, size_))
        begin_ = static_cast<uint8_t*>(memory);
    else VirtualFree(memory, 0, MEM_RELEASE);
}

Executable::~Executable() {
    if (begin_) VirtualFree(begin_, 0, MEM_RELEASE);
}

}  // namespace atari

#elif (defined(__unix__) && !defined(__wasm__)) || defined(__APPLE__)
#include <sys/mman.h>
#if defined(__APPLE__) && defined(__aarch64__)
#include <libkern/OSCacheControl.h>
#include <pthread.h>
#endif

namespace atari {

void Executable::fill(const std::vector<uint8_t>& code) {
    size_ = code.size();
#if defined(__APPLE__) && defined(__aarch64__)
    // The system allows code that a program makes only in memory with MAP_JIT, which each thread sees either as writable
    // or as executable. A hardened program needs an entitlement for it.
    void* const memory =
        mmap(nullptr, size_, PROT_READ | PROT_WRITE | PROT_EXEC, MAP_PRIVATE | MAP_ANON | MAP_JIT, -1, 0);
    if (memory == MAP_FAILED) return;
    pthread_jit_write_protect_np(0);
    std::memcpy(memory, code.data(), size_);
    pthread_jit_write_protect_np(1);
    sys_icache_invalidate(memory, size_);
    begin_ = static_cast<uint8_t*>(memory);
#else
    void* const memory = mmap(nullptr, size_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) return;
    std::memcpy(memory, code.data(), size_);
    char* const begin = static_cast<char*>(memory);
    __builtin___clear_cache(begin, begin + size_);
    if (mprotect(memory, size_, PROT_READ | PROT_EXEC) == 0) begin_ = static_cast<uint8_t*>(memory);
    else munmap(memory, size_);
#endif
}

Executable::~Executable() {
    if (begin_) munmap(begin_, size_);
}

}  // namespace atari

#else

namespace atari {

void Executable::fill(const std::vector<uint8_t>&) {}
Executable::~Executable() = default;

}  // namespace atari

#endif
