// Training: dataset.h5 -> checkpoints. Both stages give the same bits for the same seed, machine
// and threads.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/progress.h"
#include "core/provenance.h"
#include "learn/config.h"

namespace pleat::learn {

enum class TrainStatus { kFinished, kTimeUp, kInterrupted };

struct TrainResult {
  TrainStatus status = TrainStatus::kFinished;
  std::string checkpoint;      // path
  int64_t step = 0;            // done, of config.steps
  double seconds = 0;          // of training, all runs together
  double loss = 0;             // mean over the last steps of this run; NaN where it made none
  double validation_loss = 0;  // of the averaged weights; NaN without held-out rows
  int64_t parameters = 0;      // weights of the network
};

// Learns p(y | c) (paper, section 4.1) into <folder>/diffusion.h5, with the loss curve in
// <folder>/diffusion_loss.csv (step, loss, validation_loss, seconds). A checkpoint found there is
// continued, to the same bits as if it had never been left; one of another network, dataset or seed
// is refused (InputError). Only steps, max_minutes, checkpoint_minutes, preload_mb and threads may
// differ. should_stop is asked after each step; where it says yes the state is saved and the status
// is kInterrupted.
TrainResult train_diffusion(const TrainConfig& config, const std::string& dataset,
                            const std::string& folder, const Provenance& provenance,
                            const std::function<bool()>& should_stop = is_interrupted);

struct DesignError {
  std::string name;
  bool is_held_out = false;
  double mean_mm = 0, max_mm = 0;  // over the template's vertices
};

struct TrainDesignResult {
  TrainStatus status = TrainStatus::kFinished;
  std::string checkpoint;  // path; empty where interrupted
  double seconds = 0;
  std::vector<DesignError> designs;  // in the dataset's order
  double train_error_mm = 0;         // means over designs; NaN where there are none
  double held_out_error_mm = 0;
};

// Learns G_design from the dataset's training designs into <folder>/design.h5, with
// <folder>/design_loss.csv. Seconds long, so it starts over each time.
TrainDesignResult train_design(const TrainDesignConfig& config, const std::string& dataset,
                               const std::string& folder, const Provenance& provenance,
                               const std::function<bool()>& should_stop = is_interrupted);

}  // namespace pleat::learn
