#include "app/study.h"

#include <cmath>

#include "core/error.h"
#include "core/profile.h"

namespace pleat::app {

void validate(const StudyConfig& study) {
  if (study.output.empty()) throw InputError("output: missing; name the folder for what is made");
  if (study.body.file.empty())
    throw InputError("body.file: missing; `pleat body anny` makes the default body");
  if (study.motions.empty())
    throw InputError("motions: the list is empty; name at least one AMASS .npz or .bvh file");
  if (study.designs.empty())
    throw InputError("designs: the list is empty; give at least one design");
  if (study.shapes.empty())
    throw InputError("shapes: the list is empty; [[]] stands for the mean body");
  if (study.threads < 0) throw InputError("threads must be >= 0 (0: all cores)");
  if (!is_profile(study.profile))
    throw InputError("profile = " + study.profile + "; expected native or portable");
  for (const std::vector<double>& shape : study.shapes)
    for (double beta : shape)
      if (!(std::abs(beta) <= kMostBeta))
        throw InputError("shapes: every beta must lie in [-5, 5]");
  for (const MotionEntry& motion : study.motions)
    if (motion.file.empty()) throw InputError("motions: an item has no `file`");
  for (const garment::Design& design : study.designs) garment::validate(design);
  if (study.garment.vertices < 500 || study.garment.vertices > 50000)
    throw InputError("garment.vertices must lie in 500 .. 50000");
  if (study.rows.held_out < 0 || study.rows.train < 0)
    throw InputError("sample_rows: counts must be >= 0");
  if (study.report.frames < 1 || study.report.frames > 100)
    throw InputError("report.frames must lie in 1 .. 100");
  if (study.report.picture_width < 16 || study.report.picture_height < 16 ||
      study.report.picture_width > 4096 || study.report.picture_height > 4096)
    throw InputError("report.picture_width and report.picture_height must lie in 16 .. 4096");
  body::validate(study.motion);
  garment::validate(study.fabric);
  sim::validate(study.simulation);
  campaign::validate(study.limits);
  encode::validate(study.encode);
  learn::validate(study.train_design);
  learn::validate(study.train);
  learn::validate(study.sample);
  evaluate::validate(study.evaluate);
}

}  // namespace pleat::app
