// Configuration files to structs and back (only user of yaml-cpp).
#pragma once

#include <string>

#include "app/study.h"

namespace pleat::app {

// Reads and validates. InputError with file, line and key: unknown key (with the nearest known
// one), wrong type, wrong value.
StudyConfig read_study(const std::string& path);

// The same of a text that a file holds, which errors call `name`.
StudyConfig read_study_text(const std::string& text, const std::string& name);
// A study by its file, or by the folder that it has made, which may have moved since.
StudyConfig read_study_or_folder(const std::string& path);

// The effective configuration of the whole study, every key with its value, as YAML that read_study
// takes.
std::string to_yaml(const StudyConfig& study);

// The same of what drapes depend on beside their fabric; and of a motion's cleaning and cut.
std::string simulation_settings(const StudyConfig& study);
std::string motion_settings(const body::MotionConfig& config);
// And of single sections, for the keys of the stages behind.
std::string encode_settings(const StudyConfig& study);
std::string train_settings(const StudyConfig& study);
std::string sample_settings(const StudyConfig& study);
std::string evaluate_settings(const StudyConfig& study);
std::string report_settings(const StudyConfig& study);

}  // namespace pleat::app
