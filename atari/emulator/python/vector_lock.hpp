// `VectorLock`: the lock of a vector environment in Python.
#pragma once

#include <atomic>
#include <cstdint>
#include <stdexcept>
#include <thread>

#include "threads.hpp"

namespace atari {

inline void check_process(uint32_t made_in) {
    if (made_in != process_generation)
        throw std::runtime_error(
            "this vector environment was made before the process was forked, and has no threads "
            "here; make it in the new process, or start that with the method 'spawn'");
}

// The lock of a vector environment in Python, which is held from the choice of a buffer to its loan. The thread that
// holds it may enter again: a signal handler may close the environment during a step.
class VectorLock {
  public:
    void enter() {
        check_process(process_);
        if (holder_ == std::this_thread::get_id()) {
            ++entered_again_;
            return;
        }
        if (!lock_.try_lock()) {
            const GilRelease release;
            lock_.lock();
        }
        holder_ = std::this_thread::get_id();
    }

    void exit() {
        if (holder_ != std::this_thread::get_id()) throw std::runtime_error("this thread has not entered the lock");
        if (entered_again_ > 0) {
            --entered_again_;
            return;
        }
        holder_ = std::thread::id();
        lock_.unlock();
    }

  private:
    const uint32_t process_ = process_generation;
    Lock lock_;
    std::atomic<std::thread::id> holder_{};
    int entered_again_ = 0;
};

}  // namespace atari
