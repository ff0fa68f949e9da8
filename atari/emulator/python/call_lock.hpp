// `CallLock`: the lock of an object in Python whose methods are more than one call of the extension module.
#pragma once

#include <atomic>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include "threads.hpp"

namespace atari {

// A lock for `with`. The thread that holds it may enter again: a signal handler may close an environment during a step.
class CallLock {
  public:
    // `object` names the locked object in the error of a forked process.
    explicit CallLock(std::string object) : object_(std::move(object)) {}

    void enter() {
        check_process(process_, object_.c_str());
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
    const std::string object_;
    const uint32_t process_ = process_generation;
    Lock lock_;
    std::atomic<std::thread::id> holder_{};
    int entered_again_ = 0;
};

}  // namespace atari
