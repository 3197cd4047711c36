// A clip: one design on one body shape through one motion, a static drape a frame. What sim/ makes,
// campaign/ keeps as a shard, and encode/ reads.
#pragma once

#include <string>
#include <vector>

#include "body/motion.h"
#include "core/provenance.h"
#include "core/types.h"
#include "garment/design.h"
#include "garment/fabric.h"

namespace pleat::garment {

// What may be trusted about one drape.
struct Certificate {
  double residual = 0;     // |force imbalance| / |weight|, norms over all vertices
  bool is_stable = false;  // the Hessian of the energy is positive definite there
  double min_gap_m = 0;    // smallest signed distance of a vertex to the body, negative inside
  double max_strain = 0;   // largest principal stretch - 1
  double strain_95 = 0;    // 95th percentile over faces
  // Pairs of faces that cross or touch, by exact predicates:
  int body_intersections = 0;     // cloth and body, the skin pressed in where the body meets itself
  int overlap_intersections = 0;  // cloth and body as posed, in those places only
  int self_intersections = 0;     // cloth and cloth
  int iterations = 0;             // of the solver, all substeps of the frame
  double seconds = 0;             // processor time
  bool is_accepted = false;
  std::string reason;  // why not, in one or two words; empty where accepted
};

struct Clip {
  Design design;
  Fabric fabric;
  std::string motion_name;
  double frame_rate_hz = 30;
  Eigen::VectorXd shape;                  // beta
  std::vector<body::Pose> poses;          // T
  std::vector<Points3> positions;         // T of #V x 3, m, world
  std::vector<Certificate> certificates;  // T
};

// positions are stored as float32 (0.06 micrometres at 1 m). See docs/files.md.
void write_clip(const std::string& path, const Clip& clip, const std::string& key,
                const Provenance& provenance);
Clip read_clip(const std::string& path);  // InputError naming file and array
std::string clip_key(const std::string& path);

}  // namespace pleat::garment
