#include "causes.hpp"

#include <algorithm>
#include <cstring>
#include <stdexcept>

#include "ale/environment_parts.hpp"
#include "fast/fast_console.hpp"
#include "shift.hpp"
#include "vector/thread_pool.hpp"

namespace atari {
namespace {

// SplitMix64: returns a random word for any number.
uint64_t random_word(uint64_t number) {
    number += 0x9e3779b97f4a7c15ull;
    number = (number ^ number >> 30) * 0xbf58476d1ce4e5b9ull;
    number = (number ^ number >> 27) * 0x94d049bb133111ebull;
    return number ^ number >> 31;
}

// Returns the value to which fork number `fork` changes a byte, never its present value. Fork 0 adds or subtracts one,
// fork 1 flips one bit, and all other forks take any other value.
uint8_t changed(uint8_t value, int fork, uint64_t random) {
    if (fork == 0) return static_cast<uint8_t>(random & 1 ? value + 1 : value - 1);
    if (fork == 1) return static_cast<uint8_t>(value ^ 1u << (random & 7));
    return static_cast<uint8_t>(value + 1 + random % 255);
}

// The frame of a fast console that ran last, as far as its screen depends on it.
struct Log {
    bool known = false;
    Tia start;
    int32_t reached;
    std::vector<TiaWrite> writes;
};

FastConsole& console_of(Environment& environment) { return static_cast<FastConsole&>(*environment.parts().console); }

Log log_of(Environment& environment) {
    const FrameLog* const log = console_of(environment).deferred_frame();
    if (!log) return {};
    return {true, log->start, log->reached, {log->writes, log->writes + log->size}};
}

// Returns whether the frame that ran last shows the same screen for certain: its TIA writes are the same.
bool same_screen(Environment& environment, const Log& twin) {
    const FrameLog* const log = console_of(environment).deferred_frame();
    return log && twin.known && log->reached == twin.reached && static_cast<size_t>(log->size) == twin.writes.size() &&
           std::memcmp(&log->start, &twin.start, sizeof(Tia)) == 0 &&
           std::memcmp(log->writes, twin.writes.data(), twin.writes.size() * sizeof(TiaWrite)) == 0;
}

// The twin after a frame.
struct Moment {
    Machine machine;
    std::vector<uint8_t> cartridge_ram, screen;
    std::array<int32_t, kMaxVariables> variables;
    int reward, lives;
    bool over;
    Log log;
};

}  // namespace

class Causes::Worker {
  public:
    Worker(const Causes& causes, const std::shared_ptr<const Game>& game)
        : causes_(causes), environment_(game, Settings{0.0, 1, 0, false, false, false}, 0), bytes(kRamBytes),
          pixels(static_cast<size_t>(kRamBytes) * causes.height_ * kScreenWidth),
          moments_(static_cast<size_t>(causes.frames_)) {}

    void explore(const EnvironmentSnapshot& state, const uint8_t* actions, int number);
    bool fits(const EnvironmentSnapshot& state) { return environment_.restore(state); }

  private:
    void play_twin(const EnvironmentSnapshot& state, const uint8_t* actions);
    void play_fork(const EnvironmentSnapshot& state, const uint8_t* actions, ForkEffect effect);
    bool rejoins(const Moment& twin);
    bool compare_screens(const Moment& twin, ForkEffect& effect);

    const Causes& causes_;
    Environment environment_;

  public:
    std::vector<ByteCauses> bytes;
    std::vector<uint16_t> pixels;
    std::vector<std::vector<ForkEffect>> effects;  // by state of the call
    uint64_t frames = 0;

