// Sums of priorities, by which a step is found in proportion to its own (Schaul et al. 2016).
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace atari::memory {

// Each node has 16 children, which share two cache lines. A node is always the sum of its children in one order, so
// equal leaves give an equal tree, however they were set.
class SumTree {
  public:
    explicit SumTree(int64_t size) {
        size_t nodes = static_cast<size_t>(size);
        do {
            nodes = (nodes + kFan - 1) / kFan * kFan;
            levels_.emplace_back(nodes);
            nodes /= kFan;
        } while (nodes > 1);
        levels_.emplace_back(1);
    }

    double get(int64_t index) const { return levels_[0][static_cast<size_t>(index)]; }
    double total() const { return levels_.back()[0]; }
    const double* leaves() const { return levels_[0].data(); }

    void set(int64_t index, double value) {
        auto i = static_cast<size_t>(index);
        levels_[0][i] = value;
        for (size_t level = 1; level < levels_.size(); ++level) {
            i /= kFan;
            levels_[level][i] = sum(&levels_[level - 1][i * kFan]);
        }
    }

    void load(const double* leaves, size_t count) {
        std::copy_n(leaves, count, levels_[0].begin());
        for (size_t level = 1; level < levels_.size(); ++level)
            for (size_t i = 0; i < levels_[level - 1].size() / kFan; ++i)
                levels_[level][i] = sum(&levels_[level - 1][i * kFan]);
    }

    // Returns the leaf at `mass` of the total: never one of priority 0, unless the total is 0.
    int64_t find(double mass) const {
        size_t i = 0;
        for (size_t level = levels_.size() - 1; level-- > 0;) {
            const double* const children = &levels_[level][i * kFan];
            size_t chosen = 0;  // rounding may leave a mass beyond the last child
            for (size_t child = 0; child < kFan; ++child) {
                if (children[child] <= 0) continue;
                chosen = child;
                if (mass < children[child]) break;
                mass -= children[child];
            }
            i = i * kFan + chosen;
        }
        return static_cast<int64_t>(i);
    }

  private:
    static constexpr size_t kFan = 16;
    static double sum(const double* children) {
        double sums[4] = {children[0], children[1], children[2], children[3]};
        for (size_t i = 4; i < kFan; i += 4)
            for (size_t j = 0; j < 4; ++j) sums[j] += children[i + j];
        return (sums[0] + sums[1]) + (sums[2] + sums[3]);
    }

    std::vector<std::vector<double>> levels_;  // from the leaves to the root
};

}  // namespace atari::memory
