// The objects that the binding shares between threads, and their locks. Every binding keeps the rule of the GIL:
//
// 1. No Python object is released without the GIL. So an object that threads own contains none: C++ objects that Python
//    shares with them are bound as `Shared`, and arrays are held by objects that only Python releases.
// 2. A thread with the GIL waits for no lock and joins no thread. It may try a lock.
// 3. A thread with a lock does not wait for the GIL. `CallLock`, a lock of Python code, is the exception.
// 4. Data read without the GIL are a copy, or immutable and owned: Python may change its objects meanwhile.
#pragma once

#include <nanobind/nanobind.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#if !defined(_WIN32)
#include <pthread.h>
#endif

namespace atari {

// An immutable C++ object that Python and the emulator share. nanobind's own caster of std::shared_ptr is not used: its
// last owner releases a Python object, and may be any thread.
template <typename T>
struct Shared {
    std::shared_ptr<const T> value;
};

// Releases the GIL for its life. If the interpreter has ended meanwhile, CPython before 3.14 ends the thread by
// unwinding its stack, which C++ cannot pass on to Python. The thread then sleeps until the process ends, as in 3.14.
class GilRelease {
  public:
    GilRelease() : state_(PyEval_SaveThread()) {}
    GilRelease(const GilRelease&) = delete;
    GilRelease& operator=(const GilRelease&) = delete;
    ~GilRelease() { take(); }

    // Calls `work` with the GIL.
    template <typename Work>
    void with_gil(Work&& work) {
        take();
        struct Drop {
            GilRelease& self;
            ~Drop() { self.state_ = PyEval_SaveThread(); }
        } drop{*this};
        work();
    }

  private:
    void take() {
        try {
            PyEval_RestoreThread(state_);
        } catch (...) {
            for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
        }
    }

    PyThreadState* state_;
};

// Counts the forks that led to this process. Never 0.
inline std::atomic<uint32_t> process_generation{1};

inline void count_forks() {
#if !defined(_WIN32)
    pthread_atfork(nullptr, nullptr, [] { ++process_generation; });
#endif
}

inline void check_process(uint32_t made_in, const char* object) {
    if (made_in != process_generation)
        throw std::runtime_error("this " + std::string(object) +
                                 " was made before the process was forked; make it in the new process, or start that "
                                 "with the method 'spawn'");
}

// A mutex that throws in a forked child process where std::mutex would hang. If a thread that the child lacks held it
// at the fork, the protected data stay in the middle of a change.
class Lock {
  public:
    bool try_lock() {
        uint32_t free = 0;
        return holder_.compare_exchange_strong(free, process_generation, std::memory_order_acquire);
    }
    void lock() {
        const uint32_t own = process_generation;
        for (uint32_t holder = 0; !holder_.compare_exchange_weak(holder, own, std::memory_order_acquire); holder = 0) {
            if (holder == own) holder_.wait(holder, std::memory_order_relaxed);
            else if (holder != 0)
                throw std::runtime_error(
                    "another thread was in a call of this object when this process was forked; "
                    "make a new object in this process");
        }
    }
    void unlock() {
        holder_.store(0, std::memory_order_release);
        holder_.notify_one();
    }

  private:
    std::atomic<uint32_t> holder_{0};  // the generation of the holder's process; 0 is free
};

// An object that threads share: their calls run one at a time.
class Exclusive {
  protected:
    // Calls `work()` without the GIL.
    template <typename Work>
    auto locked(Work&& work) {
        const GilRelease release;
        const std::lock_guard lock(lock_);
        return work();
    }

    // Does the same as `locked`, for threads that do not have the GIL.
    template <typename Work>
    auto natively(Work&& work) {
        const std::lock_guard lock(lock_);
        return work();
    }

    // Returns the lock, held, for a thread that does not have the GIL.
    std::unique_lock<Lock> hold() { return std::unique_lock(lock_); }

    // Does the same as `locked`, but keeps the GIL if no thread has the lock: for work that takes less time than
    // releasing the GIL.
    template <typename Work>
    auto briefly(Work&& work) {
        if (const std::unique_lock lock(lock_, std::try_to_lock); lock) return work();
        return locked(work);
    }

  private:
    Lock lock_;
};

// Returns a weak reference to an array. While it exists, NumPy does not resize the array. Even `resize(refcheck=False)`
// fails, which otherwise may free memory that a thread is writing to. Null for objects without weak references.
inline nanobind::object prevent_resize(nanobind::handle array) {
    PyObject* const reference = PyWeakref_NewRef(array.ptr(), nullptr);
    if (!reference) PyErr_Clear();
    return nanobind::steal(reference);
}

}  // namespace atari
