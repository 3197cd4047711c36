#include "encode/mesh_decoder.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/mesh.h"
#include "encode/error_summary.h"
#include "tests/core/input_error.h"
#include "tests/encode/synthetic_body.h"

namespace pleat::encode {
namespace {

constexpr int kSize = 128;

struct Encoded {
  Tube tube = make_tube(16, 32);
  garment::Garment garment = tube_garment(tube, {"tee", 0.3, 0.25, 0.2, false});
  UvLayout layout = make_uv_layout(tube.topology, kSize);
  TextureEncoder encoder{tube.topology, layout, Fill::kFitted};
  Points3 offsets = tube_wrinkles(tube, 0.01, 2);
  Texture texture = encoder.encode(offsets);

  MeshDecoder decoder(const TriangleMesh& mesh) const {
    return MeshDecoder(tube.topology, kSize, layout.mask, mesh);
  }
};

TEST(MeshDecoder, OnTheGarmentsOwnMeshIsTheDecoder) {
  const Encoded encoded;
  const MeshDecoder decoder = encoded.decoder(layout_mesh(encoded.tube.topology));
  EXPECT_LT((decoder.offsets(encoded.texture) -
             decode_texture(encoded.texture, encoded.tube.topology, encoded.encoder.reads()))
                .cwiseAbs()
                .maxCoeff(),
            1e-15);
  const garment::Garment worn = decoder.worn(encoded.garment);
  EXPECT_LT((worn.t_pose - encoded.garment.t_pose).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT(Eigen::MatrixXd(worn.weights - encoded.garment.weights).cwiseAbs().maxCoeff(), 1e-12);
}

// Each triangle into four: old vertices decode as before, new ones near the middle of their edge.
TEST(MeshDecoder, OnASubdividedMeshFollowsTheSurface) {
  const Encoded encoded;
  TriangleMesh coarse = layout_mesh(encoded.tube.topology);
  coarse.vertices = encoded.garment.t_pose + encoded.offsets;
  const TriangleMesh fine = subdivide(coarse);
  const MeshDecoder decoder = encoded.decoder(fine);
  const Points3 decoded = decoder.worn(encoded.garment).t_pose + decoder.offsets(encoded.texture);
  ASSERT_EQ(decoded.rows(), fine.vertices.rows());
  const Eigen::VectorXd errors = vertex_distances_mm(decoded, fine.vertices);
  EXPECT_LT(errors.head(coarse.vertices.rows()).maxCoeff(), 0.5);
  EXPECT_LT(errors.mean(), 0.5);
}

// A vertex on a seam has two UVs; both sides count.
TEST(MeshDecoder, SeamsAgreeFromBothSides) {
  const Encoded encoded;
  const TriangleMesh mesh = layout_mesh(encoded.tube.topology);
  const Points3 decoded = encoded.decoder(mesh).offsets(encoded.texture);
  EXPECT_LT(vertex_distances_mm(decoded, encoded.offsets).maxCoeff(), 0.5);
  EXPECT_LT(decoded.rows(), mesh.uv.rows());
}

TEST(MeshDecoder, RefusesMeshesThatCannotBeRead) {
  const Encoded encoded;
  const TriangleMesh mesh = layout_mesh(encoded.tube.topology);
  TriangleMesh bare = mesh;
  bare.uv.resize(0, 2);
  bare.uv_faces.resize(0, 3);
  EXPECT_INPUT_ERROR(encoded.decoder(bare), "no UVs");
  TriangleMesh loose = mesh;
  loose.vertices.conservativeResize(mesh.vertices.rows() + 1, 3);
  EXPECT_INPUT_ERROR(encoded.decoder(loose), "on no face");
  TriangleMesh outside = mesh;
  outside.uv.row(7) << 0.5, 1.5;
  EXPECT_INPUT_ERROR(encoded.decoder(outside), "UV vertex 7", "[0,1]");
  outside.uv.row(7) << 0.999, 0.001;
  EXPECT_INPUT_ERROR(encoded.decoder(outside), "UV vertex 7", "outside of every panel");
}

}  // namespace
}  // namespace pleat::encode
