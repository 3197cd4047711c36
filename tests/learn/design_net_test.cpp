#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "core/error.h"
#include "core/hdf5_file.h"
#include "learn/sample.h"
#include "learn/train.h"
#include "synthetic_dataset.h"

namespace pleat::learn {
namespace {

TEST(DesignNet, FitsALinearFamilyAndItsHeldOutDesign) {
  const TemporaryFolder folder;
  write_synthetic_dataset(folder / "dataset.h5", {});
  const TrainDesignResult result =
      train_design({}, folder / "dataset.h5", folder.path(), Provenance{});
  ASSERT_EQ(result.designs.size(), 6U);
  EXPECT_TRUE(result.designs[5].is_held_out);
  EXPECT_LT(result.train_error_mm, 1);      // the designs differ by up to 1 m
  EXPECT_LT(result.held_out_error_mm, 20);  // five designs tell four planes

  const Hdf5File dataset = Hdf5File::open(folder / "dataset.h5");
  const std::vector<double> p = dataset.read<double>("designs/parameters");
  const std::vector<double> vertices = dataset.read<double>("designs/vertices");
  const Eigen::MatrixXd uv = dataset.read_matrix("garment/uv");
  const DesignShape shape = predict_design(result.checkpoint, {Vec<3>(p[3], p[4], p[5])}).at(0);
  const Points3 truth = Eigen::Map<const Points3>(vertices.data() + 30 * 3, 30, 3);
  const double error_mm = 1e3 * (shape.vertices - truth).rowwise().norm().mean();
  EXPECT_NEAR(error_mm, result.designs[1].mean_mm, 1e-3);
  EXPECT_LT((shape.uv - uv).cwiseAbs().maxCoeff(), 1e-5);
}

TEST(DesignNet, LearnsTheOnlyDesignThereIs) {
  const TemporaryFolder folder;
  SyntheticDataset options;
  options.designs = 2;
  write_synthetic_dataset(folder / "dataset.h5", options);
  TrainDesignConfig config;
  config.steps = 10;
  const TrainDesignResult result =
      train_design(config, folder / "dataset.h5", folder.path(), Provenance{});
  EXPECT_LT(result.train_error_mm, 1e-3);
  EXPECT_TRUE(std::isfinite(result.held_out_error_mm));
}

TEST(DesignNet, RefusesBadFiles) {
  const TemporaryFolder folder;
  SyntheticDataset options;
  options.designs = 1;  // held out: none to train on
  write_synthetic_dataset(folder / "none.h5", options);
  EXPECT_THROW(train_design({}, folder / "none.h5", folder.path(), Provenance{}), InputError);
  options.designs = 3;
  options.left_out = "designs/vertices";
  write_synthetic_dataset(folder / "missing.h5", options);
  EXPECT_THROW(train_design({}, folder / "missing.h5", folder.path(), Provenance{}), InputError);
  EXPECT_THROW(predict_design(folder / "missing.h5", {Vec<3>::Zero()}), InputError);
  EXPECT_THROW(predict_design(folder / "nowhere.h5", {Vec<3>::Zero()}), InputError);
}

}  // namespace
}  // namespace pleat::learn
