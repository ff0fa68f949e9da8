// Runs the fuzz target without libFuzzer: first the seeds, then mutations of them by a fixed generator. Any compiler
// with sanitizers can build it, and every run is the same.
//
// usage: fuzz_replay                        the seeds
//        fuzz_replay --seconds N            the seeds, and mutations of them for N seconds
//        fuzz_replay FILE ...               these inputs
//        fuzz_replay --write-seeds FOLDER   a file for each seed
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include <unistd.h>

#include "seeds.hpp"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

namespace {

using Bytes = std::vector<uint8_t>;

constexpr size_t kLongest = 4096;
constexpr unsigned kPatience = 60;  // seconds for an input, after which a signal ends the process

void run(const Bytes& input) {
    alarm(kPatience);
    const Bytes exact(input);  // without spare capacity, so that sanitizers detect a read after the end
    LLVMFuzzerTestOneInput(exact.data(), exact.size());
    alarm(0);
}

Bytes read_file(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) {
        std::fprintf(stderr, "cannot read %s\n", path.c_str());
        std::exit(2);
    }
    return Bytes(std::istreambuf_iterator<char>(file), {});
}

void write_file(const std::filesystem::path& path, const Bytes& bytes) {
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

// Makes up to eight changes: replaces a byte or a bit, removes or inserts bytes, or appends the end of another input.
Bytes mutated(Bytes input, const Bytes& other, std::mt19937& random) {
    const auto below = [&](size_t limit) { return limit == 0 ? 0 : random() % limit; };
    for (size_t changes = 1 + below(8); changes > 0; --changes) {
        const size_t at = below(input.size());
        const auto place = input.begin() + static_cast<std::ptrdiff_t>(at);
        switch (random() % 6) {
            case 0:
                if (!input.empty()) input[at] = static_cast<uint8_t>(random());
                break;
            case 1:
                if (!input.empty()) input[at] = static_cast<uint8_t>(input[at] ^ 1u << random() % 8);
                break;
            case 2:
                if (!input.empty()) input[at] = random() % 2 ? 0xff : 0x00;
                break;
            case 3:
                input.erase(place, place + static_cast<std::ptrdiff_t>(below(std::min<size_t>(8, input.size() - at))));
                break;
            case 4: input.insert(place, 1 + below(4), static_cast<uint8_t>(random())); break;
            default:
                input.resize(at);
                if (!other.empty())
                    input.insert(input.end(), other.end() - static_cast<std::ptrdiff_t>(below(other.size())),
                                 other.end());
        }
    }
    input.resize(std::min(input.size(), kLongest));
    return input;
}

}  // namespace

int main(int count, char** arguments) {
    const std::vector<std::string> given(arguments + 1, arguments + count);
    const bool writes = given.size() == 2 && given[0] == "--write-seeds";
    const bool timed = given.size() == 2 && given[0] == "--seconds";
    const auto seeds = atari::fuzzing_seeds();
    if (writes) {
        for (const auto& [name, bytes] : seeds) write_file(std::filesystem::path(given[1]) / name, bytes);
        return 0;
    }
    if (!given.empty() && !timed) {
        for (const std::string& path : given) run(read_file(path));
        return 0;
    }

    const auto start = std::chrono::steady_clock::now();
    const auto elapsed = [&] {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    };
    const double seconds = timed ? std::stod(given[1]) : 0;
    const std::filesystem::path current = "fuzz-current-input";  // the file remains if this input ends the process
    const auto play = [&](const Bytes& input) {
        write_file(current, input);
        run(input);
    };
    for (const auto& [name, bytes] : seeds) play(bytes);
    std::mt19937 random(1);
    long mutations = 0;
    for (; elapsed() < seconds; ++mutations) {
        const size_t first = random() % seeds.size(), second = random() % seeds.size();
        play(mutated(seeds[first].second, seeds[second].second, random));
    }
    std::filesystem::remove(current);
    std::printf("%zu seeds and %ld changes of them in %.0f s, nothing found\n", seeds.size(), mutations, elapsed());
}
