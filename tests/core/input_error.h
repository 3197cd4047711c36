// EXPECT_INPUT_ERROR(statement, "part", ...): throws InputError whose message holds every part.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "core/error.h"

namespace pleat {

template <typename Action>
void expect_input_error(Action action, std::initializer_list<std::string> parts, const char* code,
                        const char* file, int line) {
  try {
    action();
  } catch (const InputError& error) {
    for (const std::string& part : parts) {
      if (std::string(error.what()).find(part) == std::string::npos) {
        ADD_FAILURE_AT(file, line) << "'" << error.what() << "' does not name '" << part << "'";
      }
    }
    return;
  }
  ADD_FAILURE_AT(file, line) << code << " throws no InputError";
}

}  // namespace pleat

#define EXPECT_INPUT_ERROR(statement, ...) \
  ::pleat::expect_input_error([&] { statement; }, {__VA_ARGS__}, #statement, __FILE__, __LINE__)