  private:
    std::vector<Moment> moments_;
    ScreenDifference difference_;
};

void Causes::Worker::explore(const EnvironmentSnapshot& state, const uint8_t* actions, int number) {
    effects.emplace_back();
    play_twin(state, actions);
    environment_.restore(state);
    std::array<uint8_t, kRamBytes> ram;
    std::copy_n(environment_.ram(), kRamBytes, ram.begin());
    for (int byte = 0; byte < kRamBytes; ++byte)
        for (int fork = 0; fork < causes_.values_; ++fork) {
            const auto place = static_cast<uint64_t>((number * kRamBytes + byte) * kMostForkValues + fork);
            const uint64_t random = random_word(causes_.seed_ + random_word(place));
            ForkEffect effect{};
            effect.state = number;
            effect.byte = byte;
            effect.old_value = ram[static_cast<size_t>(byte)];
            effect.new_value = changed(ram[static_cast<size_t>(byte)], fork, random);
            play_fork(state, actions, effect);
        }
}

void Causes::Worker::play_twin(const EnvironmentSnapshot& state, const uint8_t* actions) {
    environment_.restore(state);
    int reward = 0;
    for (int frame = 0; frame < causes_.frames_; ++frame) {
        Moment& moment = moments_[static_cast<size_t>(frame)];
        reward += environment_.act({actions[frame]})[0];
        ++frames;
        Console& console = console_of(environment_);
        console.settle_latches();
        moment.machine = console.machine();
        moment.cartridge_ram.assign(console.cartridge_ram(), console.cartridge_ram() + console.cartridge_ram_size());
        std::copy_n(environment_.parts().state.variables, kMaxVariables, moment.variables.begin());
        moment.reward = reward;
        moment.lives = environment_.lives();
        moment.over = environment_.game_over();
        moment.log = log_of(environment_);
    }
    // Rendered in a second pass: rendering does not change the state, but the logs above must not be rendered yet.
    environment_.restore(state);
    for (int frame = 0; frame < causes_.frames_; ++frame) {
        Moment& moment = moments_[static_cast<size_t>(frame)];
        environment_.act({actions[frame]});
        moment.screen.resize(static_cast<size_t>(causes_.height_) * kScreenWidth);
        environment_.screen(moment.screen.data());
    }
}

// Returns whether the fork will not differ from its twin any more.
bool Causes::Worker::rejoins(const Moment& twin) {
    Console& console = console_of(environment_);
    if (std::memcmp(console.ram(), twin.machine.riot.ram, kRamBytes) != 0) return false;
    if (!std::equal(twin.variables.begin(), twin.variables.end(), environment_.parts().state.variables)) return false;
    console.settle_latches();
    return std::memcmp(&console.machine(), &twin.machine, sizeof(Machine)) == 0 &&
           std::equal(twin.cartridge_ram.begin(), twin.cartridge_ram.end(), console.cartridge_ram());
}

void Causes::Worker::play_fork(const EnvironmentSnapshot& state, const uint8_t* actions, ForkEffect effect) {
    environment_.restore(state);
    environment_.set_ram(effect.byte, effect.new_value);
    ByteCauses& counts = bytes[static_cast<size_t>(effect.byte)];
    ++counts.forks;
    std::array<bool, kRamBytes> differs{};
    bool others = false, own = true;
    int reward = 0;
    for (int frame = 0; frame < causes_.frames_; ++frame) {
        const Moment& twin = moments_[static_cast<size_t>(frame)];
        reward += environment_.act({actions[frame]})[0];
        ++frames;
        const uint8_t* const ram = environment_.ram();
        for (int byte = 0; byte < kRamBytes; ++byte)
            if (ram[byte] != twin.machine.riot.ram[byte] && byte != effect.byte) {
                differs[static_cast<size_t>(byte)] = others = true;
                if (frame == 0) ++counts.writes[byte];
            }
        own = ram[effect.byte] != twin.machine.riot.ram[effect.byte];
        effect.reward_later = reward - twin.reward;
        effect.lives_later = environment_.lives() - twin.lives;
        effect.over |= environment_.game_over() && !twin.over;
        if (frame == 0) {
            effect.reward = effect.reward_later;
            effect.lives = effect.lives_later;
            counts.rewritten += !own;
        }
        if (!effect.frame && !same_screen(environment_, twin.log) && compare_screens(twin, effect)) {
            effect.frame = frame + 1;
            effect.old_then = twin.machine.riot.ram[effect.byte];
            effect.new_then = ram[effect.byte];
            ++counts.seen_at[frame];
        }
        if (rejoins(twin)) break;
    }
    for (int byte = 0; byte < kRamBytes; ++byte) counts.later[byte] += differs[static_cast<size_t>(byte)];
    const bool scored = effect.reward != 0 || effect.reward_later != 0;
    const bool lived = effect.lives != 0 || effect.lives_later != 0;
    counts.seen += effect.frame != 0;
    counts.rewarded += scored;
    counts.lives += lived;
    counts.over += effect.over != 0;
    const bool nothing = !others && !effect.frame && !scored && !lived && !effect.over;
    counts.vanished += nothing && !own;
    counts.inert += nothing && own;
    if (!nothing && (effect.frame || scored || lived || effect.over)) effects.back().push_back(effect);
}

// Compares the present screen with the twin's. Returns whether a pixel differs, and describes the difference.
bool Causes::Worker::compare_screens(const Moment& twin, ForkEffect& effect) {
    const uint8_t* const screen = console_of(environment_).framebuffer();
    uint16_t* const counts = pixels.data() + static_cast<size_t>(effect.byte) * causes_.height_ * kScreenWidth;
    ScreenDifference& d = difference_;
    d.places.clear();
    d.left = kScreenWidth;
    d.top = d.right = d.bottom = -1;
    for (int row = 0; row < causes_.height_; ++row) {
        const int begin = row * kScreenWidth;
        if (std::memcmp(screen + begin, twin.screen.data() + begin, kScreenWidth) == 0) continue;
        if (d.top < 0) d.top = row;
        d.bottom = row;
        for (int x = 0; x < kScreenWidth; ++x) {
            if (screen[begin + x] == twin.screen[static_cast<size_t>(begin + x)]) continue;
            ++counts[begin + x];
            d.left = std::min(d.left, x);
            d.right = std::max(d.right, x);
            d.places.push_back(begin + x);
        }
    }
    if (d.places.empty()) return false;
    effect.left = d.left;
    effect.top = d.top;
    effect.right = d.right;
    effect.bottom = d.bottom;
    effect.pixels = static_cast<int32_t>(d.places.size());
    effect.unbalanced = unbalanced(d, twin.screen.data(), screen);
    if (effect.unbalanced > 50) return true;
    const Shift x = find_shift(d, twin.screen.data(), screen, true, causes_.height_);
    const Shift y = find_shift(d, twin.screen.data(), screen, false, causes_.height_);
    effect.dx = x.distance;
    effect.dx_score = x.score;
    effect.dy = y.distance;
    effect.dy_score = y.score;
    return true;
}

Causes::Causes(std::shared_ptr<const Game> game, int values, int frames, int threads, uint64_t seed)
    : values_(values), frames_(frames), height_(game->height()), seed_(seed), bytes_(kRamBytes),
      pixels_(static_cast<size_t>(kRamBytes) * height_ * kScreenWidth) {
    if (values < 1 || values > kMostForkValues || frames < 1 || frames > kMostForkFrames || threads < 1)
        throw std::invalid_argument("values must be within 1..64, frames within 1..60, threads at least 1");
    for (int i = 0; i < threads; ++i) workers_.push_back(std::make_unique<Worker>(*this, game));
}

Causes::~Causes() = default;

uint64_t Causes::frames_played() const {
    uint64_t sum = 0;
    for (const auto& worker : workers_) sum += worker->frames;
    return sum;
}

bool Causes::explore(const std::vector<const EnvironmentSnapshot*>& states, const uint8_t* actions, int first) {
    for (const EnvironmentSnapshot* state : states)
        if (!workers_[0]->fits(*state)) return false;
    const int count = static_cast<int>(states.size()), threads = static_cast<int>(workers_.size());
    ThreadPool pool(threads, threads, false, -1, [&](int item) {
        for (int i = item; i < count; i += threads)
            workers_[static_cast<size_t>(item)]->explore(*states[static_cast<size_t>(i)], actions + i * frames_,
                                                         first + i);
    });
    pool.submit_all();
    pool.wait(threads);
    for (int i = 0; i < count; ++i) {
        const auto& found = workers_[static_cast<size_t>(i % threads)]->effects[static_cast<size_t>(i / threads)];
        effects_.insert(effects_.end(), found.begin(), found.end());
    }
    for (const auto& worker : workers_) {
        for (size_t i = 0; i < pixels_.size(); ++i) pixels_[i] = static_cast<uint16_t>(pixels_[i] + worker->pixels[i]);
        for (size_t byte = 0; byte < kRamBytes; ++byte) {
            auto* const sum = reinterpret_cast<uint32_t*>(&bytes_[byte]);
            const auto* const part = reinterpret_cast<const uint32_t*>(&worker->bytes[byte]);
            for (size_t i = 0; i < sizeof(ByteCauses) / sizeof(uint32_t); ++i) sum[i] += part[i];
        }
        std::fill(worker->pixels.begin(), worker->pixels.end(), uint16_t{0});
        worker->bytes.assign(kRamBytes, {});
        worker->effects.clear();
    }
    return true;
}

}  // namespace atari
