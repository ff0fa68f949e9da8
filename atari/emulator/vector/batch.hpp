// `Batch`: the arrays that the results of a batch are written to. Python, and functions compiled by JAX, get them by
// their names in batch.def.
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
    size_t own_rewards;  // 1 if the task has a reward of its own, else 0

    // Returns whether an engine with batches of shape `other` writes within these arrays.
    bool fits(const BatchShape& other) const {
        return rows == other.rows && players == other.players && has_final == other.has_final &&
               own_rewards == other.own_rewards && (pixels == 0 || pixels == other.pixels);
    }
};

// An array has a row for each environment of the batch. Arrays that are null are not written.
struct Batch {
#define ARRAY(type, name, width) type* name = nullptr;
#define FINAL(type, name, width) type* name = nullptr;
#include "batch.def"

    // Calls `visit(name, member, values in a row)` for each array that batches of this shape have.
    template <typename Visit>
    static void for_each(const BatchShape& shape, Visit&& visit) {
#define ARRAY(type, name, width) \
    if (width) visit(#name, &Batch::name, size_t{width});
#define FINAL(type, name, width) \
    if (shape.has_final && width) visit(#name, &Batch::name, size_t{width});
#include "batch.def"
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
