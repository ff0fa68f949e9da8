// Sums of priorities, which find a step with a probability in proportion to its priority (Schaul et al. 2016).
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace atari::memory {

// A tree whose nodes have 16 children in two cache lines each. A node is the sum of its children in a fixed order, so
// equal leaves give an equal tree, in whichever order they were set.
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

    // Sets each index in order, and computes each node above them once.
    void set(const std::vector<int64_t>& indices, const std::vector<double>& values) {
        for (const int64_t index : indices) prefetch(0, static_cast<size_t>(index) / kFan);
        std::vector<size_t> nodes;
        for (size_t i = 0; i < indices.size(); ++i) {
            levels_[0][static_cast<size_t>(indices[i])] = values[i];
            nodes.push_back(static_cast<size_t>(indices[i]));
        }
        std::sort(nodes.begin(), nodes.end());
        for (size_t level = 1; level < levels_.size(); ++level) {
            for (size_t& node : nodes) node /= kFan;
            nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
            for (const size_t node : nodes) levels_[level][node] = sum(&levels_[level - 1][node * kFan]);
        }
    }

    void load(const std::vector<double>& leaves) {
        std::copy(leaves.begin(), leaves.end(), levels_[0].begin());
        for (size_t level = 1; level < levels_.size(); ++level)
            for (size_t i = 0; i < levels_[level - 1].size() / kFan; ++i)
                levels_[level][i] = sum(&levels_[level - 1][i * kFan]);
    }

    // Returns the leaves at these masses of the total, none with priority 0 unless the total is 0. All masses are
    // followed level by level: the nodes of one mass are loaded while other masses are compared.
    std::vector<int64_t> find(std::vector<double> masses) const {
        std::vector<int64_t> found(masses.size());
        for (size_t level = levels_.size() - 1; level-- > 0;)
            for (size_t i = 0; i < masses.size(); ++i) {
                const auto node = static_cast<size_t>(found[i]);
                const size_t child = node * kFan + step_down(&levels_[level][node * kFan], masses[i]);
                found[i] = static_cast<int64_t>(child);
                if (level > 0) prefetch(level - 1, child);
            }
        return found;
    }

  private:
    static constexpr size_t kFan = 16;
    // Returns the child at `mass`, and reduces `mass` to the mass within this child.
    static size_t step_down(const double* children, double& mass) {
        size_t chosen = 0;  // rounding may leave a mass beyond the last child
        for (size_t child = 0; child < kFan; ++child) {
            if (children[child] <= 0) continue;
            chosen = child;
            if (mass < children[child]) break;
            mass -= children[child];
        }
        return chosen;
    }

    // Begins to load the children of a node, on the level below it.
    void prefetch([[maybe_unused]] size_t level, [[maybe_unused]] size_t node) const {
#if defined(__GNUC__)
        __builtin_prefetch(&levels_[level][node * kFan]);
        __builtin_prefetch(&levels_[level][node * kFan + kFan / 2]);
#endif
    }

    static double sum(const double* children) {
        double sums[4] = {children[0], children[1], children[2], children[3]};
        for (size_t i = 4; i < kFan; i += 4)
            for (size_t j = 0; j < 4; ++j) sums[j] += children[i + j];
        return (sums[0] + sums[1]) + (sums[2] + sums[3]);
    }

    std::vector<std::vector<double>> levels_;  // from leaves to root
};

}  // namespace atari::memory
