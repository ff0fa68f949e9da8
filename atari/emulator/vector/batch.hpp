// `Batch`: the arrays that the results of a batch are written to. Their names are those of `_emulator.Batch.arrays`, of the
// results in atari/vector/results.py, and of what functions compiled by JAX get.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace atari {

// The sizes of a batch's arrays.
struct BatchShape {
    size_t rows, players;
    size_t pixels, ram;  // bytes in an observation; 0 if it has no such part
    bool has_final;      // whether rows have final observations

    // Whether an engine with batches of shape `other` writes within these arrays.
    bool fits(const BatchShape& other) const {
        return rows == other.rows && players == other.players && has_final == other.has_final &&
               (pixels == 0 || pixels == other.pixels);
    }
};

// An array has a row for each environment of the batch. Arrays that are null are not written.
struct Batch {
    uint8_t *pixels = nullptr, *ram = nullptr;
    int32_t* env_id = nullptr;
    int32_t *reward = nullptr, *game_reward = nullptr;  // `game_reward` is not clipped
    bool *terminated = nullptr, *truncated = nullptr;
    int32_t *lives = nullptr, *frame_number = nullptr, *episode_frame_number = nullptr;
    int32_t* elapsed_step = nullptr;  // steps of the game
    bool* game_over = nullptr;
    // The game that ended in this step or reset; zero where none did.
    bool* game_ended = nullptr;
    double *score = nullptr, *frames = nullptr, *seconds = nullptr;
    // The final observation, with Autoreset::kSameStep; zero where no episode ended.
    bool* ended = nullptr;
    uint8_t *final_pixels = nullptr, *final_ram = nullptr;
    int32_t *final_lives = nullptr, *final_frame_number = nullptr, *final_episode_frame_number = nullptr;

    // Calls `visit(name, member, values in a row)` for each array.
    template <typename Visit>
    static void for_each(const BatchShape& shape, Visit&& visit) {
        const size_t players = shape.players;
        if (shape.pixels) visit("pixels", &Batch::pixels, shape.pixels);
        if (shape.ram) visit("ram", &Batch::ram, shape.ram);
        visit("env_id", &Batch::env_id, size_t{1});
        visit("reward", &Batch::reward, players);
        visit("game_reward", &Batch::game_reward, players);
        visit("terminated", &Batch::terminated, players);
        visit("truncated", &Batch::truncated, players);
        visit("lives", &Batch::lives, players);
        visit("frame_number", &Batch::frame_number, size_t{1});
        visit("episode_frame_number", &Batch::episode_frame_number, size_t{1});
        visit("elapsed_step", &Batch::elapsed_step, size_t{1});
        visit("game_over", &Batch::game_over, size_t{1});
        visit("game_ended", &Batch::game_ended, size_t{1});
        visit("score", &Batch::score, players);
        visit("frames", &Batch::frames, size_t{1});
        visit("seconds", &Batch::seconds, size_t{1});
        if (!shape.has_final) return;
        visit("ended", &Batch::ended, size_t{1});
        if (shape.pixels) visit("final_pixels", &Batch::final_pixels, shape.pixels);
        if (shape.ram) visit("final_ram", &Batch::final_ram, shape.ram);
        visit("final_lives", &Batch::final_lives, players);
        visit("final_frame_number", &Batch::final_frame_number, size_t{1});
        visit("final_episode_frame_number", &Batch::final_episode_frame_number, size_t{1});
    }
};

// The memory of arrays of a batch.
class BatchMemory {
  public:
    // Gives the batch each array that it lacks, filled with zeros.
    void complete(Batch& batch, const BatchShape& shape) {
        Batch::for_each(shape, [&]<typename T>(const char*, T* Batch::* member, size_t width) {
            if (batch.*member) return;
            arrays_.push_back(std::shared_ptr<T[]>(new T[width * shape.rows]()));
            batch.*member = static_cast<T*>(arrays_.back().get());
        });
    }

  private:
    std::vector<std::shared_ptr<void>> arrays_;
};

}  // namespace atari
