#include "executable.hpp"

#include <cstring>

#if defined(__unix__) || defined(__APPLE__)
#include <sys/mman.h>

namespace atari {

// The memory is first writable and then executable: many systems forbid both at once.
void Executable::fill(const std::vector<uint8_t>& code) {
    size_ = code.size();
    void* const memory = mmap(nullptr, size_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) return;
    std::memcpy(memory, code.data(), size_);
    if (mprotect(memory, size_, PROT_READ | PROT_EXEC) == 0) begin_ = static_cast<uint8_t*>(memory);
    else munmap(memory, size_);
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
