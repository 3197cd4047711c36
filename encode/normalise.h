// Offsets <-> the unit scale that a learner sees, measured on the training split.
#pragma once

#include <cstdint>
#include <vector>

#include "encode/texture.h"

namespace pleat::encode {

struct Normalisation {
  Vec<3> mean = Vec<3>::Zero();  // m, per axis
  Vec<3> std = Vec<3>::Ones();   // m, > 0
};

// Sums over the inside texels (mask 1) of the textures added.
struct OffsetSums {
  int64_t count = 0;
  Vec<3> sum = Vec<3>::Zero();      // m
  Vec<3> squares = Vec<3>::Zero();  // m^2
};
void add(OffsetSums& sums, const Texture& texture, const std::vector<uint8_t>& mask);
// A spread below a micrometre counts as one, so that a constant axis does not divide by zero.
Normalisation normalisation(const OffsetSums& sums);

// (offset - mean) / std where the mask is not 0, and 0 elsewhere. And back, in metres.
Texture normalise(const Texture& texture, const Normalisation& normalisation,
                  const std::vector<uint8_t>& mask);
Texture denormalise(const Texture& texture, const Normalisation& normalisation,
                    const std::vector<uint8_t>& mask);

}  // namespace pleat::encode
