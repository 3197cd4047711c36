// From a configuration to chains: every design on every shape through every motion, each with its
// content key.
#pragma once

#include <string>
#include <vector>

#include "body/motion.h"
#include "garment/design.h"
#include "garment/fabric.h"
#include "sim/chain.h"

namespace pleat::campaign {

struct MotionSource {
  std::string name;
  std::string file;
  body::MotionConfig config;
  std::string settings;  // the effective configuration above as text, for the key
};

struct Campaign {
  std::vector<garment::Design> designs;
  std::vector<Eigen::VectorXd> shapes;  // beta
  std::vector<MotionSource> motions;
  int garment_vertices = 2500;
  garment::FabricConfig fabric;
  sim::SimulationConfig simulation;
  std::string body_file;
  std::string settings;  // effective configuration of the simulation as text, for the keys
  uint64_t seed = 1;     // of fabrics that are drawn
};

struct Chain {
  std::string key;  // hash of everything that the drapes depend on
  int design = 0, shape = 0, motion = 0;
  garment::Fabric fabric;  // drawn for this chain; its garment settled in the middle of the ranges
};

struct Manifest {
  std::vector<std::string> garment_keys;  // a design
  std::vector<Chain> chains;              // sorted by motion, design, shape
};

// Hashes the body and the motion files, and draws the fabrics. InputError where one is missing, or
// two motions or designs share a name.
Manifest plan(const Campaign& campaign);

std::string garment_path(const std::string& folder, const std::string& key);
std::string shard_path(const std::string& folder, const std::string& key);

// manifest.json: a row a chain, with names for people and keys for programs.
void write_manifest(const std::string& path, const Campaign& campaign, const Manifest& manifest);

}  // namespace pleat::campaign
