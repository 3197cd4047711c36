// Vertex offsets <-> offset texture (paper, sections 3 and 5.1).
#pragma once

#include <Eigen/SparseCore>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "encode/uv_layout.h"

namespace pleat::encode {

// Offsets from the template in the T-pose, m. Float, as learners take it; channels first.
struct Texture {
  int size = 0;               // R
  std::vector<float> values;  // [3, R, R], row 0 is the top (v = 1)
};

// Metres a step of int16, for textures whose offsets are nowhere larger than this on one axis.
double fixed_point_scale(double largest_offset_m);
// Steps: every texel rounded to the nearest. A value outside of the scale's range is our own
// mistake (assert).
std::vector<int16_t> to_fixed_point(const Texture& texture, double scale_m);
Texture from_fixed_point(const std::vector<int16_t>& steps, int size, double scale_m);

// Bilinear reads at fixed places: up to four texels each, with weights that sum to 1.
struct TexelReads {
  Eigen::Matrix<int, Eigen::Dynamic, 4, Eigen::RowMajor> texels;      // #reads x 4
  Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor> weights;  // #reads x 4
};
// Empty texels get weight 0 and the others share theirs. InputError where a place touches no filled
// texel.
TexelReads bilinear_reads(const Eigen::Ref<const Points2>& uv, int size,
                          const std::vector<uint8_t>& mask);

Points3 read_texture(const Texture& texture, const TexelReads& reads);  // #reads x 3, m

// Texture -> offsets of the sewn vertices, m. reads: at topology.uv.
Points3 decode_texture(const Texture& texture, const garment::GarmentTopology& topology,
                       const TexelReads& reads);

enum class Fill {
  kBarycentric,  // each texel interpolates the face under it (the paper)
  kFitted        // corrected so that bilinear reads at the panel vertices return the offsets
};
Fill parse_fill(const std::string& name);  // "barycentric" or "fitted"

// Offsets of the sewn vertices -> texture. Keeps the factorisation that Fill::kFitted needs, one a
// layout.
class TextureEncoder {
 public:
  TextureEncoder(const garment::GarmentTopology& topology, UvLayout layout, Fill fill);
  ~TextureEncoder();
  TextureEncoder(TextureEncoder&&) noexcept;

  const UvLayout& layout() const { return layout_; }
  const TexelReads& reads() const { return reads_; }  // at the panel vertices
  Texture encode(const Eigen::Ref<const Points3>& offsets) const;

 private:
  struct Fit;
  void factorise(const garment::GarmentTopology& topology);

  UvLayout layout_;
  TexelReads reads_;
  std::vector<int> texels_;  // those that are filled, and what they take of the vertices' offsets,
  Eigen::SparseMatrix<double, Eigen::RowMajor> fill_;  // #filled x #vertices
  std::unique_ptr<Fit> fit_;                           // null with Fill::kBarycentric
};

}  // namespace pleat::encode
