// A campaign of two designs, two shapes and two motions in a folder of its own, around the box
// body.
#pragma once

#include <algorithm>

#include "body/amass_file.h"
#include "body/body_file.h"
#include "campaign/manifest.h"
#include "tests/body/synthetic_body.h"
#include "tests/core/scratch.h"

namespace pleat::campaign {

// Swings an arm by so much a frame, rad.
inline void write_swing(const std::string& path, double swing) {
  body::Motion motion{"swing", 30, std::vector<body::Pose>(4)};
  for (int k = 0; k < 4; ++k) motion.frames[k].rotations.row(16) << 0, 0, -0.5 - swing * k;
  body::write_amass(path, motion, Vec<3>::Zero());
}

struct CampaignFiles {
  Scratch scratch;
  Campaign campaign;

  CampaignFiles() {
    campaign.body_file = scratch.path("body.npz");
    body::write_body(campaign.body_file, body::box_body());
    campaign.designs = {{"tee", 0.3, 0.25, 0.2, false}, {"dress", 0.9, 0.5, 0.4, false}};
    campaign.shapes = {Eigen::VectorXd(), Eigen::VectorXd::Constant(2, 0.5)};
    campaign.settings = "simulation: as is\n";
    for (const std::string name : {"walk", "jump"}) {
      const std::string file = scratch.path(name + ".npz");
      write_swing(file, name == "walk" ? 0.1 : 0.2);
      campaign.motions.push_back({name, file, {}, "motion: as is\n"});
    }
  }
};

}  // namespace pleat::campaign
