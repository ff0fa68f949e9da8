// `ThreadPool`: threads that wait for numbered items and work on them.
//
// With n threads, each thread owns an n-th part of the items, so that an environment's state mostly stays in the cache
// of one processor. A thread without items of its own left takes items of other threads. If the items are `queued`,
// all threads take them in the order in which they were submitted.
//
// The thread that calls `wait` works too. A pool of one thread starts none, and does all work in `wait`.
#pragma once

#include <atomic>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

namespace atari {

class ThreadPool {
  public:
    // The threads call `work(item)` for items 0 .. items-1. If `first_core` >= 0, started thread i is bound to core
    // first_core + i, where the system can.
    ThreadPool(int items, int threads, bool queued, int first_core, std::function<void(int)> work);
    ~ThreadPool();
    ThreadPool(const ThreadPool&) = delete;
    ThreadPool& operator=(const ThreadPool&) = delete;

    // Starts work on all items. No item may be pending, and `queued` must be false.
    void submit_all();
    // Starts work on some items. None of them may be pending, and `queued` must be true.
    void submit(const int* items, int count);
    // Waits until `count` more items are done. If an item has thrown, waits for all submitted items and rethrows that
    // deferred error.
    void wait(int count);
    // Waits until all submitted items are done. They stay pending, and a deferred error stays deferred, until `wait`.
    void settle() { await(awaited_ + static_cast<uint32_t>(pending_)); }
    // With `queued`: returns the items that were waited for, in the order in which they were done.
    std::vector<int> take(int count);
    // Returns the number of submitted items that have not been waited for.
    int pending() const { return pending_; }

  private:
    // Numbers next .. submitted-1 wait to be claimed. Numbers only grow; number n stands for items[n % items.size()].
    struct alignas(64) Range {
        explicit Range(int size) : items(static_cast<size_t>(size)) {}
        std::atomic<uint64_t> next{0}, submitted{0};
        std::vector<std::atomic<int>> items;
    };

    void start(int thread);
    void run(int thread);
    void stop();
    bool work_on_one(size_t thread);
    int claim(size_t thread);
    void wake();
    void await(uint32_t ticket);

    const std::function<void(int)> work_;
    const bool queued_;
    std::vector<std::unique_ptr<Range>> ranges_;
    std::vector<std::thread> threads_;
    std::atomic<uint32_t> started_{0};  // threads that have what they need, or lack memory
    std::atomic<bool> lacks_memory_{false};
    std::atomic<uint32_t> submissions_{0};  // counts, and wakes the threads
    std::atomic<uint32_t> done_{0};         // counts, and wakes the thread that waits
    std::atomic<bool> stop_{false};
    uint32_t awaited_ = 0;  // the value of `done_` to wait for
    int pending_ = 0;
    std::mutex mutex_;           // protects the members below
    std::vector<int> finished_;  // has room for all items, so that adding one cannot fail
    std::exception_ptr deferred_error_;
};

}  // namespace atari
