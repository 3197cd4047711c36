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

// The reason of frames that took longer than they were allowed to: the only one that depends on the
// machine and not on the study alone.
constexpr const char* kOutOfTime = "out of time";

// What may be trusted about one drape.
struct Certificate {
  double residual = 0;     // |force imbalance| / |weight|, norms over all vertices
  bool is_stable = false;  // the Hessian of the energy is positive definite there
  double min_gap_m = 0;    // smallest signed distance of a vertex to the body, negative inside
  double max_strain = 0;   // largest principal stretch - 1
  double strain_95 = 0;    // 95th percentile over faces
  // Pairs of faces that cross or touch, by exact predicates:
  int body_intersections = 0;     // cloth and body, the skin pressed in where the body meets itself
  int overlap_intersections = 0;  // cloth and body as posed, there and next to it only
  int self_intersections = 0;     // cloth and cloth
  int iterations = 0;             // of the solver, all substeps of the frame
  int attempts = 1;               // 1: the first way served, or none did (see sim/chain.h)
  double seconds = 0;             // processor time
  bool is_accepted = false;
  std::string reason;  // why not, in one or two words; empty where accepted
};

// All that the drape of one frame starts from, to the last bit.
struct ClipState {
  int frame = 0;                 // counted from the start of the motion
  bool is_sound = true;          // the frame before was accepted, or there is none
  Points3 positions;             // #V x 3, m, world, at the end of the frame before
  Eigen::VectorXi anchor_faces;  // #V, body faces that vertices stick to; -1: none
  Points3 anchor_barycentrics;   // #V x 3, where on them
};

struct Clip {
  Design design;
  Fabric fabric;
  std::string motion_name;
  double frame_rate_hz = 30;
  Eigen::VectorXd shape;                  // beta
  int first_frame = 0;                    // of the motion; 0 but in parts of clips
  std::vector<body::Pose> poses;          // T
  std::vector<Points3> positions;         // T of #V x 3, m, world
  std::vector<Certificate> certificates;  // T
  std::vector<ClipState> states;          // of frames from which the clip can be taken up again
  std::string from_sha256;  // of the state that the first frame started from; empty: of none
  std::vector<std::string> frame_sha256;  // T; see below; filled by reading
};

// positions are stored as float32 (0.06 micrometres at 1 m). See docs/files.md.
void write_clip(const std::string& path, const Clip& clip, const std::string& key,
                const Provenance& provenance);
Clip read_clip(const std::string& path);       // InputError naming file and array
Clip read_clip_head(const std::string& path);  // the same without positions and states
// Frames first .. first + count - 1 of the file, and the states from which one of them starts.
Clip read_clip_frames(const std::string& path, int first, int count);
std::string clip_key(const std::string& path);

// SHA-256 of pose, positions as stored, and certificate without its seconds: of all that a frame
// has to say, and nothing of when and where it was made.
std::string frame_hash(const Clip& clip, int t);
std::string state_hash(const ClipState& state);
// Of the whole clip, from its key and frames.
std::string content_hash(const std::string& key, const std::vector<std::string>& frame_sha256);

// Parts of a clip that follow one another, each with the state at its end, as one file with the key
// and provenance of the first. Holds one frame of positions and one state at a time.
void join_clips(const std::vector<std::string>& parts, const std::string& path);

}  // namespace pleat::garment
