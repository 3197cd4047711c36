#include "evaluate/diversity.h"

#include <cassert>

namespace pleat::evaluate {

double spread_mm(const std::vector<Points3>& samples) {
  assert(samples.size() >= 2);
  const double count = static_cast<double>(samples.size());
  Points3 mean = Points3::Zero(samples.front().rows(), 3);
  for (const Points3& sample : samples) mean += sample / count;
  Eigen::VectorXd variance = Eigen::VectorXd::Zero(mean.rows());
  for (const Points3& sample : samples) variance += (sample - mean).rowwise().squaredNorm() / count;
  return mean.rows() ? 1000 * variance.cwiseSqrt().mean() : 0;
}

}  // namespace pleat::evaluate
