// Studies in YAML.
#include "app/yaml_reader.h"
#include "tests/fuzz/input_file.h"

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  pleat::fuzz::load([&] { pleat::app::read_study_text(text, "study.yaml"); });
  return 0;
}
