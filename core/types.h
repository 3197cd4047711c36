// The arrays that every stage passes on. One row a vertex or a face, row-major, so that HDF5, torch
// and the solver's flat vector see the same memory. SI units unless a name says otherwise.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>

namespace pleat {

using Points3 = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;  // # x 3, m
using Points2 = Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor>;  // # x 2, m or UV
using Faces = Eigen::Matrix<int, Eigen::Dynamic, 3, Eigen::RowMajor>;       // #F x 3, vertex indices
using SkinWeights = Eigen::SparseMatrix<double, Eigen::RowMajor>;           // #V x joints, rows sum to 1

template <int N>
using Vec = Eigen::Matrix<double, N, 1>;
template <int N>
using Mat = Eigen::Matrix<double, N, N>;

}  // namespace pleat
