// A vector environment must give the same bytes on four threads as on one. This must hold whether it waits for all
// environments or for those that are ready first, and when environments continue from others. With ThreadSanitizer,
// this also checks that batches and states pass between threads without races.
//
// usage: vector_threads FOLDER    a folder of ROM images (*.bin); ten of them are used
#include <cstdio>
#include <cstring>
#include <exception>
#include <vector>

#include "games.hpp"
#include "vector/lanes.hpp"

namespace atari {
namespace {

constexpr int kEnvironments = 20, kSteps = 25;

// By environment, a digest (FNV-1a) of each of its results.
using Digests = std::vector<std::vector<uint64_t>>;

// A digest of a row of all arrays but the seconds.
uint64_t digest_of(const Batch& batch, const BatchShape& shape, size_t row) {
    uint64_t digest = 0xcbf29ce484222325ull;
    Batch::for_each(shape, [&]<typename T>(const char* name, T* Batch::* member, size_t width) {
        if (std::strcmp(name, "seconds") == 0) return;
        const auto* byte = reinterpret_cast<const uint8_t*>(batch.*member + row * width);
        for (size_t i = 0; i < width * sizeof(T); ++i) digest = (digest ^ byte[i]) * 0x100000001b3ull;
    });
    return digest;
}

// With `forks`, environments sometimes continue from snapshots of others, which the threads restore.
Digests play(const Games& games, int threads, int batch_size, bool forks = false) {
    EpisodeSettings episode;
    episode.max_frames = 40;
    std::vector<LaneSpec> specs;
    for (uint32_t i = 0; i < kEnvironments; ++i) {
        LaneSpec spec;
        spec.game = games[i % games.size()];
        spec.actions = {0, 1, 2, 3, 4, 5};
        spec.action_set = {0, 1, 2};
        spec.seed = {i, i};
        specs.push_back(spec);
    }
    VectorSettings settings;
    settings.batch_size = batch_size;
    settings.threads = threads;
    settings.autoreset = Autoreset::kSameStep;
    const auto rows = static_cast<size_t>(batch_size);
    Batch arrays;  // must outlive the threads
    BatchMemory memory;
    VectorEngine vector(make_lanes(specs, episode, ObservationSettings{}), settings);
    const BatchShape shape = vector.shape(true, false);
    memory.complete(arrays, shape);
    const Batch* const batch = batch_size == kEnvironments ? &arrays : nullptr;
    Digests digests(kEnvironments);
    std::vector<int> environments(rows);
    std::vector<int64_t> actions(rows);
    vector.reset(std::vector<bool>(kEnvironments, true), std::vector<const Seed*>(kEnvironments, nullptr), batch);
    for (int step = 0; step <= kSteps * kEnvironments / batch_size; ++step) {
        vector.receive(arrays);
        for (size_t row = 0; row < rows; ++row) {
            environments[row] = arrays.env_id[row];
            auto& results = digests[static_cast<size_t>(environments[row])];
            results.push_back(digest_of(arrays, shape, row));
            actions[row] = static_cast<int64_t>((results.size() * 7 + static_cast<size_t>(environments[row])) % 6);
        }
        for (int i = 0; forks && step % 3 == 0 && i < kEnvironments / 2; ++i)
            vector.restore(i + kEnvironments / 2, vector.snapshot(i));
        vector.step(environments, actions.data(), nullptr, batch);
    }
    return digests;  // environments may still be running
}

bool agree(const Digests& some, const Digests& others) {
    for (size_t i = 0; i < some.size(); ++i) {
        const size_t common = std::min(some[i].size(), others[i].size());
        if (common < 3 ||
            !std::equal(some[i].begin(), some[i].begin() + static_cast<std::ptrdiff_t>(common), others[i].begin())) {
            std::fprintf(stderr, "environment %zu differs\n", i);
            return false;
        }
    }
    return true;
}

}  // namespace
}  // namespace atari

int main(int count, char** arguments) {
    using namespace atari;
    if (count != 2) return std::fprintf(stderr, "usage: vector_threads FOLDER\n"), 2;
    try {
        const Games games = load_games(arguments[1]);
        const Digests expected = play(games, 1, kEnvironments);
        for (int batch_size : {kEnvironments, 4, 1})
            if (!agree(play(games, 4, batch_size), expected)) return 1;
        if (!agree(play(games, 4, kEnvironments, true), play(games, 1, kEnvironments, true))) return 1;
    } catch (const std::exception& error) {
        return std::fprintf(stderr, "%s\n", error.what()), 2;
    }
    std::printf("%d environments in batches of 20, 4 and 1 on four threads: the same bytes as on one\n", kEnvironments);
}
