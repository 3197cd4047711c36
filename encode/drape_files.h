// The files that drapes and their garments come from, checked against one another.
#pragma once

#include <string>
#include <vector>

#include "garment/clip.h"
#include "garment/template.h"

namespace pleat::encode {

struct DatasetInputs {
  std::vector<std::string> clip_files;  // rows come in this order
  std::vector<std::string>
      garment_files;  // one a design, of one topology; rows of `designs/...` in this order
  std::string body_file;
};

// InputError: none, of different topologies, or two of one name.
std::vector<garment::Garment> read_garments(const std::vector<std::string>& files);

// The garment that the clip is of. InputError where there is none with its design's numbers.
int design_of(const garment::Clip& clip, const std::string& file,
              const std::vector<garment::Garment>& garments);

// Whole, and of garments of so many vertices.
garment::Clip load_clip(const std::string& file, int vertex_count);

}  // namespace pleat::encode
