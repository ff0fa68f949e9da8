// Threads that wait for numbered items and work on them, whoever comes first.
//
// An item belongs to a thread: with n threads, to the one whose n-th part of the items it lies in. So an environment's
// state mostly stays in the cache of one processor. A thread that has none of its own left takes those of others. Or
// the items are `queued`: then all threads take them in the order in which they were submitted.
//
// The thread that waits takes part. A pool of one thread starts none, and does everything in `wait`.
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

namespace atari {

class ThreadPool {
  public:
    // `work(item)` is called for items 0 .. items-1. `first_core` >= 0 binds the threads that are started to the cores
    // from there on, where the system can.
    ThreadPool(int items, int threads, bool queued, int first_core, std::function<void(int)> work);
    ~ThreadPool();
    ThreadPool(const ThreadPool&) = delete;
    ThreadPool& operator=(const ThreadPool&) = delete;

    // Has all items worked on; without `queued` only. Not while some are.
    void submit_all();
    // Has some items worked on, of which none is being worked on; with `queued` only.
    void submit(const int* items, int count);
    // Waits until `count` more items are done. What an item has thrown is thrown once all that were submitted are done.
    void wait(int count);
    // With `queued`: the items that are done, in the order in which they were, as many as were waited for.
    std::vector<int> take(int count);
    // Submitted items that have not been waited for.
    int pending() const { return pending_; }

  private:
    // Numbers next .. submitted-1 wait to be claimed, and count up for ever; number n stands for items[n % items.size()].
    struct alignas(64) Range {
        explicit Range(int size) : items(static_cast<size_t>(size)) {}
        std::atomic<uint64_t> next{0}, submitted{0};
        std::vector<std::atomic<int>> items;
    };

    void run(int thread);
    void stop();
    bool take_part(size_t thread);
    int claim(size_t thread);
    void wake();
    void await(uint32_t ticket);

    const std::function<void(int)> work_;
    const bool queued_;
    std::vector<std::unique_ptr<Range>> ranges_;
    std::vector<std::thread> threads_;
    std::atomic<uint32_t> submissions_{0};  // counts, and wakes the threads
    std::atomic<uint32_t> done_{0};         // counts, and wakes the one that waits
    std::atomic<bool> stop_{false};
    uint32_t awaited_ = 0;  // of `done_`
    int pending_ = 0;
    std::mutex mutex_;  // for what follows
    std::deque<int> finished_;
    std::exception_ptr error_;
};

}  // namespace atari
