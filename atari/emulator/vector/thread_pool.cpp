#include "thread_pool.hpp"

#include <algorithm>
#include <cstdlib>
#include <exception>
#include <memory>
#include <new>
#include <utility>

#if defined(__linux__)
#include <pthread.h>
#include <sched.h>
#endif
#if defined(__x86_64__) || defined(_M_X64)
#include <immintrin.h>
#endif

namespace atari {
namespace {

// Some tens of microseconds: less than a step takes, and more than a fast user needs between two steps.
constexpr int kSpins = 1000;

void relax() {
#if defined(__x86_64__) || defined(_M_X64)
    _mm_pause();
#else
    std::this_thread::yield();
#endif
}

// Waits until a counter leaves a value: spins first, then sleeps.
void wait_while(const std::atomic<uint32_t>& counter, uint32_t value) {
    for (int i = 0; i < kSpins; ++i) {
        if (counter.load(std::memory_order_acquire) != value) return;
        relax();
    }
    counter.wait(value, std::memory_order_acquire);
}

void bind_to_core([[maybe_unused]] std::thread& thread, [[maybe_unused]] int core) {
#if defined(__linux__)
    cpu_set_t cores{};
    CPU_SET(static_cast<size_t>(core) % std::max(1u, std::thread::hardware_concurrency()), &cores);
    pthread_setaffinity_np(thread.native_handle(), sizeof cores, &cores);  // A failure only costs speed.
#endif
}

// glibc allocates a thread's memory for exceptions when the thread first throws, and ends the process if it finds none.
// A thread therefore allocates it when it begins, in the place of blocks that it has just freed. The blocks have every
// size that it could need, and are enough that other threads do not take all. Returns false if there is no memory for
// the blocks. (std::uncaught_exceptions would not allocate it: the function is declared pure, so compilers drop its
// call.)
bool prepare_to_throw() {
    constexpr size_t kSizes = 8, kBlocks = 32 * kSizes;
    void* blocks[kBlocks];
    bool found = true;
    for (size_t i = 0; i < kBlocks; ++i) found &= (blocks[i] = std::malloc(16 * (i % kSizes + 1))) != nullptr;
    for (void* block : blocks) std::free(block);
    if (found) static_cast<void>(std::current_exception());
    return found;
}

}  // namespace

ThreadPool::ThreadPool(int items, int threads, bool queued, int first_core, std::function<void(int)> work)
    : work_(std::move(work)), queued_(queued) {
    const int count = queued ? 1 : threads;
    for (int i = 0; i < count; ++i) {
        const auto bound = [&](int part) { return static_cast<int>(int64_t{items} * part / count); };
        ranges_.push_back(std::make_unique<Range>(bound(i + 1) - bound(i)));
        int item = bound(i);
        for (std::atomic<int>& place : ranges_.back()->items) place = item++;
    }
    if (queued) finished_.reserve(static_cast<size_t>(items));
    try {
        for (int i = 1; i < threads; ++i) {
            threads_.emplace_back([this, i] { start(i); });
            started_.wait(static_cast<uint32_t>(i - 1));
            if (lacks_memory_) throw std::bad_alloc();
            if (first_core >= 0) bind_to_core(threads_.back(), first_core + i);
        }
    } catch (...) {  // The system has no more threads, or no more memory.
        stop();
        throw;
    }
}

ThreadPool::~ThreadPool() { stop(); }

void ThreadPool::stop() {
    stop_ = true;
    wake();
    for (std::thread& thread : threads_) thread.join();
}

void ThreadPool::wake() {
    submissions_.fetch_add(1);
    submissions_.notify_all();
}

void ThreadPool::start(int thread) {
    const bool ready = prepare_to_throw();
    if (!ready) lacks_memory_ = true;
    started_.fetch_add(1);
    started_.notify_all();
    if (ready) run(thread);
}

void ThreadPool::run(int thread) {
    while (!stop_) {
        const uint32_t seen = submissions_;
        while (!stop_ && work_on_one(static_cast<size_t>(thread))) {
        }
        if (!stop_) wait_while(submissions_, seen);
    }
}

void ThreadPool::submit_all() {
    for (auto& range : ranges_) {
        range->submitted.fetch_add(range->items.size());
        pending_ += static_cast<int>(range->items.size());
    }
    wake();
}

void ThreadPool::submit(const int* items, int count) {
    Range& range = *ranges_[0];
    uint64_t number = range.submitted;
    // The slot is free. If its last number were unclaimed, all later numbers would be too, and there are fewer items
    // than that.
    for (int i = 0; i < count; ++i) range.items[number++ % range.items.size()] = items[i];
    range.submitted = number;
    pending_ += count;
    wake();
}

int ThreadPool::claim(size_t thread) {
    for (size_t i = 0; i < ranges_.size(); ++i) {
        Range& range = *ranges_[(thread + i) % ranges_.size()];
        uint64_t number = range.next;
        while (number < range.submitted) {
            // Read before the claim: afterwards the slot may be reused.
            const int item = range.items[number % range.items.size()];
            if (range.next.compare_exchange_weak(number, number + 1)) return item;
        }
    }
    return -1;
}

// Works on one item. Returns false if there is none.
bool ThreadPool::work_on_one(size_t thread) {
    const int item = claim(thread);
    if (item < 0) return false;
    std::exception_ptr error;
    try {
        work_(item);
    } catch (...) {
        error = std::current_exception();
    }
    if (queued_ || error) {
        const std::lock_guard lock(mutex_);
        if (queued_) finished_.push_back(item);
        if (error && !deferred_error_) deferred_error_ = error;
    }
    done_.fetch_add(1);
    done_.notify_one();
    return true;
}

void ThreadPool::await(uint32_t ticket) {
    for (;;) {
        const uint32_t done = done_;
        if (static_cast<int32_t>(done - ticket) >= 0) return;
        if (!work_on_one(0)) wait_while(done_, done);
    }
}

void ThreadPool::wait(int count) {
    awaited_ += static_cast<uint32_t>(count);
    pending_ -= count;
    await(awaited_);
    std::unique_lock lock(mutex_);
    if (!deferred_error_) return;
    lock.unlock();
    awaited_ += static_cast<uint32_t>(pending_);  // After an error, the results of all pending items are dropped.
    pending_ = 0;
    await(awaited_);
    lock.lock();
    finished_.clear();
    std::rethrow_exception(std::exchange(deferred_error_, nullptr));
}

std::vector<int> ThreadPool::take(int count) {
    const std::lock_guard lock(mutex_);
    std::vector<int> items(finished_.begin(), finished_.begin() + count);
    finished_.erase(finished_.begin(), finished_.begin() + count);
    return items;
}

}  // namespace atari
