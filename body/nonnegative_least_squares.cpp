#include "body/nonnegative_least_squares.h"

#include <Eigen/QR>
#include <algorithm>
#include <vector>

namespace pleat::body {
namespace {

Eigen::VectorXd solve_on(const Eigen::MatrixXd& A, const Eigen::VectorXd& b,
                         const std::vector<int>& columns) {
  Eigen::MatrixXd part(A.rows(), static_cast<Eigen::Index>(columns.size()));
  for (size_t k = 0; k < columns.size(); ++k)
    part.col(static_cast<Eigen::Index>(k)) = A.col(columns[k]);
  return part.colPivHouseholderQr().solve(b);
}

}  // namespace

Eigen::VectorXd nonnegative_least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
  Eigen::VectorXd x = Eigen::VectorXd::Zero(A.cols());
  std::vector<int> passive;  // columns that may be above zero
  std::vector<char> is_passive(static_cast<size_t>(A.cols()), 0);
  const double tolerance = 1e-10 * (A.transpose() * b).cwiseAbs().maxCoeff();
  const int most_rounds = 3 * static_cast<int>(A.cols());
  for (int round = 0; round < most_rounds; ++round) {
    const Eigen::VectorXd gain = A.transpose() * (b - A * x);
    int enters = -1;
    for (int j = 0; j < gain.size(); ++j) {
      if (!is_passive[j] && gain[j] > tolerance && (enters < 0 || gain[j] > gain[enters]))
        enters = j;
    }
    if (enters < 0 || static_cast<Eigen::Index>(passive.size()) >= A.rows()) break;
    passive.push_back(enters);
    is_passive[enters] = 1;
    for (;;) {
      const Eigen::VectorXd solution = solve_on(A, b, passive);
      double step = 1;  // towards the solution, until an entry reaches zero
      for (size_t k = 0; k < passive.size(); ++k) {
        const double now = x[passive[k]], then = solution[static_cast<Eigen::Index>(k)];
        if (then <= 0) step = std::min(step, now > 0 ? now / (now - then) : 0.0);
      }
      for (size_t k = 0; k < passive.size(); ++k) {
        x[passive[k]] += step * (solution[static_cast<Eigen::Index>(k)] - x[passive[k]]);
      }
      if (step >= 1) break;
      std::vector<int> kept;
      for (int column : passive) {
        if (x[column] > 1e-14) {
          kept.push_back(column);
        } else {
          x[column] = 0;
          is_passive[column] = 0;
        }
      }
      if (kept.size() == passive.size() || kept.empty()) break;
      passive = kept;
    }
    if (!is_passive[enters]) break;  // rounding: it can no longer gain
  }
  return x;
}

}  // namespace pleat::body
