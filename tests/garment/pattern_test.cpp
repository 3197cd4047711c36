#include "garment/pattern.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

namespace pleat::garment {
namespace {

double cross(const Eigen::RowVector2d& a, const Eigen::RowVector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

double length_of(Panel panel, Curve curve, const Design& design) {
  const Points2 half = half_outline(panel, design);
  const std::vector<Curve> curves = curves_of(panel);
  for (size_t c = 0; c < curves.size(); ++c) {
    if (curves[c] != curve) continue;
    double length = 0;
    for (size_t i = c * kCurveSegments; i < (c + 1) * kCurveSegments; ++i)
      length +=
          (half.row(static_cast<Eigen::Index>(i) + 1) - half.row(static_cast<Eigen::Index>(i)))
              .norm();
    return length;
  }
  ADD_FAILURE() << "no such curve";
  return 0;
}

double area(const Points2& polygon) {
  double sum = 0;
  for (Eigen::Index i = 0; i < polygon.rows(); ++i)
    sum += 0.5 * cross(polygon.row(i), polygon.row((i + 1) % polygon.rows()));
  return sum;
}

Design design(double length, double sleeve, double cleavage) {
  return {"", length, sleeve, cleavage, false};
}

TEST(Pattern, SewnCurvesAreEquallyLong) {
  for (const Design& d : paper_grid()) {
    EXPECT_NEAR(length_of(Panel::kFront, Curve::kSide, d), length_of(Panel::kBack, Curve::kSide, d),
                1e-12);
    EXPECT_NEAR(length_of(Panel::kFront, Curve::kShoulder, d),
                length_of(Panel::kBack, Curve::kShoulder, d), 1e-12);
    const double armhole = length_of(Panel::kFront, Curve::kArmhole, d);
    EXPECT_NEAR(armhole, length_of(Panel::kBack, Curve::kArmhole, d), 1e-12);
    EXPECT_NEAR(armhole, length_of(Panel::kLeftSleeve, Curve::kArmhole, d), 1e-9);
  }
}

TEST(Pattern, AxesSpanCropTopToDress) {
  const auto hem = [](const Design& d) { return -half_outline(Panel::kBack, d)(0, 1); };
  EXPECT_NEAR(hem(design(0, 0, 0)), 0.42, 1e-12);
  EXPECT_NEAR(hem(design(1, 0, 0)), 0.98, 1e-12);
  const auto neckline = [](const Design& d) {
    return -half_outline(Panel::kFront, d).bottomRows(1)(0, 1);
  };
  EXPECT_NEAR(neckline(design(0, 0, 0)), 0.07, 1e-12);
  EXPECT_NEAR(neckline(design(0, 0, 1)), 0.20, 1e-12);
  EXPECT_LT(neckline(design(0, 0, 1)), 0.235 - 0.02);  // above the underarm
  const auto sleeve = [](const Design& d) {
    const Points2 half = half_outline(Panel::kLeftSleeve, d);
    return half(half.rows() - 1, 1) - half(0, 1);
  };
  EXPECT_NEAR(sleeve(design(0, 0, 0)), 0.04, 1e-9);
  EXPECT_NEAR(sleeve(design(0, 1, 0)), 0.50, 1e-9);
  // Girths: two panels, two halves each.
  EXPECT_NEAR(4 * half_outline(Panel::kFront, design(0, 0, 0))(2 * kCurveSegments, 0), 1.06,
              0.02);  // underarm
  const double hem_girth = 4 * length_of(Panel::kFront, Curve::kHem, design(1, 0, 0));
  EXPECT_GT(hem_girth, 1.3);
  EXPECT_LT(hem_girth, 1.5);
}

TEST(Pattern, EveryAxisMovesMonotonically) {
  const auto total = [](const Design& d) {
    return area(outline(Panel::kFront, d)) + 2 * area(outline(Panel::kLeftSleeve, d));
  };
  for (int i = 0; i < 20; ++i) {
    const double a = i / 20.0, b = (i + 1) / 20.0;
    EXPECT_LT(total(design(a, 0.5, 0.5)), total(design(b, 0.5, 0.5)));
    EXPECT_LT(total(design(0.5, a, 0.5)), total(design(0.5, b, 0.5)));
    EXPECT_GT(total(design(0.5, 0.5, a)), total(design(0.5, 0.5, b)));
  }
}

TEST(Pattern, OutlinesAreMirrorSymmetricSimplePolygons) {
  for (const Design& d : paper_grid()) {
    for (const Panel panel : kPanels) {
      const Points2 polygon = outline(panel, d);
      const Eigen::Index n = polygon.rows();
      for (Eigen::Index i = 1; i < n; ++i) {
        EXPECT_EQ(polygon(i, 0), -polygon(n - i, 0));
        EXPECT_EQ(polygon(i, 1), polygon(n - i, 1));
      }
      EXPECT_GT(area(polygon), 0);
      for (Eigen::Index i = 0; i < n; ++i) {
        const Eigen::RowVector2d a = polygon.row(i), b = polygon.row((i + 1) % n);
        ASSERT_GT((b - a).norm(), 1e-4);
        for (Eigen::Index j = i + 2; j < n && (i > 0 || j < n - 1); ++j) {
          const Eigen::RowVector2d p = polygon.row(j), q = polygon.row((j + 1) % n);
          const bool crosses = cross(b - a, p - a) * cross(b - a, q - a) < 0 &&
                               cross(q - p, a - p) * cross(q - p, b - p) < 0;
          ASSERT_FALSE(crosses) << d.name << " panel " << static_cast<int>(panel);
        }
      }
    }
  }
}

TEST(Pattern, AGarmentTakesAsMuchClothAsGarmentsDo) {
  const auto total = [](const Design& d) {
    double sum = 0;
    for (const Panel panel : kPanels) sum += area(outline(panel, d));
    return sum;
  };
  // Two panels 0.53 m wide, less armholes (0.05 m^2) and neck, and the sleeves.
  EXPECT_NEAR(total(design(0, 0, 1)), 0.37, 0.04);
  EXPECT_NEAR(total(design(0.3, 0.25, 0.2)), 0.62, 0.05);
  EXPECT_NEAR(total(design(1, 1, 0)), 1.40, 0.15);
}

}  // namespace
}  // namespace pleat::garment
