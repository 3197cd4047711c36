// `pleat-learn`: `pleat` with LibTorch.
#include "app/program.h"
#include "learn/sample.h"
#include "learn/train.h"

namespace pleat::app {
namespace {

std::optional<TrainSummary> train(const StudyConfig& study, const std::string& dataset,
                                  const std::string& models, const Provenance& design_provenance,
                                  const Provenance& provenance) {
  const auto design = learn::train_design(study.train_design, dataset, models, design_provenance);
  if (design.status == learn::TrainStatus::kInterrupted) return std::nullopt;
  const auto model = learn::train_diffusion(study.train, dataset, models, provenance);
  if (model.status == learn::TrainStatus::kInterrupted) return std::nullopt;
  return TrainSummary{model.step, model.parameters, model.validation_loss, design.train_error_mm};
}

}  // namespace
}  // namespace pleat::app

int main(int argc, char** argv) {
  return pleat::app::run_program(
      argc, argv, {pleat::app::train, pleat::learn::rows_of_split, pleat::learn::sample_textures});
}
