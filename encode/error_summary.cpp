#include "encode/error_summary.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace pleat::encode {
namespace {

constexpr double kSmallest = 1e-6;  // mm, bin 0 holds all below
const double kLogGrowth = std::log(1.01);

size_t bin_of(double error_mm) {
  return error_mm < kSmallest
             ? 0
             : 1 + static_cast<size_t>(std::log(error_mm / kSmallest) / kLogGrowth);
}

double upper_end(size_t bin) {
  return bin == 0 ? 0 : kSmallest * std::exp(kLogGrowth * static_cast<double>(bin));
}

}  // namespace

void ErrorSummary::add(double error_mm) {
  assert(error_mm >= 0 && std::isfinite(error_mm));
  const size_t bin = bin_of(error_mm);
  if (bin >= bins_.size()) bins_.resize(bin + 1, 0);
  ++bins_[bin];
  ++count_;
  sum_ += error_mm;
  max_ = std::max(max_, error_mm);
}

void ErrorSummary::add(const ErrorSummary& other) {
  if (other.bins_.size() > bins_.size()) bins_.resize(other.bins_.size(), 0);
  for (size_t i = 0; i < other.bins_.size(); ++i) bins_[i] += other.bins_[i];
  count_ += other.count_;
  sum_ += other.sum_;
  max_ = std::max(max_, other.max_);
}

double ErrorSummary::mean() const { return count_ ? sum_ / static_cast<double>(count_) : 0; }

double ErrorSummary::percentile(double percent) const {
  const double target = percent / 100 * static_cast<double>(count_);
  int64_t seen = 0;
  for (size_t i = 0; i < bins_.size(); ++i) {
    seen += bins_[i];
    if (static_cast<double>(seen) >= target && seen > 0) return std::min(max_, upper_end(i));
  }
  return max_;
}

Eigen::VectorXd vertex_distances_mm(const Eigen::Ref<const Points3>& a,
                                    const Eigen::Ref<const Points3>& b) {
  return 1000 * (a - b).rowwise().norm();
}

}  // namespace pleat::encode
