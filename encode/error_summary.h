// Many errors in millimetres, summed up without keeping them.
#pragma once

#include <cstdint>
#include <vector>

#include "core/types.h"

namespace pleat::encode {

// Percentiles come from bins that grow by 1 % from a nanometre up: exact to 1 %, in fixed memory,
// whatever the order.
class ErrorSummary {
 public:
  void add(double error_mm);  // >= 0
  void add(const ErrorSummary& other);
  int64_t count() const { return count_; }
  double mean() const;  // 0 where nothing was added
  double max() const { return max_; }
  double percentile(double percent) const;

 private:
  std::vector<int64_t> bins_;
  int64_t count_ = 0;
  double sum_ = 0, max_ = 0;
};

// Distance of each vertex to its counterpart, mm.
Eigen::VectorXd vertex_distances_mm(const Eigen::Ref<const Points3>& a,
                                    const Eigen::Ref<const Points3>& b);

}  // namespace pleat::encode
