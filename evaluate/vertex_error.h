// How far a sampled garment lies from the simulated one, vertex by vertex (paper, figure 5 left).
#pragma once

#include "core/types.h"
#include "encode/error_summary.h"

namespace pleat::evaluate {

struct VertexError {
  double mean_mm = 0;
  double p95_mm = 0;
  double max_mm = 0;
};

VertexError vertex_error(const Eigen::Ref<const Points3>& vertices,
                         const Eigen::Ref<const Points3>& truth);
VertexError vertex_error(const encode::ErrorSummary& errors_mm);

}  // namespace pleat::evaluate
