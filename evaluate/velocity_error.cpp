#include "evaluate/velocity_error.h"

namespace pleat::evaluate {

double velocity_error_mm_per_s(const Eigen::Ref<const Points3>& previous,
                               const Eigen::Ref<const Points3>& current,
                               const Eigen::Ref<const Points3>& previous_truth,
                               const Eigen::Ref<const Points3>& truth, double frame_rate_hz) {
  if (current.rows() == 0) return 0;
  const Points3 difference = (current - previous) - (truth - previous_truth);
  return 1000 * frame_rate_hz * difference.rowwise().norm().mean();
}

}  // namespace pleat::evaluate
