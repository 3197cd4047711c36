#include "encode/normalise.h"

#include <algorithm>
#include <cmath>

namespace pleat::encode {
namespace {

constexpr double kSmallestStd = 1e-6;  // m

// value -> scale[c] * value + shift[c] where the mask is not 0, 0 elsewhere
Texture affine(const Texture& texture, const Vec<3>& scale, const Vec<3>& shift,
               const std::vector<uint8_t>& mask) {
  Texture result{texture.size, std::vector<float>(texture.values.size(), 0.0f)};
  for (size_t c = 0; c < 3; ++c) {
    const Eigen::Index axis = static_cast<Eigen::Index>(c);
    for (size_t i = 0; i < mask.size(); ++i) {
      if (mask[i] == kEmpty) continue;
      const size_t k = c * mask.size() + i;
      result.values[k] =
          static_cast<float>(scale[axis] * static_cast<double>(texture.values[k]) + shift[axis]);
    }
  }
  return result;
}

}  // namespace

void add(OffsetSums& sums, const Texture& texture, const std::vector<uint8_t>& mask) {
  for (size_t i = 0; i < mask.size(); ++i) {
    if (mask[i] != kInside) continue;
    const Vec<3> offset(texture.values[i], texture.values[mask.size() + i],
                        texture.values[2 * mask.size() + i]);
    ++sums.count;
    sums.sum += offset;
    sums.squares += offset.cwiseAbs2();
  }
}

Normalisation normalisation(const OffsetSums& sums) {
  Normalisation result;
  if (sums.count == 0) return result;
  const double count = static_cast<double>(sums.count);
  result.mean = sums.sum / count;
  for (int c = 0; c < 3; ++c) {
    const double variance = sums.squares[c] / count - result.mean[c] * result.mean[c];
    result.std[c] = std::max(kSmallestStd, std::sqrt(std::max(0.0, variance)));
  }
  return result;
}

Texture normalise(const Texture& texture, const Normalisation& normalisation,
                  const std::vector<uint8_t>& mask) {
  const Vec<3> scale = normalisation.std.cwiseInverse();
  return affine(texture, scale, -normalisation.mean.cwiseProduct(scale), mask);
}

Texture denormalise(const Texture& texture, const Normalisation& normalisation,
                    const std::vector<uint8_t>& mask) {
  return affine(texture, normalisation.std, normalisation.mean, mask);
}

}  // namespace pleat::encode
