#include "encode/unpose.h"

#include "core/error.h"

namespace pleat::encode {

Skinning parse_skinning(const std::string& name) {
  if (name == "linear") return Skinning::kLinear;
  if (name == "dual_quaternion") return Skinning::kDualQuaternion;
  throw InputError("encode.skinning = " + name + "; expected linear or dual_quaternion");
}

std::string skinning_name(Skinning skinning) {
  return skinning == Skinning::kLinear ? "linear" : "dual_quaternion";
}

Points3 unpose(const garment::Garment& garment, const Eigen::Ref<const Points3>& posed,
               const std::vector<body::Transform>& transforms, Skinning skinning,
               Eigen::VectorXd* smallest_singular_value) {
  if (skinning == Skinning::kLinear) {
    return body::unskin_linear(posed, garment.weights, transforms, smallest_singular_value) -
           garment.t_pose;
  }
  if (smallest_singular_value) *smallest_singular_value = Eigen::VectorXd::Ones(posed.rows());
  return body::unskin_dual_quaternion(posed, garment.weights, transforms) - garment.t_pose;
}

Points3 pose(const garment::Garment& garment, const Eigen::Ref<const Points3>& offsets,
             const std::vector<body::Transform>& transforms, Skinning skinning) {
  const Points3 unposed = garment.t_pose + offsets;
  return skinning == Skinning::kLinear
             ? body::skin_linear(unposed, garment.weights, transforms)
             : body::skin_dual_quaternion(unposed, garment.weights, transforms);
}

}  // namespace pleat::encode
