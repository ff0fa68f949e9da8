#include "vector.hpp"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <utility>

#if defined(_WIN32)
#include <process.h>
#else
#include <unistd.h>
#endif

namespace atari {
namespace {

long process_number() {
#if defined(_WIN32)
    return _getpid();
#else
    return getpid();
#endif
}

}  // namespace

Vector::Vector(std::vector<Member> members, const VectorSettings& settings)
    : settings_(settings), process_(process_number()) {
    slots_.resize(members.size());
    for (size_t i = 0; i < members.size(); ++i) slots_[i].member = std::move(members[i]);
    pool_ = std::make_unique<ThreadPool>(size(), settings.threads, queued(), settings.first_core,
                                         [this](int environment) { work(environment); });
}

// A child process has none of the threads, and cannot wait for them.
Vector::~Vector() {
    if (process_ != process_number()) static_cast<void>(pool_.release());
}

void Vector::reset(const std::vector<bool>& chosen, const std::vector<const Seed*>& seeds, const Batch* batch) {
    for (size_t i = 0; i < slots_.size(); ++i) {
        Slot& slot = slots_[i];
        slot.task = chosen[i] ? Task::kReset : Task::kReport;
        if (seeds[i]) slot.seed_value = *seeds[i];
        slot.seed = seeds[i] ? &slot.seed_value : nullptr;
    }
    batch_ = batch;
    if (!queued()) return pool_->submit_all();
    std::vector<int> all(slots_.size());
    std::iota(all.begin(), all.end(), 0);
    pool_->submit(all.data(), size());
}

void Vector::step(const int* environments, const int64_t* actions, const float* strengths, int count,
                  const Batch* batch) {
    for (int i = 0; i < count; ++i) {
        Slot& slot = slots_[static_cast<size_t>(environments[i])];
        slot.task = Task::kStep;
        slot.action = slot.member.actions[static_cast<size_t>(actions[i])];
        slot.strength = strengths ? strengths[i] : 1.0f;
    }
    batch_ = batch;
    if (queued()) pool_->submit(environments, count);
    else pool_->submit_all();
}

void Vector::receive(const Batch& batch) {
    pool_->wait(settings_.batch_size);
    if (!queued()) return;
    const std::vector<int> environments = pool_->take(settings_.batch_size);
    for (int row = 0; row < settings_.batch_size; ++row) {
        const int environment = environments[static_cast<size_t>(row)];
        report(slot(environment), environment, row, batch);
    }
}

void Vector::drain() {
    const int left = pool_->pending();
    try {
        pool_->wait(left);
        if (queued()) pool_->take(left);
    } catch (...) {  // of a batch that nobody wants any more
    }
}

void Vector::settle(Slot& slot) {
    if (!slot.due) return;
    slot.member.player->copy_from(slot.due->player);
    slot.outcome = slot.due->outcome;
    slot.due = nullptr;
}

void Vector::work(int environment) {
    settle(slot(environment));
    play(slot(environment), environment);
    if (!queued()) report(slot(environment), environment, environment, *batch_);
}

void Vector::play(Slot& slot, int environment) {
    Player& player = *slot.member.player;
    slot.has_final = false;
    const bool over = slot.outcome.ended;
    if (slot.task == Task::kStep && over && settings_.autoreset == Autoreset::kDisabled) {
        slot.outcome.reward = 0;  // it waits for its reset
    } else if (slot.task == Task::kReset || (slot.task == Task::kStep && over)) {
        player.reset(slot.task == Task::kReset ? slot.seed : nullptr);
        slot.outcome = Outcome{};
    } else if (slot.task == Task::kStep) {
        slot.outcome = player.step(slot.action, slot.strength);
        if (!slot.outcome.ended || settings_.autoreset != Autoreset::kSameStep) return;
        keep_final(slot, environment);
        player.reset(nullptr);
        slot.outcome.ended = false;
    }
}

void Vector::keep_final(Slot& slot, int environment) {
    slot.has_final = true;
    Player& player = *slot.member.player;
    Environment& e = player.environment();
    if (queued()) {
        slot.final_pixels.resize(player.view().size());
        player.view().write(slot.final_pixels.data());
    } else if (batch_->final_observation.pixels) {
        player.view().write(batch_->final_observation.pixels + player.view().size() * static_cast<size_t>(environment));
    }
    std::copy_n(e.ram(), 128, slot.final_ram);
    const int32_t numbers[3] = {e.lives(), e.frame_number(), e.episode_frame_number()};
    std::copy_n(numbers, 3, slot.final_numbers);
}

void Vector::report(Slot& slot, int environment, int row, const Batch& batch) {
    Player& player = *slot.member.player;
    Environment& e = player.environment();
    const auto at = static_cast<size_t>(row);
    const Outcome& outcome = slot.outcome;
    if (batch.observation.pixels) player.view().write(batch.observation.pixels + player.view().size() * at);
    if (batch.observation.ram) std::copy_n(e.ram(), 128, batch.observation.ram + 128 * at);
    batch.environment[at] = environment;
    batch.reward[at] = outcome.reward;
    batch.terminated[at] = outcome.terminated;
    batch.truncated[at] = outcome.truncated;
    batch.numbers.lives[at] = e.lives();
    batch.numbers.frame[at] = e.frame_number();
    batch.numbers.episode_frame[at] = e.episode_frame_number();
    if (settings_.autoreset == Autoreset::kSameStep) report_final(slot, row, batch);
}

// A row of the final observations is that of an episode that ended in this step, or zero.
void Vector::report_final(Slot& slot, int row, const Batch& batch) {
    const auto at = static_cast<size_t>(row);
    const size_t size = slot.member.player->view().size();
    uint8_t* const pixels = batch.final_observation.pixels ? batch.final_observation.pixels + size * at : nullptr;
    uint8_t* const ram = batch.final_observation.ram ? batch.final_observation.ram + 128 * at : nullptr;
    if (slot.has_final) {
        if (pixels && queued()) std::copy(slot.final_pixels.begin(), slot.final_pixels.end(), pixels);
        if (ram) std::copy_n(slot.final_ram, 128, ram);
    } else if (batch.ended[at]) {  // of an earlier step
        if (pixels) std::memset(pixels, 0, size);
        if (ram) std::memset(ram, 0, 128);
    }
    batch.ended[at] = slot.has_final;
    const auto number = [&](int i) { return slot.has_final ? slot.final_numbers[i] : 0; };
    batch.final_numbers.lives[at] = number(0);
    batch.final_numbers.frame[at] = number(1);
    batch.final_numbers.episode_frame[at] = number(2);
}

namespace {

uint8_t* write_outcome(const Outcome& outcome, uint8_t* out) {
    *out = static_cast<uint8_t>(outcome.terminated | outcome.truncated << 1 | outcome.ended << 2);
    return out + 1;
}

}  // namespace

void Vector::save(int environment, uint8_t* out) {
    Player& settled = player(environment);
    settled.save(write_outcome(slot(environment).outcome, out));
}

bool Vector::load(int environment, const uint8_t* in) {
    if (!player(environment).load(in + 1)) return false;
    slot(environment).outcome = {0, (*in & 1) != 0, (*in & 2) != 0, (*in & 4) != 0};
    return true;
}

std::vector<uint8_t> Vector::Copy::bytes() const {
    const EnvironmentCopy& environment = player.environment;
    Console console(game->cartridge, game->console, environment.console.plain);
    console.copy_from(environment.console);
    std::vector<uint8_t> bytes(1 + sizeof environment.state + console.state_size() + player.rest.size());
    uint8_t* out = write_outcome(outcome, bytes.data());
    std::memcpy(out, &environment.state, sizeof environment.state);
    console.save(out + sizeof environment.state);
    std::copy(player.rest.begin(), player.rest.end(), bytes.end() - static_cast<std::ptrdiff_t>(player.rest.size()));
    return bytes;
}

Vector::Snapshot Vector::snapshot(int environment) {
    const Slot& source = slot(environment);
    if (source.due) return source.due;
    auto copy = std::make_shared<Copy>();
    copy->game = source.member.player->environment().game();
    source.member.player->copy_to(copy->player);
    copy->outcome = source.outcome;
    return copy;
}

Vector::Snapshot Vector::parse(int environment, const uint8_t* in) {
    Snapshot now = snapshot(environment);
    if (!load(environment, in)) return nullptr;
    Snapshot parsed = snapshot(environment);
    restore(environment, std::move(now));
    return parsed;
}

bool Vector::fits(int environment, const Copy& copy) const {
    Player& player = *slot(environment).member.player;
    return copy.game == player.environment().game() &&
           copy.player.rest.size() + 1 + player.environment().state_size() == state_size(environment);
}

}  // namespace atari
