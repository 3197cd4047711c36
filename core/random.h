#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

namespace pleat {

// A named random stream: the same (seed, name) gives the same numbers on any machine, whatever else was drawn.
// Names read like paths: "shape/3", "clip/walk/7/texture".
class RandomStream {
 public:
  RandomStream(uint64_t seed, std::string_view name);
  uint64_t next();                    // uniform over 64 bits
  double uniform();                   // [0, 1), 53 bits
  double normal();                    // mean 0, variance 1
  int64_t below(int64_t bound);       // uniform in 0 .. bound - 1
  std::vector<int64_t> permutation(int64_t count);

 private:
  uint64_t state_[4];  // xoshiro256**
  double spare_ = 0;
  bool has_spare_ = false;
};

}  // namespace pleat
