#include "encode/drape_files.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/error.h"
#include "garment/garment_file.h"

namespace pleat::encode {
namespace {

bool have_one_topology(const garment::GarmentTopology& a, const garment::GarmentTopology& b) {
  return a.vertex_count == b.vertex_count && a.faces.rows() == b.faces.rows() &&
         a.faces == b.faces && a.panel_faces == b.panel_faces && a.uv.rows() == b.uv.rows() &&
         a.uv == b.uv;
}

}  // namespace

std::vector<garment::Garment> read_garments(const std::vector<std::string>& files) {
  if (files.empty()) throw InputError("no garment to encode; settle the designs first");
  std::vector<garment::Garment> garments;
  std::set<std::string> names;
  for (const std::string& file : files) {
    garments.push_back(garment::read_garment(file));
    if (!have_one_topology(garments.front().topology, garments.back().topology)) {
      throw InputError(file + ": has another topology than " + files.front() +
                       "; all designs of a dataset share one");
    }
    if (!names.insert(garments.back().design.name).second) {
      throw InputError(file + ": design " + garments.back().design.name + " comes twice");
    }
  }
  return garments;
}

int design_of(const garment::Clip& clip, const std::string& file,
              const std::vector<garment::Garment>& garments) {
  for (size_t i = 0; i < garments.size(); ++i) {
    const garment::Design& design = garments[i].design;
    if (design.name != clip.design.name) continue;
    const double difference = std::max({std::abs(design.length - clip.design.length),
                                        std::abs(design.sleeve - clip.design.sleeve),
                                        std::abs(design.cleavage - clip.design.cleavage)});
    if (difference > 1e-6) {
      throw InputError(file + ": its design " + design.name +
                       " has other parameters than the garment of that name");
    }
    return static_cast<int>(i);
  }
  throw InputError(file + ": no garment of its design " + clip.design.name + " was given");
}

garment::Clip load_clip(const std::string& file, int vertex_count) {
  garment::Clip clip = garment::read_clip(file);
  if (clip.poses.size() != clip.positions.size() ||
      clip.certificates.size() != clip.positions.size()) {
    throw InputError(file + ": poses, positions and certificates are not of equally many frames");
  }
  for (const Points3& positions : clip.positions) {
    if (positions.rows() != vertex_count) {
      throw InputError(file + ": positions of " + std::to_string(positions.rows()) +
                       " vertices; the garments have " + std::to_string(vertex_count));
    }
    if (!positions.allFinite())
      throw InputError(file + ": positions: holds a number that is not finite");
  }
  return clip;
}

}  // namespace pleat::encode
