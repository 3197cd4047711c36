#include "show/render.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <omp.h>

#include <cmath>
#include <limits>

#include "core/error.h"

namespace pleat::show {
namespace {

RenderMesh sphere(const Vec<3>& centre, double radius, int rings = 64) {
  const int around = 2 * rings;
  RenderMesh mesh;
  mesh.vertices.resize((rings + 1) * around, 3);
  mesh.faces.resize(2 * rings * around, 3);
  int face = 0;
  for (int j = 0; j <= rings; ++j) {
    for (int i = 0; i < around; ++i) {
      const double theta = M_PI * j / rings, phi = 2 * M_PI * i / around;
      mesh.vertices.row(j * around + i) =
          centre.transpose() + radius * Vec<3>(std::sin(theta) * std::sin(phi), std::cos(theta),
                                               std::sin(theta) * std::cos(phi))
                                            .transpose();
      if (j == rings) continue;
      const int a = j * around + i, b = j * around + (i + 1) % around;
      mesh.faces.row(face++) << a, a + around, b;
      mesh.faces.row(face++) << b, a + around, b + around;
    }
  }
  return mesh;
}

RenderMesh square(const Vec<3>& centre, double half, bool faces_forward) {
  RenderMesh mesh;
  mesh.vertices.resize(4, 3);
  mesh.vertices << -half, -half, 0, half, -half, 0, half, half, 0, -half, half, 0;
  mesh.vertices.rowwise() += centre.transpose();
  mesh.faces.resize(2, 3);
  mesh.faces << 0, 1, 2, 0, 2, 3;  // seen from +z
  if (!faces_forward) mesh.faces.col(1).swap(mesh.faces.col(2));
  return mesh;
}

Camera parallel(double height) {
  Camera camera;
  camera.eye = {0, 0, 5};
  camera.target = {0, 0, 0};
  camera.orthographic_height_m = height;
  return camera;
}

RenderConfig small_picture() {
  RenderConfig config;
  config.width = 96;
  config.height = 128;
  config.has_ground = false;
  config.background = Color(1, 1, 1);
  return config;
}

// Mean of the channels, 0 .. 255, over a rectangle.
Vec<3> mean(const Image& image, int left, int top, int width, int height) {
  Vec<3> sum = Vec<3>::Zero();
  for (int y = top; y < top + height; ++y) {
    for (int x = left; x < left + width; ++x) {
      for (int c = 0; c < 3; ++c) sum[c] += image.rgb[3 * (size_t(y) * image.width + x) + c];
    }
  }
  return sum / (width * height);
}

TEST(Render, SphereCoversItsDisc) {
  RenderMesh ball = sphere({0, 0, 0}, 0.5);
  ball.color = Color(0, 0, 0);  // black on white: a pixel's light is the uncovered share of it
  const RenderConfig config = small_picture();
  const Image image = render({ball}, parallel(2), config);
  double covered = 0;
  for (size_t i = 0; i < image.rgb.size(); i += 3) {
    covered += 1 - linear_from_srgb(Color::Constant(image.rgb[i] / 255.0))[0];
  }
  const double radius_pixels = 0.25 * config.height;
  EXPECT_NEAR(covered, M_PI * radius_pixels * radius_pixels, 0.01 * covered);
}

TEST(Render, PerspectiveShowsTheTangentCone) {
  RenderMesh ball = sphere({0, 0, 0}, 0.5);
  ball.color = Color(0, 0, 0);
  Camera camera = parallel(0);
  camera.eye = {0, 0, 6};
  const RenderConfig config = small_picture();
  const Image image = render({ball}, camera, config);
  double covered = 0;
  for (size_t i = 0; i < image.rgb.size(); i += 3) {
    covered += 1 - linear_from_srgb(Color::Constant(image.rgb[i] / 255.0))[0];
  }
  const double tangent = 0.5 / std::sqrt(6.0 * 6.0 - 0.5 * 0.5);
  const double radius_pixels = tangent / std::tan(camera.field_of_view_rad / 2) * config.height / 2;
  ASSERT_LT(radius_pixels, config.width / 2);
  EXPECT_NEAR(covered, M_PI * radius_pixels * radius_pixels, 0.01 * covered);
}

TEST(Render, KeyLightComesFromTheUpperLeft) {
  const Image image = render({sphere({0, 0, 0}, 0.5)}, parallel(1.5), small_picture());
  const double left = mean(image, 24, 60, 8, 8)[1], right = mean(image, 64, 60, 8, 8)[1];
  const double top = mean(image, 44, 30, 8, 8)[1], bottom = mean(image, 44, 90, 8, 8)[1];
  EXPECT_GT(left, right + 30);
  EXPECT_GT(top, bottom + 30);
}

TEST(Render, HidesWhatIsBehind) {
  RenderMesh front = square({0, 0, 1}, 0.6, true), behind = square({0, 0, 0}, 0.4, true);
  front.color = Color(0, 0, 1);
  behind.color = Color(1, 0, 0);
  const Image image = render({behind, front}, parallel(1), small_picture());
  EXPECT_EQ(mean(image, 0, 0, 96, 128)[0], 0);  // no red anywhere
  EXPECT_GT(mean(image, 0, 0, 96, 128)[2], 50);
}

TEST(Render, ShowsTheInsideInItsOwnColour) {
  RenderMesh cloth = square({0, 0, 0}, 0.6, false);
  cloth.color = Color(0, 0, 1);
  EXPECT_EQ(mean(render({cloth}, parallel(1), small_picture()), 40, 60, 8, 8)[0], 0);
  cloth.inside_color = Color(1, 0, 0);
  const Vec<3> inside = mean(render({cloth}, parallel(1), small_picture()), 40, 60, 8, 8);
  EXPECT_GT(inside[0], 50);
  EXPECT_EQ(inside[2], 0);
  cloth.faces.col(1).swap(cloth.faces.col(2));
  const Vec<3> outside = mean(render({cloth}, parallel(1), small_picture()), 40, 60, 8, 8);
  EXPECT_EQ(outside[0], 0);
  EXPECT_NEAR(outside[2], inside[0], 1);  // both sides are lit alike
}

TEST(Render, FoldsAreDarkerThanOpenCloth) {
  // A wall close beside the cloth, on the side away from the key light, hides sky only.
  const RenderMesh cloth = square({0, 0, 0}, 2, true);
  RenderMesh wall = square({0, 0, 0}, 2, true);
  for (int i = 0; i < 4; ++i) {
    wall.vertices.row(i) = Eigen::RowVector3d(0.3, wall.vertices(i, 1), wall.vertices(i, 0));
  }
  const Image image = render({cloth, wall}, parallel(1), small_picture());
  EXPECT_LT(mean(image, 68, 60, 6, 8)[1], mean(image, 2, 60, 6, 8)[1] - 3);
}

TEST(Render, VertexColoursBlendAcrossFaces) {
  RenderMesh cloth = square({0, 0, 0}, 0.6, true);
  cloth.vertex_colors = {Color(1, 0, 0), Color(0, 0, 1), Color(0, 0, 1), Color(1, 0, 0)};
  const Image image = render({cloth}, parallel(1), small_picture());
  EXPECT_GT(mean(image, 0, 60, 8, 8)[0], 1.5 * mean(image, 88, 60, 8, 8)[0]);
  EXPECT_GT(mean(image, 88, 60, 8, 8)[2], 1.5 * mean(image, 0, 60, 8, 8)[2]);
}

TEST(Render, GroundShowsTheShadowAndNothingElse) {
  RenderConfig config = small_picture();
  config.has_ground = true;
  config.background = Color(0.8, 0.8, 0.8);
  const Camera camera = view_camera(View::kFront, {0, 0.5, 0}, 0, 2);
  const Image empty = render({}, camera, config);
  EXPECT_EQ(empty.rgb, blank_image(config.width, config.height, config.background).rgb);
  const Image image = render({sphere({0, 0.3, 0}, 0.3)}, camera, config);
  const int below = 64 + 38;  // just right of where the sphere touches the floor
  EXPECT_LT(mean(image, 56, below - 6, 6, 6)[0], 0.8 * 255 - 15);
  EXPECT_NEAR(mean(image, 0, 0, 96, 20)[0], 0.8 * 255, 1e-9);
}

TEST(Render, SamePictureForAnyNumberOfThreads) {
  RenderMesh cloth = cloth_mesh(sphere({0, 1, 0}, 0.4).vertices, sphere({0, 1, 0}, 0.4).faces);
  const std::vector<RenderMesh> meshes = {cloth, sphere({0, 0.4, 0.2}, 0.4)};
  const Camera camera = view_camera(View::kThreeQuarter, {0, 0.8, 0}, 0.3);
  RenderConfig config = small_picture();
  config.has_ground = true;
  const int threads = omp_get_max_threads();
  omp_set_num_threads(1);
  const Image one = render(meshes, camera, config);
  omp_set_num_threads(2);
  const Image two = render(meshes, camera, config);
  omp_set_num_threads(threads);
  EXPECT_EQ(one.rgb, two.rgb);
}

TEST(Render, RefusesBrokenMeshesAndSettings) {
  const Camera camera = parallel(1);
  RenderMesh mesh = square({0, 0, 0}, 1, true);
  mesh.faces(0, 0) = 4;
  EXPECT_THROW(render({mesh}, camera, small_picture()), InputError);
  mesh.faces(0, 0) = -1;
  EXPECT_THROW(render({mesh}, camera, small_picture()), InputError);
  mesh = square({0, 0, 0}, 1, true);
  mesh.vertices(2, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(render({mesh}, camera, small_picture()), InputError);
  mesh = square({0, 0, 0}, 1, true);
  mesh.vertex_colors.resize(3);
  EXPECT_THROW(render({mesh}, camera, small_picture()), InputError);
  RenderConfig config;
  config.samples_per_pixel = 10;
  try {
    validate(config);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("render.samples_per_pixel"));
  }
  Camera nowhere;
  nowhere.eye = nowhere.target;
  EXPECT_THROW(render({}, nowhere, small_picture()), InputError);
}

TEST(ViewCamera, StandsWhereTheBodyFaces) {
  const Vec<3> target(2, 1, -3);
  const double yaw = M_PI / 2;  // the body faces +x, its left is -z
  const auto side_of_target = [&](View view) {
    Vec<3> away = view_camera(view, target, yaw).eye - target;
    away[1] = 0;
    return Vec<3>(away.normalized());
  };
  EXPECT_LT((side_of_target(View::kFront) - Vec<3>(1, 0, 0)).norm(), 1e-9);
  EXPECT_LT((side_of_target(View::kBack) - Vec<3>(-1, 0, 0)).norm(), 1e-9);
  EXPECT_LT((side_of_target(View::kSide) - Vec<3>(0, 0, -1)).norm(), 1e-9);
}

TEST(ViewCamera, GivenHeightFillsThePicture) {
  const Camera camera = view_camera(View::kSide, {0, 1, 0}, 0.7, 1.8);
  EXPECT_NEAR(2 * (camera.eye - camera.target).norm() * std::tan(camera.field_of_view_rad / 2), 1.8,
              1e-12);
}

TEST(FacingYaw, ReadsTheHeadingOfTheRoot) {
  EXPECT_DOUBLE_EQ(facing_yaw({0, 0, 0}), 0);
  EXPECT_NEAR(facing_yaw({0, 1.2, 0}), 1.2, 1e-12);
  EXPECT_NEAR(facing_yaw({0, -2.5, 0}), -2.5, 1e-12);
  EXPECT_NEAR(facing_yaw({0.4, 0, 0}), 0, 1e-12);      // leaning forward
  EXPECT_DOUBLE_EQ(facing_yaw({-M_PI / 2, 0, 0}), 0);  // on its back, facing straight up
}

}  // namespace
}  // namespace pleat::show
