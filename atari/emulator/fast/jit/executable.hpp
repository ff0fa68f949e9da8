// Executable memory for translated code.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace atari {

// A copy of machine code that can be run but no longer written. Empty if the system does not allow that.
class Executable {
  public:
    Executable() = default;
    ~Executable();
    Executable(const Executable&) = delete;
    Executable& operator=(const Executable&) = delete;

    void fill(const std::vector<uint8_t>& code);

    const uint8_t* begin() const { return begin_; }

  private:
    uint8_t* begin_ = nullptr;
    std::size_t size_ = 0;
};

}  // namespace atari
