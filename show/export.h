// Animated garments for other programs: OBJ sequence, PC2 point cache, glTF binary.
#pragma once

#include <string>
#include <vector>

#include "core/mesh.h"

namespace pleat::show {

// `frames`: positions of mesh.vertices over time, each #V x 3, m, y up. Every writer throws
// InputError where there is none, a frame has another number of vertices, or a number is not
// finite.

// folder/name_0000.obj, name_0001.obj, ...; the folder is made. Returns the paths, in order.
std::vector<std::string> write_obj_sequence(const std::string& folder, const std::string& name,
                                            const TriangleMesh& mesh,
                                            const std::vector<Points3>& frames);

// PC2: float32 positions of every vertex in every frame, as Blender's mesh cache modifier and
// others read it onto the first OBJ. One sample a frame.
void write_pc2(const std::string& path, const std::vector<Points3>& frames, double start_frame = 0);

struct PointCache {
  double start_frame = 0;
  double sample_rate = 1;  // frames from one sample to the next
  std::vector<Points3> frames;
};
PointCache read_pc2(const std::string& path);  // InputError naming the file

// One .glb file: the mesh with normals and UVs, animated by one morph target a frame, linear in
// between. Plays in any glTF 2.0 viewer that animates morph targets.
void write_glb(const std::string& path, const TriangleMesh& mesh,
               const std::vector<Points3>& frames, double frame_rate_hz);

}  // namespace pleat::show
