#pragma once

#include <Eigen/Core>

namespace pleat::body {

// Minimises |A x - b| over x >= 0 by the active-set method of Lawson and Hanson (1974). The answer
// has at most as many entries above zero as A has rows.
Eigen::VectorXd nonnegative_least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);

}  // namespace pleat::body
