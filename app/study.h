// A study: everything that one configuration file says.
#pragma once

#include <string>
#include <vector>

#include "body/motion.h"
#include "campaign/crew.h"
#include "campaign/manifest.h"
#include "encode/make_dataset.h"
#include "evaluate/evaluate.h"
#include "learn/config.h"

namespace pleat::app {

struct BodyConfig {  // section `body`
  std::string file;  // SMPL-format .npz; `pleat body anny` makes the default one
};

struct MotionEntry {      // an item of `motions`
  std::string file;       // AMASS .npz or .bvh
  std::string name;       // by default the file's name without its ending
  double start_s = 0;     // the part to use
  double duration_s = 0;  // 0: to the end
  bool held_out = false;  // kept out of training
};

struct GarmentConfig {  // section `garment`
  int vertices = 2500;  // about
};

struct RowsConfig {    // section `sample_rows`
  int held_out = 200;  // rows sampled of each held-out split, evenly spread; 0: none
  int train = 20;      // and of the training split
};

struct ReportConfig {       // section `report`
  int frames = 6;           // shown as pictures
  int picture_width = 360;  // pixels
  int picture_height = 480;
};

constexpr double kMostBeta = 5;  // of |beta|

struct StudyConfig {
  std::string output;  // folder for everything that is made
  uint64_t seed = 1;
  int threads = 0;                 // 0: all cores
  std::string profile = "native";  // of arithmetic: core/profile.h
  BodyConfig body;
  std::vector<MotionEntry> motions;
  body::MotionConfig motion;
  std::vector<std::vector<double>> shapes = {{}};  // beta of each wearer; missing numbers are 0
  std::vector<garment::Design> designs;
  GarmentConfig garment;
  garment::FabricConfig fabric;
  sim::SimulationConfig simulation;
  campaign::Limits limits;
  encode::EncodeConfig encode;
  learn::TrainDesignConfig train_design;
  learn::TrainConfig train;
  learn::SampleConfig sample;
  RowsConfig rows;
  evaluate::EvaluateConfig evaluate;
  ReportConfig report;
};

// The checks of every section, and those across them. InputError naming the key.
void validate(const StudyConfig& study);

}  // namespace pleat::app
