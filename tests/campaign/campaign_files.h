// A campaign of two designs, two shapes and two motions in a folder of its own, around the box
// body.
#pragma once

#include <algorithm>
#include <filesystem>

#include "body/amass_file.h"
#include "body/body_file.h"
#include "campaign/folder.h"
#include "campaign/manifest.h"
#include "garment/clip.h"
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

// As a finished chain leaves it: three frames, the second rejected.
inline void write_shard(const CampaignFiles& files, const Chain& chain,
                        const std::string& folder = "") {
  garment::Clip clip;
  clip.design = files.campaign.designs[chain.design];
  clip.motion_name = files.campaign.motions[chain.motion].name;
  clip.shape = files.campaign.shapes[chain.shape];
  for (int t = 0; t < 3; ++t) {
    clip.poses.emplace_back();
    clip.positions.push_back(Points3::Constant(5, 3, t));
    garment::Certificate certificate;
    certificate.is_accepted = t != 1;
    certificate.reason = t == 1 ? "not settled" : "";
    certificate.seconds = 0.25;
    clip.certificates.push_back(certificate);
  }
  const std::string path = shard_path(files.scratch.path(folder), chain.key);
  std::filesystem::create_directories(std::filesystem::path(path).parent_path());
  garment::write_clip(path, clip, chain.key, {});
}

}  // namespace pleat::campaign
