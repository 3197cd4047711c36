// Triangle meshes to pictures, without a display: ray tracing on the CPU (Embree).
#pragma once

#include <optional>
#include <vector>

#include "core/types.h"
#include "show/color.h"
#include "show/image.h"

namespace pleat::show {

struct RenderMesh {
  Points3 vertices;  // #V x 3, m, world (y up)
  Faces faces;       // counter-clockwise seen from outside
  Color color = kBodyColor;
  std::optional<Color>
      inside_color;  // of faces seen from behind; where empty, both sides look alike
  std::vector<Color> vertex_colors;  // #V, in place of `color`; empty for none
  double sheen = 0;  // light scattered by fibres at grazing view, 0 none .. 1 velvet
};

// A closed body, and cloth whose inside is told apart from its outside.
RenderMesh body_mesh(const Eigen::Ref<const Points3>& vertices, const Faces& faces);
RenderMesh cloth_mesh(const Eigen::Ref<const Points3>& vertices, const Faces& faces,
                      const Color& color = kSimulatedColor);

struct Camera {
  Vec<3> eye = Vec<3>(0, 1, 6);     // m, world
  Vec<3> target = Vec<3>(0, 1, 0);  // in the middle of the picture
  Vec<3> up = Vec<3>(0, 1, 0);
  double field_of_view_rad = 0.35;   // vertical, perspective
  double orthographic_height_m = 0;  // above 0: parallel projection of this height instead
};

enum class View {
  kFront,
  kSide,
  kBack,
  kThreeQuarter
};  // side: from the body's left; three-quarter: front left

// Looks at `target` from a side of a body that faces `yaw_rad`. What is `height_m` high at the
// target fills the picture from bottom to top, whatever the body does, so pictures of one target
// and height compare.
Camera view_camera(View view, const Vec<3>& target, double yaw_rad, double height_m = 2.1);

// Where a body faces whose root has this rotation (axis-angle): rad about +y, 0 facing +z, pi/2
// facing +x. 0 where it faces straight up or down.
double facing_yaw(const Vec<3>& root_rotation);

struct RenderConfig {  // section `render`
  int width = 480;     // pixels
  int height = 640;
  int samples_per_pixel = 16;  // a square number: stratified over the pixel
  int ambient_samples = 2;     // rays to the sky for each of them
  int key_samples = 1;         // rays to the key light for each of them
  Color background = Color(0.965, 0.96, 0.95);
  bool has_ground =
      true;  // shadows fall on the plane y = ground_height_m; unlit, it looks like the background
  double ground_height_m = 0;
};
void validate(const RenderConfig& config);  // throws InputError naming the key

// The same picture for the same input, whatever the number of threads. Throws InputError where a
// mesh has a vertex that is not finite, a face that names no vertex, or colours for another number
// of vertices.
Image render(const std::vector<RenderMesh>& meshes, const Camera& camera,
             const RenderConfig& config = {});

}  // namespace pleat::show
