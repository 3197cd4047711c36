// Rotations as SMPL stores them: axis times angle, rad.
#pragma once

#include "core/types.h"

namespace pleat::body {

Mat<3> rotation_matrix(const Vec<3>& axis_angle);
Vec<3> axis_angle(const Mat<3>& rotation);  // angle in 0..pi
// Angle of the rotation that leads from one to the other, rad, 0..pi.
double angle_between(const Vec<3>& axis_angle_a, const Vec<3>& axis_angle_b);
// Smallest rotation that turns direction `from` into direction `to`; neither needs unit length.
Mat<3> rotation_between(const Vec<3>& from, const Vec<3>& to);
// t = 0: a, t = 1: b, the shortest way round.
Vec<3> slerp(const Vec<3>& axis_angle_a, const Vec<3>& axis_angle_b, double t);

}  // namespace pleat::body
