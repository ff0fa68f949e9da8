// A hundred environments on eight threads must give the same bytes as one after the other. With ThreadSanitizer, this
// also checks that games, cartridges, palettes and tables made on first use are shared without races.
//
// usage: emulator_threads FOLDER    a folder of ROM images (*.bin); ten of them are used
#include <atomic>
#include <cstdio>
#include <optional>
#include <thread>
#include <vector>

#include "games.hpp"

namespace atari {
namespace {

constexpr int kEnvironments = 100, kThreads = 8;
constexpr int kRounds = 4, kActs = 5;  // an environment runs kActs acts at a time, each time on any thread

// Runs an environment. Its digest (FNV-1a) covers all framebuffers and results, and at the end the state.
class EnvironmentRun {
  public:
    EnvironmentRun(const Games& games, size_t number)
        : environment_(games[number % games.size()], settings(number), static_cast<uint32_t>(number)),
          action_(static_cast<uint32_t>(number)) {}

    void play() {
        std::vector<uint8_t> pixels(static_cast<size_t>(environment_.height()) * kScreenWidth);
        for (int i = 0; i < kActs; ++i) {
            action_ = 1664525 * action_ + 1013904223;
            const int reward = environment_.act({static_cast<int>(action_ >> 16) % kActions})[0];
            environment_.screen_gray(pixels.data());
            add(&reward, sizeof reward);
            add(environment_.ram(), 128);
            add(environment_.audio(), kAudioSamples);
            add(pixels.data(), pixels.size());
        }
        std::vector<uint8_t> state(environment_.state_size());
        environment_.save(state.data());
        add(state.data(), state.size());
    }

    uint64_t digest() const { return digest_; }

  private:
    static Settings settings(size_t number) {
        Settings settings;
        settings.sound = true;
        settings.color_averaging = number % 2 != 0;
        settings.frame_skip = 1 + static_cast<int>(number % 3);
        return settings;
    }

    void add(const void* data, size_t size) {
        for (const auto* byte = static_cast<const uint8_t*>(data); size > 0; --size)
            digest_ = (digest_ ^ *byte++) * 0x100000001b3ull;
    }

    Environment environment_;
    uint32_t action_;
    uint64_t digest_ = 0xcbf29ce484222325ull;
};

std::vector<uint64_t> one_after_the_other(const Games& games) {
    std::vector<uint64_t> digests;
    for (size_t i = 0; i < kEnvironments; ++i) {
        EnvironmentRun run(games, i);
        for (int round = 0; round < kRounds; ++round) run.play();
        digests.push_back(run.digest());
    }
    return digests;
}

// Calls `work` for all environments on eight threads, which claim environments in any order.
template <typename Work>
void on_threads(Work&& work) {
    std::atomic<size_t> next{0};
    std::vector<std::thread> threads;
    for (int i = 0; i < kThreads; ++i)
        threads.emplace_back([&] {
            for (size_t number = next++; number < kEnvironments; number = next++) work(number);
        });
    for (std::thread& thread : threads) thread.join();
}

std::vector<uint64_t> all_at_once(const Games& games) {
    std::vector<std::optional<EnvironmentRun>> runs(kEnvironments);
    on_threads([&](size_t number) { runs[number].emplace(games, number); });
    for (int round = 0; round < kRounds; ++round) on_threads([&](size_t number) { runs[number]->play(); });
    std::vector<uint64_t> digests;
    for (const auto& run : runs) digests.push_back(run->digest());
    return digests;
}

}  // namespace
}  // namespace atari

int main(int count, char** arguments) {
    using namespace atari;
    if (count != 2) return std::fprintf(stderr, "usage: emulator_threads FOLDER\n"), 2;
    try {
        const Games games = load_games(arguments[1]);
        const auto together = all_at_once(games);  // first, so that tables are made by threads
        const auto alone = one_after_the_other(games);
        for (size_t i = 0; i < kEnvironments; ++i) {
            if (together[i] == alone[i]) continue;
            std::fprintf(stderr, "environment %zu differs between eight threads and one\n", i);
            return 1;
        }
    } catch (const std::exception& error) {
        return std::fprintf(stderr, "%s\n", error.what()), 2;
    }
    std::printf("%d environments of %d games on %d threads: the same bytes as one after the other\n", kEnvironments,
                kTestGames, kThreads);
}
