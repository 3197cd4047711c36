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
  std::string profile = "native";  // of arithmetic: see core/profile.h
  std::string settings;  // effective configuration of the simulation as text, for the keys
  uint64_t seed = 1;     // of fabrics that are drawn
};

struct Chain {
  std::string key;  // hash of everything that the drapes depend on
  int design = 0, shape = 0, motion = 0;
};

// The fabric drawn for this chain; its garment is settled in the middle of the ranges.
garment::Fabric fabric_of(const Campaign& campaign, const Chain& chain);

struct Manifest {
  std::vector<std::string> garment_keys;  // a design
  std::vector<Chain> chains;              // sorted by motion, design, shape
};

// Hashes the body and the motion files. InputError where one is missing, or two motions or designs
// share a name.
Manifest plan(const Campaign& campaign);

// manifest.jsonl, which names what a campaign's folder is to hold: JSON Lines, a head with the
// designs, then a row a chain.
void write_manifest(const std::string& folder, const Campaign& campaign, const Manifest& manifest);

struct ManifestRow {
  std::string key, garment_key, motion, design;
  std::vector<double> shape;
};
struct ManifestFile {
  std::string profile;
  std::vector<std::string> garment_keys;
  std::vector<ManifestRow> chains;
};
ManifestFile read_manifest(const std::string& folder);  // InputError naming file and line

}  // namespace pleat::campaign
