// The named inputs that fuzzing starts from, including one for each error that fuzzing has found.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace atari {

std::vector<std::pair<std::string, std::vector<uint8_t>>> fuzzing_seeds();

}  // namespace atari
