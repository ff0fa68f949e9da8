// The maximum of many values, each of which may change.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace atari::memory {

// A binary tree in an array: node i has the children 2 i and 2 i + 1, and the values are the last half.
class MaxTree {
  public:
    explicit MaxTree(int64_t size) : size_(static_cast<size_t>(size)), nodes_(2 * size_) {}

    double get(int64_t index) const { return nodes_[size_ + static_cast<size_t>(index)]; }
    double greatest() const { return nodes_[1]; }
    const double* leaves() const { return nodes_.data() + size_; }

    void set(int64_t index, double value) {
        size_t i = size_ + static_cast<size_t>(index);
        nodes_[i] = value;
        while (i > 1) update(i /= 2);
    }

    void load(const std::vector<double>& leaves) {
        std::copy(leaves.begin(), leaves.end(), nodes_.begin() + static_cast<std::ptrdiff_t>(size_));
        for (size_t i = size_; i-- > 1;) update(i);
    }

  private:
    void update(size_t i) { nodes_[i] = std::max(nodes_[2 * i], nodes_[2 * i + 1]); }

    size_t size_;
    std::vector<double> nodes_;
};

}  // namespace atari::memory
