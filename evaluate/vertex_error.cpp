#include "evaluate/vertex_error.h"

#include <algorithm>
#include <cmath>

namespace pleat::evaluate {

VertexError vertex_error(const Eigen::Ref<const Points3>& vertices,
                         const Eigen::Ref<const Points3>& truth) {
  Eigen::VectorXd errors = encode::vertex_distances_mm(vertices, truth);
  if (errors.size() == 0) return {};
  // The smallest error that at least 95 % of the vertices do not exceed.
  const Eigen::Index rank =
      static_cast<Eigen::Index>(std::ceil(0.95 * static_cast<double>(errors.size()))) - 1;
  std::nth_element(errors.data(), errors.data() + rank, errors.data() + errors.size());
  return {errors.mean(), errors[rank], errors.maxCoeff()};
}

VertexError vertex_error(const encode::ErrorSummary& errors_mm) {
  return {errors_mm.mean(), errors_mm.percentile(95), errors_mm.max()};
}

}  // namespace pleat::evaluate
